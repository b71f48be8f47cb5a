"""Impacts with the contact resolved, and those of patches and laws, which must give the same."""

from __future__ import annotations

import math
from functools import cache

import pytest
import resolved
from paperbodies import RESOLVED_DURATION, RESOLVED_FORCE
from resolved import Impact, Solid

pytestmark = pytest.mark.slow

STEEL = Solid(210e9, 0.3, 7800.0)
RADIUS = 0.01


@cache
def two_spheres(finest: float) -> Impact:
    """Each meets its mirror image at half the velocity: a rigid plane."""
    ball = resolved.ball(RADIUS, STEEL, finest, reach=0.45e-3)
    return resolved.strike(ball, None, 0.5, 64e-6)


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
