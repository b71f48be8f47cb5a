"""A ball on a plate of solid elements, by default, against waves of elasticity (`tests/navier.py`).

The plate is that of K. Karas (Ing.-Arch. 10, 237, 1939; W. Goldsmith, Impact, 1960, section 4.5):
steel, 20 x 20 x .8 cm, simply supported, under a steel ball of 2 cm at 1 m/s.
"""

from __future__ import annotations

import math

import navier
import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
SIDE, THICKNESS, RADIUS, STEP = 0.2, 0.008, 0.01, 2e-8


def plate() -> ao.FEModel:
    """Quadratic bricks, finer towards the middle of the plate."""
    mesh = ao.box_mesh((2.0, 2.0, 1.0), (18, 18, 3), kind="hexahedron20")
    x, y, z = (mesh.nodes - [1.0, 1.0, 0.0]).T
    x, y = (0.5 * SIDE * (0.3 * c + 0.7 * np.sign(c) * np.abs(c) ** 2.2) for c in (x, y))
    nodes = np.column_stack([x, y, THICKNESS * z])
    ends, sides = (np.isclose(np.abs(c), 0.5 * SIDE) for c in (x, y))
    supports = [(ends, "yz"), (sides, "xz")]
    return ao.FEModel.from_mesh(ao.Mesh(nodes, mesh.cells, mesh.kind), STEEL, fixed=supports)


@pytest.mark.slow
def test_the_plate_of_karas() -> None:
    """Most of what the ball loses goes into bending waves."""
    moduli = [STEEL.E] * 3, [STEEL.shear_modulus] * 3, [STEEL.nu] * 3
    plies = [navier.Sheet(THICKNESS / 4, navier.orthotropic(*moduli), STEEL.rho)] * 4
    waves = navier.plate((SIDE, SIDE), plies, 0.06 * RADIUS, moving=100)
    ball = ao.ball(RADIUS, STEEL)
    hertz = 2.0 / 3.0 * STEEL.plane_strain_modulus * math.sqrt(RADIUS)
    force, speed = navier.struck(waves, hertz, ball.mass, 1.0, 1e-4, STEP)
    hit = ao.simulate(ball, plate().contact(point=(0.0, 0.0, THICKNESS)), 1.0)
    times = STEP * np.arange(len(force))
    within = times <= hit.duration
    assert hit.peak_force == pytest.approx(force.max(), rel=0.02)
    assert np.abs(hit.at(times[within]).force - force[within]).max() < 0.03 * force.max()
    assert hit.rebound_velocity == pytest.approx(speed, abs=0.02)
