"""Newmark's rule under given forces: closed forms, and the states of the run they came from."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import aoimpact as ao
from aoimpact.fem.damping import ModalDamping, Rayleigh
from aoimpact.fields.driven import Driven, Equations
from aoimpact.scene.bodies import player

from slender import beam

LAW = ao.Hertz(k=1e8)


def star(m0: float, damping: Any = None) -> ao.AOModel:
    return ao.AOModel(m0=m0, k0=1e5, m=[0.1, 0.2], k=[1e6, 1e7], damping=damping)


def full(damping: Any = None) -> ao.ContactPoint:
    K, M = beam(8, fixed=(0, 16))
    return ao.FEModel(K=1e4 * K, M=M, damping=damping).contact(dof=7)


def interface() -> ao.InterfaceModel:
    mesh = ao.box_mesh((0.4, 0.02, 0.02), (4, 1, 1), kind="hexahedron20")
    alu = ao.Material(E=70e9, nu=0.3, rho=2700)
    body = ao.FEModel.from_mesh(mesh, alu, fixed=[("xmin", "xyz")])
    tips = [body.contact(point=(x, 0.01, 0.02), direction=(0, 0, -1)) for x in (0.4, 0.2)]
    return ao.interface(tips, 8, contact_time=1e-3)


BODIES: dict[str, Any] = {
    "star": lambda: star(0.01),
    "massless": lambda: star(0.0),
    "damped star": lambda: star(0.01, Rayleigh(alpha=30.0, beta=1e-6)),
    "star with damped modes": lambda: star(0.01, ModalDamping(0.02)),
    "full": full,
    "damped full": lambda: full(Rayleigh(alpha=3.0, beta=1e-4)),
    "full with damped modes": lambda: full(ModalDamping(0.05)),
    "interface": interface,
}


def mass_under_growing_force(dt: float, steps: int) -> Driven:
    """1 kg without spring, at 2 m/s, under F = 6 t: x = 2 t + t³."""
    one = sp.csr_array(np.eye(1))
    forces = 6.0 * dt * np.arange(steps + 1)
    rule = ao.Newmark(dt=dt, beta=1 / 6, gamma=0.5)  # exact for accelerations linear in time
    equations = Equations(0.0 * one, one, 0.0 * one, np.eye(1), np.zeros(1), np.array([2.0]))
    return Driven(equations, rule, dt, forces[None], lambda values: values)


def test_linear_acceleration_is_integrated_exactly() -> None:
    t = np.array([0.0, 0.5, 1.0, 2.0])
    u, v = mass_under_growing_force(0.25, 8).observed(None, t)
    np.testing.assert_allclose(u[0], 2.0 * t + t**3, rtol=1e-12)
    np.testing.assert_allclose(v[0], 2.0 + 3.0 * t**2, rtol=1e-12)


def test_between_the_steps_all_is_linear() -> None:
    driven = mass_under_growing_force(0.25, 8)
    t = np.array([0.25, 0.35, 0.5])
    u, v = driven.observed(None, t)
    np.testing.assert_allclose(u[0, 1], 0.6 * u[0, 0] + 0.4 * u[0, 2])
    np.testing.assert_allclose(v[0, 1], 0.6 * v[0, 0] + 0.4 * v[0, 2])
    assert driven.force(np.array([0.35]))[0, 0] == pytest.approx(6.0 * 0.35)
    np.testing.assert_allclose(driven.force_rate(np.array([0.1, 2.0])), 6.0)
    assert driven.duration == 2.0


@pytest.mark.parametrize("which", BODIES)
def test_a_body_goes_through_the_states_of_its_run(which: str) -> None:
    body, dt = BODIES[which](), 1e-5
    rule = ao.Newmark(dt=dt, estimate=False)
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=0.5), velocity=1.0)
    target = scene.add(body)
    scene.connect(ball, target, LAW)
    pulses = np.array([0.0, 1e-3, 3e-3]), np.array([20.0, -50.0, 10.0])
    scene.apply(target, force=pulses)
    run = scene.simulate(duration=4e-3, solver=rule)
    one = player("body", body, 0.0)
    forces = np.zeros((one.ports, len(run.t)))
    forces[0] = run.contacts[0].force + np.interp(run.t, *pulses)
    core = one.stepped(ports=run.recorder.ports[target.body])
    driven = Driven(core.equations, rule, dt, forces, one.coordinates)
    u, v = driven.observed(None, run.t[-1:])
    found, size = run[target], np.abs(run[target].coordinates).max()
    np.testing.assert_allclose(u[:, 0], found.coordinates, atol=1e-9 * size)
    moving = slice(1 if which == "massless" else 0, None)  # no velocity of its own without mass
    speed = np.abs(found.rates[moving]).max()
    np.testing.assert_allclose(v[moving, 0], found.rates[moving], atol=1e-9 * speed)


def test_rows_are_products_with_the_coordinates() -> None:
    body, rule = full(), ao.Newmark(dt=1e-3, estimate=False)
    one = player("body", body, 0.0)
    forces = np.sin(np.linspace(0.0, 3.0, 101))[None]
    driven = Driven(one.stepped().equations, rule, 1e-3, forces, one.coordinates)
    t = np.array([0.0123, 0.05, 0.1])
    for seen, whole in zip(
        driven.observed(sp.csr_array(body.b[None]), t), driven.observed(None, t), strict=True
    ):
        np.testing.assert_allclose(seen[0], body.b @ whole)


def test_equations_of_a_star_have_its_receptance() -> None:
    body = star(0.01)
    equations = player("body", body, 0.0).stepped().equations
    K, M, B = equations.K.toarray(), equations.M.toarray(), equations.B[:, 0]
    for omega in (10.0, 3e3, 1e5):
        seen = B @ np.linalg.solve(K - omega**2 * M, B)
        assert seen == pytest.approx(body.receptance(omega), rel=1e-10)
