"""Impacts on one contact point share its model: each is right to its error, whoever computes it."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
NAMES = ("peak_force", "impulse", "contact_duration", "restitution", "rebound_velocity")


@cache
def tip() -> ao.ContactPoint:
    """A point of a plate of steel, off its centre."""
    mesh = ao.box_mesh((0.054, 0.054, 0.01), (4, 4, 1), kind="hexahedron20")
    return ao.FEModel.from_mesh(mesh, STEEL).contact(point=(0.03, 0.024, 0.01))


def balls(count: int = 3, **changes: Any) -> list[dict[str, Any]]:
    """Random balls at random speeds."""
    rng = np.random.default_rng(1)
    return [
        {"projectile": ao.ball(radius, STEEL), "target": tip(), "velocity": velocity} | changes
        for radius, velocity in rng.uniform((0.006, 0.5), (0.012, 3.0), (count, 2)).tolist()
    ]


def check_errors(cases: list[dict[str, Any]], kept: list[dict[str, float]]) -> None:
    """Both are within their errors of the truth, and so of each other within their sum."""
    for case, numbers in zip(cases, kept, strict=True):
        alone = ao.simulate(**case)
        for name in NAMES:
            known = numbers[f"{name}_error"] + alone.error[name].total
            scale = max(abs(alone.value(name)), 0.1 * case["velocity"])
            assert abs(numbers[name] - alone.value(name)) <= known * scale, name
            assert 0.0 < numbers[f"{name}_error"] < 0.05


@cache
def kept_of_balls() -> list[dict[str, float]]:
    return ao.simulate_many(balls(), keep=NAMES)


def test_each_is_what_simulate_gives_within_their_errors() -> None:
    check_errors(balls()[:2], kept_of_balls()[:2])


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"law": ao.Hertz.between(STEEL, 0.01, STEEL, float("inf")), "duration": 3e-4},
        {"gap": 1e-4, "solver": ao.Adaptive(rtol=1e-6)},
        {"law": ao.HuntCrossley(k=1.5e10, damping=0.1, relative_radius=0.01)},
        {"quantity": "impulse", "rtol": 1e-3},
    ],
)
def test_so_it_is_for_other_arguments(changes: dict[str, Any]) -> None:
    cases = balls(2, **changes)
    check_errors(cases, ao.simulate_many(cases, keep=NAMES))


@pytest.mark.slow
def test_two_meshed_bodies_share_both_models() -> None:
    mesh = ao.sphere_mesh(0.01, 0.008)
    ball = ao.FEModel.from_mesh(mesh, STEEL).contact(point=(0.0, 0.0, -0.01))
    cases = [case | {"projectile": ball} for case in balls(2)]
    check_errors(cases, ao.simulate_many(cases, keep=NAMES))


def test_kept_numbers_are_those_of_the_results() -> None:
    cases = balls(3)
    kept = ao.simulate_many(cases, keep=(*NAMES, "error.time"))
    for hit, numbers in zip(ao.simulate_many(cases), kept, strict=True):
        assert numbers.pop("error.time") == hit.error.time
        for name in NAMES:
            assert numbers[name] == hit.value(name)
            assert numbers[f"{name}_error"] == pytest.approx(hit.error[name].total, rel=1e-6)
            assert numbers[f"{name}_controlled"] == (hit.error[name].model <= hit.error.rtol)


def test_the_same_bits_in_any_order_from_any_worker(tmp_path: Path) -> None:
    cases, alone = balls(), kept_of_balls()
    assert ao.simulate_many(cases[::-1], keep=NAMES)[::-1] == alone
    assert ao.simulate_many(cases, 3, keep=NAMES) == alone
    with ProcessPoolExecutor(1) as pool:
        assert ao.simulate_many(cases, pool, keep=NAMES) == alone
    cases, alone = cases[:2], ao.simulate_many(cases[:2], keep=NAMES)
    for _ in range(2):  # computed, then read
        assert ao.simulate_many(cases, keep=NAMES, checkpoint=tmp_path / "cases") == alone


def test_an_impact_is_the_same_after_others_on_its_body() -> None:
    """Their patches lie elsewhere, and were fitted to another contact time."""
    bodies = [ao.FEModel.from_mesh(tip().body.mesh, STEEL) for _ in range(2)]
    tips = [[body.contact(point=(x, x, 0.01)) for x in (0.02, 0.034)] for body in bodies]
    scene, small = ao.Scene(), ao.ball(0.006, STEEL)
    target = scene.add(tips[0])
    for at, ball in enumerate((ao.ball(0.03, STEEL), small)):
        scene.connect(scene.add(ball, velocity=1.0), target.port(at))
    scene.simulate(duration=3e-4, quantity="peak_force")
    assert len({ao.simulate(small, own, 1.0).peak_force for _, own in tips}) == 1
