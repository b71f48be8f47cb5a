"""Fields say how wrong they may be: against those of elements of half the size."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import aoimpact as ao
from aoimpact.base import held_warnings

FloatArray = npt.NDArray[np.float64]
ALU = ao.Material(E=70e9, nu=0.3, rho=2700)
BALL = ao.ball(0.01, ao.Material(E=210e9, nu=0.3, rho=7800))
CONTACT, LONG = 8e-5, 8e-4
TIMES = np.array([3e-5, 5e-5, 1e-4, 3e-4, 8e-4])
BEAM, PLATE = (0.3, 0.02, 0.02), (0.2, 0.2, 0.02)

# Name: size, place, held sides, and numbers of elements.
BODIES: dict[str, Any] = {
    "cantilever": (BEAM, (0.27, 0.01, 0.02), ["xmin"], (16, 1, 1)),
    "held beam": (BEAM, (0.15, 0.01, 0.02), ["xmin", "xmax"], (16, 1, 1)),
    "plate": (PLATE, (0.08, 0.08, 0.02), ["xmin", "xmax"], (8, 8, 1)),
}


def model(name: str, n: int, *, finer: int = 1, **fit: Any) -> ao.AOModel:
    size, place, held, counts = BODIES[name]
    mesh = ao.box_mesh(size, [finer * count for count in counts], kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALU, fixed=[(side, "xyz") for side in held])
    tip = body.contact(point=place, direction=(0, 0, -1))
    return ao.antioscillators(tip, n, method="krylov", contact_time=CONTACT, **fit)


def struck(target: Any) -> ao.Result:
    with held_warnings():
        return ao.simulate(BALL, target, 1.0, duration=LONG)


@cache
def right(name: str) -> ao.Result:
    return struck(model(name, 60, finer=2, duration=LONG))


def wrong(hit: ao.Result, name: str) -> FloatArray:
    """The error in the norm of strain energy, relative to the largest after the contact."""
    exact = right(name).target
    body, after = exact.field().body, np.linspace(1.2 * CONTACT, LONG, 60)
    with held_warnings():
        moved = hit.target.probe(body.nodes, times=TIMES).displacement
    shapes = moved - exact.field(TIMES).displacement, exact.field(after).displacement
    rows = [u.reshape(len(u), -1)[:, body.free] for u in shapes]
    off, whole = (np.einsum("ti,it->t", u, body.K @ u.T) for u in rows)
    return np.asarray(np.sqrt(off / whole.max()))


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize(("n", "fit"), [(3, {}), (8, {}), (8, {"duration": LONG}), (20, {})])
def test_the_error_said_is_about_the_true_one_at_any_time(n: int, fit: Any, name: str) -> None:
    """Of models that give the force to some percent, over the contact and long after it."""
    hit = struck(model(name, n, **fit))
    assert hit.peak_force == pytest.approx(right(name).peak_force, rel=0.02)
    true, said = wrong(hit, name), hit.target.field(TIMES).error
    assert said is not None
    assert (said > 0.5 * true).all(), said / true
    assert (said < 2.0 * true).all(), said / true


@pytest.mark.slow
def test_a_right_force_and_a_wrong_stress_afterwards_is_said() -> None:
    hit, place = struck(model("cantilever", 3)), (0.0, 0.01, 0.02)
    with pytest.warns(ao.AOImpactWarning, match=r"^stress"):
        hit.target.field(TIMES).stress()
    with pytest.warns(ao.AOImpactWarning, match=r"^stress"):
        _ = hit.target.probe(place, times=TIMES).stress
    # without a warning
    hit.target.field(TIMES[:2]).stress()
    right("cantilever").target.field(TIMES).stress()
    _ = right("cantilever").target.probe(place, times=TIMES).stress


@pytest.mark.slow
@pytest.mark.parametrize("n", [3, 20])
def test_a_probe_is_judged_where_it_is(n: int) -> None:
    """By a model that gives the motion of the struck point, and not yet that of the rest."""
    mine, exact = struck(model("held beam", n)).target, right("held beam").target
    t = np.linspace(0.0, LONG, 101)
    for x in (0.03, 0.075, 0.24):
        pair = [of.probe((x, 0.01, 0.02), (0, 0, 1), times=t) for of in (mine, exact)]
        for name in ("displacement", "velocity", "stress"):
            with held_warnings() as said:
                ours, truth = (getattr(of, name) for of in pair)
            if name == "stress":
                ours, truth = ours.components, truth.components
            off = np.abs(ours - truth).max() / np.abs(truth).max()
            assert pair[0].error[name].max() > min(off, 1.0)
            assert off < 0.2 or any(text.startswith(name) for text in said), (x, off, said)


def test_a_full_model_has_no_error() -> None:
    scene = ao.Scene()
    full = scene.add(ao.full(model("cantilever", 3).tips[0]))
    scene.apply(full, force=100.0)
    run = scene.simulate(duration=1e-5, solver=ao.Newmark(dt=1e-6, estimate=False))
    assert run[full].field([5e-6]).error is None


def test_what_does_not_move_is_right() -> None:
    scene = ao.Scene()
    beam = scene.add(model("cantilever", 3))
    run = scene.simulate(duration=1e-4)
    assert run[beam].field([5e-5]).error == pytest.approx(0.0, abs=1e-300)
