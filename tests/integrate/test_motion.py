"""A body's motion in a run: against closed forms, SciPy, and the run's own record."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from scipy.integrate import solve_ivp

import aoimpact as ao
from aoimpact import ModalDamping, Rayleigh
from aoimpact.integrate import solve_adaptive
from aoimpact.integrate.motion import DenseMotion, ForcedMotion
from aoimpact.scene import Contact, Equations, Load, Plan, stepped

from slender import beam

# Their matrices are of no solid elements, in which a force at a node sinks in.
pytestmark = pytest.mark.filterwarnings("ignore:.*with_mesh:aoimpact.AOImpactWarning")

LAW = ao.Hertz(k=1e8)
BALL = ao.AOModel(m0=0.02, m=[0.4], k=[5e7])
DURATION = 4e-3
TIMES = np.linspace(0.0, DURATION, 41)
PULSE = np.array([0.0, 1e-3, 3e-3]), np.array([20.0, -50.0, 10.0])


def star(m0: float, damping: Any = None) -> ao.AOModel:
    return ao.AOModel(m0=m0, k0=1e5, m=[0.1, 0.2], k=[1e6, 1e7], damping=damping)


def full(damping: Any = None) -> ao.FullModel | ao.Body:
    K, M = beam(8, fixed=(0, 16))
    return ao.full(ao.FEModel(K=1e4 * K, M=M, damping=damping).contact(dof=7))


def interface() -> ao.Body:
    mesh = ao.box_mesh((0.4, 0.02, 0.02), (4, 1, 1), kind="hexahedron20")
    alu = ao.Material(E=70e9, nu=0.3, rho=2700)
    body = ao.FEModel.from_mesh(mesh, alu, fixed=[("xmin", "xyz")])
    tips = [body.contact(point=(x, 0.01, 0.02), direction=(0, 0, -1), radius=0) for x in (0.4, 0.2)]
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


def mass_under_growing_force(dt: float, steps: int) -> ForcedMotion:
    """1 kg without spring, at 2 m/s, under F = 6 t: x = 2 t + t³."""
    one = sp.csr_array(np.eye(1))
    forces = 6.0 * dt * np.arange(steps + 1)
    rule = ao.Newmark(dt=dt, beta=1 / 6, gamma=0.5)  # exact for accelerations linear in time
    equations = Equations(0.0 * one, one, 0.0 * one, np.eye(1), np.zeros(1), np.array([2.0]))
    return ForcedMotion(equations, rule, dt, forces[None])


def test_linear_acceleration_is_integrated_exactly() -> None:
    t = np.array([0.0, 0.5, 1.0, 2.0])
    u, v = mass_under_growing_force(0.25, 8).observed(None, t)
    np.testing.assert_allclose(u[0], 2.0 * t + t**3, rtol=1e-12)
    np.testing.assert_allclose(v[0], 2.0 + 3.0 * t**2, rtol=1e-12)


def test_between_the_steps_all_is_linear() -> None:
    forced = mass_under_growing_force(0.25, 8)
    t = np.array([0.25, 0.35, 0.5])
    u, v = forced.observed(None, t)
    np.testing.assert_allclose(u[0, 1], 0.6 * u[0, 0] + 0.4 * u[0, 2])
    np.testing.assert_allclose(v[0, 1], 0.6 * v[0, 0] + 0.4 * v[0, 2])
    assert forced.force(np.array([0.35]))[0, 0] == pytest.approx(6.0 * 0.35)
    np.testing.assert_allclose(forced.force_rate(np.array([0.1, 2.0])), 6.0)
    assert forced.duration == 2.0


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
    u, v = run.recorder.motion(target.body).observed(None, run.t[-1:])
    found, size = run[target], np.abs(run[target].coordinates).max()
    np.testing.assert_allclose(u[:, 0], found.coordinates, atol=1e-9 * size)
    speed = np.abs(found.rates).max()
    np.testing.assert_allclose(v[:, 0], found.rates, atol=1e-9 * speed)


def test_rows_of_a_forced_motion_are_products_with_the_coordinates() -> None:
    body, rule = full(), ao.Newmark(dt=1e-3, estimate=False)
    b = body.tips[0].b
    forces = np.sin(np.linspace(0.0, 3.0, 101))[None]
    forced = ForcedMotion(stepped(body).equations, rule, 1e-3, forces)
    t = np.array([0.0123, 0.05, 0.1])
    for seen, whole in zip(
        forced.observed(sp.csr_array(b[None]), t), forced.observed(None, t), strict=True
    ):
        np.testing.assert_allclose(seen[0], b @ whole)


def test_equations_of_a_star_have_its_receptance() -> None:
    body = star(0.01)
    made = stepped(body.modal)
    equations, (shape,) = made.equations, made.parts["shape"]
    K, M, B = equations.K.toarray(), equations.M.toarray(), equations.B[:, 0]
    for omega in (10.0, 3e3, 1e5):
        seen = shape @ np.linalg.solve(K - omega**2 * M, B)
        assert seen == pytest.approx(body.receptance(omega), rel=1e-10)


# --------------------------------------------------------------------------- dense motion


def motions(target: ao.AOModel, *, loaded: bool = False) -> tuple[DenseMotion, DenseMotion]:
    """The ball and the target of an impact at 1 m/s, the target pushed about as well."""
    loads = (Load(1, 0, *PULSE),) if loaded else ()
    plan = Plan(
        (BALL.modal, target.modal),
        (1.0, 0.0),
        (Contact(0, 0, 1, 0, LAW, 0.0),),
        loads,
        0.0,
        DURATION,
        True,
    )
    run = solve_adaptive(plan, ao.Adaptive(rtol=1e-10))[0]
    return run.motion(0), run.motion(1)


@pytest.mark.parametrize("target", [star(0.01), star(0.0)])
def test_the_contact_coordinates_are_those_of_the_record(target: ao.AOModel) -> None:
    times = TIMES[1:]  # when they touch, the force bends
    for dense in motions(target):
        rows = dense.run.plan.layout.body(dense.run.rows(times, energies=False), dense.body)
        place, speed = rows.port_displacements[0], rows.port_velocities[0]
        body = dense.run.plan.bodies[dense.body]
        u, v = dense.observed(body.shape, times)
        if body.residual is not None:  # a massless contact follows at once
            u, v = (
                u + body.residual * dense.force(times),
                v + body.residual * dense.force_rate(times),
            )
        np.testing.assert_allclose(u[0], place, atol=1e-12 * np.abs(place).max())
        np.testing.assert_allclose(v[0], speed, atol=1e-5 * np.abs(speed).max())


def stiffness(of: ao.AOModel) -> np.ndarray:
    """The matrix of its springs."""
    K = np.diag(np.concatenate([[of.k0 + of.k.sum()], of.k]))
    K[0, 1:] = K[1:, 0] = -of.k
    return K


def coordinates(of: ao.AOModel, q: np.ndarray) -> np.ndarray:
    """The contact's and the oscillators', which its springs move in each mode."""
    own, modes = of.k / of.m, of.modal
    gain = own[:, None] / np.subtract.outer(own, modes.omega**2)
    return np.vstack([modes.shape, gain * modes.shape]) @ q


def test_all_coordinates_follow_the_equations_of_motion() -> None:
    sizes = (BALL.n + 1, star(0.01).n + 1)
    K = scipy.linalg.block_diag(*(stiffness(one) for one in (BALL, star(0.01))))
    inverse = 1.0 / np.concatenate([[one.m0, *one.m] for one in (BALL, star(0.01))])
    n = sum(sizes)
    press, push = np.zeros(n), np.zeros(n)
    press[0], press[sizes[0]], push[sizes[0]] = -1.0, 1.0, 1.0

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        force = 1e8 * max(-press @ y[:n], 0.0) ** 1.5
        forces = press * force + push * np.interp(t, *PULSE)
        return np.concatenate([y[n:], inverse * (forces - K @ y[:n])])

    start = np.concatenate([np.zeros(n), np.ones(sizes[0]), np.zeros(sizes[1])])
    exact = solve_ivp(
        rates, (0.0, DURATION), start, "DOP853", TIMES, rtol=1e-11, atol=1e-14, max_step=1e-5
    ).y
    seen = [
        [coordinates(of, q) for q in dense.observed(None, TIMES)]
        for of, dense in zip((BALL, star(0.01)), motions(star(0.01), loaded=True), strict=True)
    ]
    places, speeds = (np.concatenate(values) for values in zip(*seen, strict=True))
    np.testing.assert_allclose(places, exact[:n], atol=1e-8 * np.abs(exact[:n]).max())
    np.testing.assert_allclose(speeds, exact[n:], atol=1e-6)


def test_the_force_presses_the_bodies_apart_and_its_rate_is_its_slope() -> None:
    projectile, target = motions(star(0.01))
    run = target.run
    np.testing.assert_array_equal(target.force(TIMES)[0], run.forces(TIMES)[0])
    np.testing.assert_array_equal(projectile.force(TIMES), -target.force(TIMES))
    peak, largest = run.events[0].peak_time, run.events[0].peak_force
    around = np.array([0.5 * peak, peak])
    step = 1e-4 * peak
    slope = (target.force(around + step) - target.force(around - step))[0] / (2.0 * step)
    scale = largest / peak
    np.testing.assert_allclose(target.force_rate(around)[0], slope, atol=1e-5 * scale)
    assert abs(target.force_rate(around)[0, 1]) < 1e-4 * scale


def test_loads_are_forces_too() -> None:
    (_, loaded) = motions(star(0.01), loaded=True)
    force = loaded.force(TIMES)[0] - loaded.run.forces(TIMES)[0]
    np.testing.assert_allclose(force, np.interp(TIMES, *PULSE), atol=1e-12)


def test_rows_of_a_dense_motion_are_products_with_the_coordinates() -> None:
    (_, dense) = motions(star(0.01))
    rows = np.array([[1.0, -2.0, 0.5]])
    for seen, whole in zip(dense.observed(rows, TIMES), dense.observed(None, TIMES), strict=True):
        np.testing.assert_allclose(seen, rows @ whole)
