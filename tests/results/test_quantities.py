"""Quantities of interest compared between two runs whose difference is known."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.accuracy import keeper
from aoimpact.results import IMPACT_CHOICES, QUANTITIES, SCENE_CHOICES


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


def test_rebound_is_relative_to_itself_unless_it_is_almost_nothing():
    assert QUANTITIES["rebound_velocity"].difference(run(velocity=1.1), run()) == pytest.approx(0.1)
    # Equal masses: the projectile is stopped, and only its initial velocity is a measure.
    stopped = ao.simulate(
        ao.rigid(mass=1.0), ao.rigid(mass=1.0), 1.0, law=ao.Linear(1e6), duration=0.01
    )
    assert QUANTITIES["rebound_velocity"].difference(stopped, stopped) == 0.0
    assert QUANTITIES["rebound_velocity"].difference(run(), stopped) == pytest.approx(
        10.0, rel=1e-6
    )


def test_how_long_motion_matters():
    hit = run()
    assert QUANTITIES["force"].span(hit) == pytest.approx(np.pi * 1e-3)
    assert QUANTITIES["target_displacement"].span(hit) == 0.01
    with pytest.warns(ao.AOImpactWarning, match=r"^projectile"):
        untouched = run(duration=0.01, gap=1.0)
    assert QUANTITIES["force"].span(untouched) == 0.0


def test_no_force_in_either_is_no_difference():
    with pytest.warns(ao.AOImpactWarning, match=r"^projectile"):
        untouched = run(gap=1.0)
    assert QUANTITIES["force"].difference(untouched, untouched) == 0.0
    assert QUANTITIES["force"].difference(run(), untouched) == np.inf


def test_every_quantity_is_on_its_page():
    page = (Path(__file__).parents[2] / "docs" / "scene-files.md").read_text(encoding="utf-8")
    # The words that a row begins with are names, those after them may be of anything.
    row = r"^\| (`\w+`(?:, `\w+`)*)[^|]*\| ([^|]*?) *\| ([^|]*) \|$"
    rows = re.findall(row, page, flags=re.MULTILINE)
    table = {
        name: (unit, "an impact" in of, "a scene" in of)
        for names, unit, of in rows
        for name in re.findall(r"`(\w+)`", names)
    }
    for name, quantity in QUANTITIES.items():
        of_scenes = name in SCENE_CHOICES
        assert name in table, f"docs/scene-files.md has no row for {name}"
        wanted = (quantity.unit, True, of_scenes)
        assert table[name] == wanted, f"{name}: unit, of an impact, of a scene"


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


# ------------------------------------------------------------- what was chosen for can be read

OMEGA = 1e3  # √(k/m) of `run`

# Of 1 kg that meets a wall at 1 m/s by a spring of 1 MN/m, half a sine; in the unit of summaries.
SPRING = {
    "peak_force": (1e6 / OMEGA, "N"),
    "peak_time": (0.5e3 * math.pi / OMEGA, "ms"),
    "contact_duration": (1e3 * math.pi / OMEGA, "ms"),
    "contact_count": (1.0, ""),
    "impulse": (2.0, "N s"),
    "rebound_velocity": (-1.0, "m/s"),
    "restitution": (1.0, ""),
}


def spring(**options):
    """The impact of `run` as a scene, and what its numbers are called."""
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=1.0), velocity=1.0, name="ball")
    wall = scene.add(ao.rigid(mass=math.inf))
    scene.connect(ball, wall, ao.Linear(1e6))
    return scene.simulate(duration=0.01, **options), ball


def in_scene(name):
    each = QUANTITIES[name].each
    return f"{each}.0.{name}" if each else name


def error_line(result):
    """What a summary says of the quantity of interest, in one string."""
    [line] = re.findall(r"^  error  +(.*)$", repr(result), flags=re.MULTILINE)
    return line


def test_every_number_has_a_closed_form_here():
    numbers = {name for name, one in QUANTITIES.items() if not (one.is_history or one.sliding)}
    assert set(SPRING) == numbers, "add its closed form for a spring to SPRING"


@pytest.mark.parametrize("name", SPRING)
def test_a_number_that_was_chosen_for_is_told_read_and_kept(name):
    value, unit = SPRING[name]
    hit, (scene, _) = run(quantity=name, rtol=1e-3), spring(quantity=name, rtol=1e-3)
    for result, called in ((hit, name), (scene, in_scene(name))):
        scale = 1e-3 if unit == "ms" else 1.0
        assert result.value(called) == pytest.approx(value * scale, rel=1e-3)
        error = ", certain" if QUANTITIES[name].count else " ± 0.0005 %"
        words, told = name.replace("_", " "), error_line(result)
        shown = re.match(rf"{words} (\S+?){f' {unit}'.rstrip()}( of ball)?{error} \(", told)
        assert shown, told
        assert float(shown[1]) == pytest.approx(value, rel=1e-3)
        assert told.endswith("; models and steps chosen for 0.1 %")
        kept = keeper([called])(result)
        assert kept[called] == result.value(called)
        assert kept[f"{called}_controlled"] == 1.0
        assert kept[f"{called}_error"] == result.error[called].total <= 1e-3


def test_every_body_that_is_not_held_at_rest_has_a_rebound_velocity():
    """Newton's cradle of two beside a wall that none of them meets."""
    scene = ao.Scene()
    balls = [scene.add(ao.rigid(mass=1.0), velocity=v) for v in (1.0, 0.0)]
    wall = scene.add(ao.rigid(mass=math.inf))
    scene.connect(*balls, ao.Linear(k=1e8))
    scene.connect(balls[1], wall, ao.Linear(k=1e8), gap=1.0)
    done = scene.simulate(duration=1e-3, quantity="rebound_velocity")
    speeds = [done.value(f"bodies.{i}.rebound_velocity") for i in range(3)]
    assert speeds[:2] == pytest.approx([0.0, 1.0], abs=1e-6)
    assert math.isnan(speeds[2])
    assert " m/s of body 0, 1 m/s of body 1 ± " in error_line(done)
    assert "body 2" not in error_line(done)


