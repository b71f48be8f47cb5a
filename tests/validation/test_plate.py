"""A ball on a plate, by default, against the plate theory of Karas and of Zener.

Neither shares anything with the package. Karas (Ing.-Arch. 10, 237, 1939; W. Goldsmith, Impact,
1960, section 4.5): a simply supported Kirchhoff plate in its modes, and Hertz's law, in small
increments of time. Zener (Phys. Rev. 59, 669, 1941): an infinite plate, which answers a force with
the velocity F/(8 √(D ρ h)); the waves are back from the edges after the contact.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp

import aoimpact as ao
from aoimpact import Mesh

pytestmark = pytest.mark.slow

FloatArray = npt.NDArray[np.float64]

# Karas' example: a steel ball of 2 cm on a steel plate of 20 x 20 x .8 cm, 1 m/s.
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
SIDE, THICKNESS, RADIUS, VELOCITY = 0.2, 0.008, 0.01, 1.0

BENDING = STEEL.E * THICKNESS**3 / (12.0 * (1.0 - STEEL.nu**2))
MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * STEEL.rho
HERTZ = 4.0 / 3.0 * STEEL.E / (2.0 * (1.0 - STEEL.nu**2)) * math.sqrt(RADIUS)


@cache
def karas(step: float = 5e-8, modes: int = 60, lasts: float = 1e-4) -> tuple[FloatArray, float]:
    """Force, N, at steps of time, and the ball's velocity at their end, m/s."""
    odd = 2 * np.arange(modes) + 1
    square = (math.pi / SIDE) ** 2 * (odd[:, None] ** 2 + odd[None, :] ** 2).ravel()
    omega = math.sqrt(BENDING / (STEEL.rho * THICKNESS)) * square
    modal_mass = 0.25 * STEEL.rho * THICKNESS * SIDE**2
    cosine, sine = np.cos(omega * step), np.sin(omega * step)
    place, rate = np.zeros_like(omega), np.zeros_like(omega)
    ball, speed, forces = 0.0, VELOCITY, [0.0, 0.0]
    for _ in range(round(lasts / step)):
        between = max(1.5 * forces[-1] - 0.5 * forces[-2], 0.0)  # constant over the increment
        at_rest = between / (modal_mass * omega**2)
        off = place - at_rest
        place = at_rest + off * cosine + rate / omega * sine
        rate = rate * cosine - off * omega * sine
        ball += speed * step - 0.5 * between / MASS * step**2
        speed -= between / MASS * step
        forces.append(HERTZ * max(ball - float(place.sum()), 0.0) ** 1.5)
    return np.array(forces[1:]), speed


def zener() -> float:
    """The peak force, N: x₁ + A F moves as the ball does, where x₁ is the indentation."""
    share = 1.0 / (8.0 * math.sqrt(BENDING * STEEL.rho * THICKNESS))

    def slope(_: float, y: FloatArray) -> list[float]:
        force = HERTZ * max(y[0], 0.0) ** 1.5
        return [y[1] - share * force, -force / MASS]

    run = solve_ivp(slope, (0.0, 1e-4), [0.0, VELOCITY], rtol=1e-9, atol=1e-15, max_step=2e-7)
    return float(HERTZ * np.max(run.y[0]) ** 1.5)


def plate() -> ao.FEModel:
    """Quadratic bricks, finer towards the middle of the plate."""
    mesh = ao.box_mesh((2.0, 2.0, 1.0), (18, 18, 3), kind="hexahedron20")
    x, y, z = (mesh.nodes - [1.0, 1.0, 0.0]).T
    x, y = (0.5 * SIDE * (0.3 * c + 0.7 * np.sign(c) * np.abs(c) ** 2.2) for c in (x, y))
    nodes = np.column_stack([x, y, THICKNESS * z])

    def across(axis: int) -> FloatArray:
        return np.isclose(np.abs(nodes[:, axis]), 0.5 * SIDE)

    supports = [(np.flatnonzero(across(0)), "yz"), (np.flatnonzero(across(1)), "xz")]
    return ao.FEModel.from_mesh(Mesh(nodes, mesh.cells, "hexahedron20"), STEEL, fixed=supports)


@cache
def by_default() -> ao.Result:
    return ao.simulate(
        ao.ball(RADIUS, STEEL), plate().contact(point=(0.0, 0.0, THICKNESS)), VELOCITY
    )


def test_the_small_increments_are_small_and_the_modes_enough() -> None:
    peak = karas()[0].max()
    assert karas(step=1e-7)[0].max() == pytest.approx(peak, rel=1e-3)
    assert karas(modes=40)[0].max() == pytest.approx(peak, rel=1e-3)
    assert zener() == pytest.approx(peak, rel=5e-3)


def test_a_simply_supported_plate_by_karas() -> None:
    forces, _ = karas()
    hit = by_default()
    times = 5e-8 * np.arange(len(forces))
    within = times <= hit.duration
    ours = hit.at(times[within]).force
    assert hit.peak_force == pytest.approx(forces.max(), rel=0.02)
    assert np.abs(ours - forces[within]).max() < 0.03 * forces.max()


def test_most_of_what_the_ball_loses_is_bending_waves() -> None:
    assert -by_default().rebound_velocity == pytest.approx(-karas()[1], abs=0.02)
