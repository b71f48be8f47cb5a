"""Models chosen for one number say of every other one how wrong it may be, and that is true."""

import csv
import math
import re
from functools import cache

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.results import COLUMNS, QUANTITIES

from twelve import IMPACTS, as_meshed

NUMBERS = {name: one for name, one in QUANTITIES.items() if not (one.is_history or one.sliding)}
STRUCK = ("tip of a cantilever, for long", "held plate", "rod on rod")


@cache
def strike(name, **options):
    projectile, target, law, velocity, duration = IMPACTS[name]()
    case = {"projectile": projectile, "target": target, "law": law, "velocity": velocity}
    return ao.simulate(**(case | {"duration": duration} | options))


@cache
def whole(name):
    """With all oscillators of both bodies."""
    projectile, target, *_ = IMPACTS[name]()
    bodies = (
        body if isinstance(body, ao.AOModel) else ao.antioscillators(body)
        for body in (projectile, target)
    )
    return strike(name, **dict(zip(("projectile", "target"), bodies, strict=True)))


@pytest.mark.parametrize("rtol", [1e-2, pytest.param(1e-1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", [*STRUCK, pytest.param("slow", marks=pytest.mark.slow)])
def test_the_error_said_of_every_number_is_true(name, rtol):
    hit, right = strike(name, quantity="peak_force", rtol=rtol), whole(name)
    assert set(hit.error) == {*NUMBERS, "force"}
    assert hit.error["peak_force"].model == hit.error.model <= rtol
    for name, quantity in NUMBERS.items():
        found, exact = as_meshed(hit).value(name), right.value(name)
        before = np.array(right.plan.velocities)
        scale = max(abs(exact), 0.0 if quantity.least is None else quantity.least(before))
        assert abs(found - exact) <= (1.5 * hit.error[name].model + 1e-3) * scale, name
    assert QUANTITIES["force"].difference(as_meshed(hit), right) < 2.0 * hit.error["force"].model
    if len(as_meshed(hit).contacts) != len(right.contacts):
        assert hit.error["contact_count"].model > 0.0


def test_a_summary_tells_what_was_controlled():
    hit = strike("tip of a cantilever, for long", quantity="peak_force", rtol=1e-2)
    assert hit.error["restitution"].model > 0.1
    lines = {line[2:20].strip(): line[20:].strip() for line in repr(hit).splitlines()[1:]}
    within = float(f"{100.0 * hit.error['impulse'].least:.2g}")
    assert lines["impulse"].endswith(f" ± at least {within:g} %")
    assert " ± " in lines["peak force"].partition(" at ")[2]
    assert re.match(
        r"peak force [\d.]+ N ± .* %( \(.*model .*\))?; .* chosen for 1 %", lines["error"]
    )
    assert (hit.error.quantity, hit.error.rtol) == ("peak_force", 1e-2)


def test_models_that_were_given_have_nothing_to_tell():
    hit = strike("slow", target=ao.rigid(mass=1.0), projectile=ao.rigid(mass=1.0))
    assert all(hit.error[name].model is None for name in hit.error)
    assert all(math.isnan(hit.error[name].total) for name in hit.error)
    assert "±" not in repr(hit)
    assert "error of the peak" in repr(hit)


def test_every_column_of_a_sweep_has_its_error_beside_it(tmp_path):
    projectile, target, law, velocity, duration = IMPACTS["tip of a cantilever, for long"]()
    base = {"projectile": projectile, "target": target, "law": law, "duration": duration}
    grid = {"velocity": [velocity, 2.0 * velocity]}
    aimed_at = {"quantity": "peak_force", "rtol": 1e-2}

    def case(velocity: float) -> dict[str, object]:
        """With a contact point of its own, and so a model just enough for the peak force."""
        own = IMPACTS["tip of a cantilever, for long"]()[1]
        return base | aimed_at | {"velocity": velocity, "target": own}

    table = ao.sweep(case, grid)
    assert {f"{name}_error" for name in COLUMNS} <= set(table.quantities)
    assert np.isnan(table["peak_force_error"]).all()  # the mesh's part is not known at a node
    assert "restitution_error" in repr(table)
    assert (table["peak_force_controlled"] == 1.0).all()
    assert (table["restitution_controlled"] == 0.0).all()
    assert "restitution_controlled" in repr(table)
    table.to_csv(tmp_path / "table.csv")
    with open(tmp_path / "table.csv", encoding="utf-8") as file:
        [headings, first, _] = csv.reader(file)
    told = dict(zip(headings, first, strict=True))
    assert math.isnan(float(told["restitution_error"]))
    given = base | {"projectile": ao.rigid(mass=0.1), "target": ao.rigid(mass=0.2)}
    assert not any(name.endswith("_error") for name in ao.sweep(given, grid).quantities)
    some = ao.sweep(given, grid | {"rtol": [None, 1e-2]}, keep="restitution")
    assert np.isnan(some["restitution_error"]).tolist() == [True, False] * 2


def test_in_a_scene_the_numbers_of_each_contact_have_theirs():
    ball, tip, law, velocity, duration = IMPACTS["tip of a cantilever, for long"]()
    scene = ao.Scene()
    flying, beam = scene.add(ball, velocity=velocity), scene.add(tip)
    scene.connect(flying, beam, law)
    run = scene.simulate(duration=duration, quantity="peak_force", rtol=1e-2)
    right = whole("tip of a cantilever, for long")
    true = abs(as_meshed(run).contacts[0].impulse / right.impulse - 1.0)
    assert true <= run.error["contacts.0.impulse"].model <= 0.2
    assert run.error["contacts.0.peak_force"].model <= 1e-2
    kept = ao.simulate_many(
        [(scene, {"quantity": "peak_force", "rtol": 1e-2, "duration": duration})],
        keep="contacts.0.impulse",
    )
    assert math.isnan(kept[0]["contacts.0.impulse_error"])
    assert run.error["contacts.0.impulse"].least > run.error["contacts.0.impulse"].model
    assert re.search(r"N ± at least .* % \(mesh not known, .*, model .*, time .*\) at", repr(run))


def test_a_number_that_there_is_not_has_no_error():
    with pytest.warns(ao.AOImpactWarning, match="contact"):
        hit = strike("slow", quantity="peak_force", rtol=1e-2, duration=2e-4)
    assert math.isnan(hit.error["restitution"].total)
    assert "restitution        none\n" in repr(hit)


def test_an_error_says_first_what_a_user_asks_first():
    hit = strike("held plate", quantity="peak_force", rtol=1e-2)
    told = repr(hit.error)
    assert float(
        re.match(r"ErrorEstimate\(peak_force: at least (\S+) % \(mesh ", told)[1]
    ) == pytest.approx(100.0 * hit.error.least, rel=0.05)
    assert len(told) < 250
    with pytest.raises(ao.InputError, match=r"^error"):
        hit.error["restituion"]
    assert "restituion" not in hit.error


def test_a_run_without_errors_refuses_the_name_of_any():
    scene = ao.Scene()
    balls = [scene.add(ao.rigid(mass=1.0), velocity=v) for v in (1.0, 0.0)]
    scene.connect(*balls, ao.Linear(k=1e6))
    with pytest.raises(ao.InputError, match=r"^error"):
        scene.simulate(duration=1e-2).error["impulse"]