def test_a_wall_that_comes_takes_its_speed_along():
    """A ball at rest leaves an elastic wall that comes at 1 m/s with 2 m/s (Galilei)."""
    scene = ao.Scene()
    wall = scene.add(ao.rigid(mass=math.inf), velocity=1.0)
    ball = scene.add(ao.rigid(mass=1.0))
    scene.connect(wall, ball, ao.Linear(1e6))
    done = scene.simulate(duration=0.01, quantity="restitution")
    assert done.value("restitution") == pytest.approx(1.0)
    assert done.value("bodies.1.rebound_velocity") == pytest.approx(2.0)


def test_what_has_not_ended_has_no_number_and_what_there_is_not_is_refused():
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=1.0), velocity=1.0)
    scene.connect(ball, scene.add(ao.rigid(mass=math.inf)), ao.Linear(1e6))
    cut = scene.simulate(duration=1e-3)
    assert math.isnan(cut.value("restitution"))
    assert math.isnan(cut.value("bodies.0.rebound_velocity"))
    for name, cure in (
        ("rebound_velocity", r"^name"),
        ("contacts.1.peak_force", r"^name"),
        ("restitutoin", r"^name"),
    ):
        with pytest.raises(ao.InputError, match=cure):
            cut.value(name)
    with pytest.raises(ao.InputError, match=r"^keep"):
        keeper(["contacts.1.peak_force"])(cut)
    kept = keeper(["rebound_velocity", "peak_force", "final_spin"])(cut)
    bodies = [f"bodies.{i}.rebound_velocity" for i in range(2)]
    assert list(kept) == [*bodies, "contacts.0.peak_force", "final_spin"]
    assert kept["contacts.0.peak_force"] == cut.contacts[0].peak_force
