"""Quantities of interest compared between two runs whose difference is known."""

import re
from pathlib import Path

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.accuracy.quantities import IMPACT_CHOICES, QUANTITIES, SCENE_CHOICES


def run(mass=1.0, velocity=1.0, duration=0.01, **options):
    """A rigid mass on a linear spring on a wall: everything is a sine, of √(k/m)."""
    return ao.simulate(
        projectile=ao.rigid(mass=mass),
        target=ao.rigid(mass=float("inf")),
        law=ao.Linear(1e6),
        velocity=velocity,
        duration=duration,
        **options,
    )


@pytest.mark.parametrize(
    ("quantity", "power"),
    [("peak_force", 0.5), ("impulse", 1.0), ("contact_duration", 0.5)],
)
def test_numbers_scale_as_they_should(quantity, power):
    """Peak √(km) v, impulse 2mv, duration π√(m/k): of 1.21 kg against 1 kg."""
    assert QUANTITIES[quantity].difference(run(1.21), run(1.0)) == pytest.approx(1.21**power - 1)


def test_histories_are_compared_where_they_differ_most():
    """v sin ωt/ω at two speeds: the difference is in proportion at all times."""
    for quantity in ("force", "projectile_displacement"):
        assert QUANTITIES[quantity].difference(run(velocity=1.1), run()) == pytest.approx(0.1)


def test_histories_of_steps_are_compared_too():
    """Between two steps force is let go with a kink: k v dt/4 of a peak of 1000 N."""
    stepped = run(solver=ao.Newmark(dt=1e-6))
    assert QUANTITIES["force"].difference(stepped, run()) < 1e6 * 1e-6 / 4 / 1000


def test_rebound_is_relative_to_itself_unless_it_is_almost_nothing():
    assert QUANTITIES["rebound_velocity"].difference(run(velocity=1.1), run()) == pytest.approx(0.1)
    # Equal masses: the projectile is stopped, and only its initial velocity is a measure.
    stopped = ao.simulate(
        projectile=ao.rigid(mass=1.0),
        target=ao.rigid(mass=1.0),
        law=ao.Linear(1e6),
        velocity=1.0,
        duration=0.01,
    )
    assert QUANTITIES["rebound_velocity"].difference(stopped, stopped) == 0.0
    assert QUANTITIES["rebound_velocity"].difference(run(), stopped) == pytest.approx(
        10.0, rel=1e-6
    )


def test_how_long_motion_matters():
    hit = run()
    assert QUANTITIES["force"].span(hit) == pytest.approx(np.pi * 1e-3)
    assert QUANTITIES["target_displacement"].span(hit) == 0.01
    with pytest.warns(ao.AOImpactWarning, match="no contact"):
        untouched = run(duration=0.01, gap=1.0)
    assert QUANTITIES["force"].span(untouched) == 0.0


def test_no_force_in_either_is_no_difference():
    with pytest.warns(ao.AOImpactWarning, match="no contact"):
        untouched = run(gap=1.0)
    assert QUANTITIES["force"].difference(untouched, untouched) == 0.0
    assert QUANTITIES["force"].difference(run(), untouched) == np.inf


def test_every_quantity_is_on_its_page():
    page = (Path(__file__).parents[2] / "docs" / "scene-files.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`.*`)[^|]*\| ([^|]*?) *\| ([^|]*) \|$", page, flags=re.MULTILINE)
    table = {
        name: (unit, "an impact" in of, "a scene" in of)
        for names, unit, of in rows
        for name in re.findall(r"`(\w+)`", names)
    }
    for name, quantity in QUANTITIES.items():
        of_scenes = name in SCENE_CHOICES
        assert name in table, f"docs/scene-files.md has no row for {name}"
        assert table[name] == (quantity.unit, quantity.selectable, of_scenes)


@pytest.mark.parametrize(
    ("run_of", "choices"),
    [(ao.simulate, IMPACT_CHOICES), (ao.Scene.simulate, SCENE_CHOICES)],
    ids=["simulate", "Scene.simulate"],
)
def test_every_quantity_is_in_the_docstrings(run_of, choices):
    missing = [name for name in choices if f'"{name}"' not in run_of.__doc__]
    assert not missing, f"name them in the docstring of {run_of.__qualname__}, at `quantity`"


def test_every_quantity_has_a_difference():
    for quantity in QUANTITIES.values():
        assert quantity.difference(run(), run()) == 0.0


def test_the_way_to_the_first_contact_is_no_motion_that_models_must_hold() -> None:
    now, later = (
        ao.simulate(ao.rigid(mass=0.1), ao.rigid(mass=1.0), 1.0, law=ao.Hertz(k=1e9), gap=gap)
        for gap in (0.0, 0.5)
    )
    span = QUANTITIES["force"].span
    assert span(later) == pytest.approx(span(now), rel=1e-3)
    assert span(now) == pytest.approx(now.contact_duration, rel=1e-3)
