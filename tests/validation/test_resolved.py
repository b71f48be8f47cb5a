"""Impacts with the contact resolved, and those of patches and laws, which must give the same."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import resolved
from paperbodies import RESOLVED_DURATION, RESOLVED_FORCE
from resolved import Impact, Solid

from aoimpact import (
    FEModel,
    Hertz,
    Material,
    Mesh,
    antioscillators,
    box_mesh,
    paper_sphere_mesh,
    simulate,
)

pytestmark = pytest.mark.slow

STEEL, ALU = Solid(210e9, 0.3, 7800.0), Solid(70e9, 0.3, 2400.0)
RADIUS = 0.01
BLOCK = {"radius": 0.03, "height": 0.03}


@cache
def two_spheres(finest: float) -> Impact:
    """Each meets its mirror image at half the velocity: a rigid plane."""
    ball = resolved.ball(RADIUS, STEEL, finest, reach=0.45e-3)
    return resolved.strike(ball, None, 0.5, 64e-6)


@cache
def ball_on_block(finest: float) -> Impact:
    ball = resolved.ball(RADIUS, STEEL, finest, reach=0.8e-3)
    block = resolved.block(**BLOCK, solid=ALU, finest=finest, reach=0.8e-3, like=ball)
    return resolved.strike(ball, block, 1.0, 92e-6)


def test_two_spheres_resolved() -> None:
    coarse, middle, fine = (two_spheres(finest) for finest in (20e-6, 14e-6, 10e-6))
    # The last refinement moves the force by no more than the error claimed for it.
    assert abs(fine.peak - middle.peak) < 0.5
    assert fine.peak == pytest.approx(RESOLVED_FORCE, abs=0.5)
    assert abs(fine.duration - middle.duration) < abs(middle.duration - coarse.duration)
    assert fine.duration == pytest.approx(RESOLVED_DURATION, abs=0.03e-6)
    assert fine.restitution == pytest.approx(1.0, abs=2e-5)


def test_impulse_of_the_resolved_spheres_is_the_momentum_they_exchange() -> None:
    hit, ball = two_spheres(14e-6), resolved.ball(RADIUS, STEEL, 14e-6, reach=0.45e-3)
    impulse = hit.force.sum() * (hit.t[1] - hit.t[0])
    assert impulse == pytest.approx(ball.total_mass * 0.5 * (1.0 + hit.restitution), rel=1e-9)
    assert ball.total_mass == pytest.approx(4 / 3 * math.pi * RADIUS**3 * STEEL.rho, rel=5e-4)


def round_block(kind: str, around: int, layers: int) -> Mesh:
    """A cylinder under the origin: a box whose squares became discs, finer toward its middle."""
    mesh = box_mesh((2.0, 2.0, 1.0), (around, around, layers), kind=kind)
    x, y, z = (mesh.nodes - [1.0, 1.0, 1.0]).T
    x, y = (0.5 * c + 0.5 * c**3 for c in (x, y))
    disc = np.stack([x * np.sqrt(1 - 0.5 * y * y), y * np.sqrt(1 - 0.5 * x * x)], axis=1)
    depth = -(0.5 * -z + 0.5 * z**2)
    nodes = np.column_stack([BLOCK["radius"] * disc, BLOCK["height"] * depth])
    return Mesh(nodes, mesh.cells, kind)


def test_a_steel_ball_on_an_aluminium_block() -> None:
    middle, fine = ball_on_block(28e-6), ball_on_block(20e-6)
    error = abs(fine.peak / middle.peak - 1.0)
    assert error < 2e-3
    steel, alu = (Material(E=s.E, nu=s.nu, rho=s.rho) for s in (STEEL, ALU))
    ball = FEModel.from_mesh(paper_sphere_mesh(), steel)
    block = FEModel.from_mesh(round_block("hexahedron20", 12, 7), alu)
    tips = (
        ball.contact(point=(RADIUS, 0, 0), direction=(1, 0, 0), radius=0.003),
        block.contact(point=(0, 0, 0), direction=(0, 0, -1), radius=0.003),
    )
    projectile, target = (
        antioscillators(tip, n=12, method="krylov", contact_time=80e-6) for tip in tips
    )
    law = Hertz.between(steel, RADIUS, alu, math.inf)
    hit = simulate(projectile=projectile, target=target, law=law, velocity=1.0, duration=120e-6)
    assert hit.peak_force == pytest.approx(fine.peak, rel=5e-3)
    assert hit.contact_duration == pytest.approx(fine.duration, rel=5e-3)
    assert hit.restitution == pytest.approx(fine.restitution, abs=5e-3)
