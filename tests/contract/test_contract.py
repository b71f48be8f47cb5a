"""Scenes whose digits stay while code moves: a change of numbers is a decision, not an accident.

`python tests/contract/test_contract.py` computes them anew and stores them in numbers.json, which
belongs in a commit that means to change results and says why.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))
from every_law import LAWS, law_of

import aoimpact as ao
from aoimpact import testrig

STORED = Path(__file__).with_name("numbers.json")

# Relative bounds: of numbers; of those of meshed bodies, whose modes are found by iteration; of
# the time of a flat maximum; of errors, which are small differences of models and hang on rounding.
# The last of some twenty Krylov vectors hang on it, too: where models are chosen that counts.
DIGITS, OF_MESHES, OF_PEAK_TIMES, OF_ERRORS = 1e-9, 1e-7, 1e-5, 0.25
CHOSEN = {"friction on a block", "stress at a point"}
OF_CHOSEN, OF_CHOSEN_PEAK_TIMES = 1e-4, 1e-3

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALU = ao.Material(E=70e9, nu=0.33, rho=2700)
PLY = ao.Orthotropic(E=(135e9, 9e9, 9e9), G=(5e9, 5e9, 3.2e9), nu=(0.3, 0.3, 0.4), rho=1550)
BALL, WALL = ao.ball(0.01, STEEL), ao.wall(STEEL)
STAR = ao.AOModel(m0=0.01, k0=1e4, m=[0.02, 0.05], k=[1e7, 4e6])
ENDS = [("xmin", "xyz"), ("xmax", "xyz")]
RIM = [(edge, "xyz") for edge in ("xmin", "xmax", "ymin", "ymax")]
TURNED = (0.0, 0.3, -1.0)


def told(run: Any) -> dict[str, float]:
    """The numbers of a run, with their errors."""
    found, error = dict(run.numbers), run.error
    return found | {f"error of {name}": error[name].least for name in found}


@cache
def sphere() -> ao.ContactPoint:
    body = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, 0.004), STEEL)
    return body.contact(point=(0, 0, -0.01))


@cache
def plate() -> ao.FEModel:
    mesh = ao.box_mesh((0.1, 0.08, 0.01), (8, 6, 2), kind="hexahedron20")
    return ao.FEModel.from_mesh(mesh, ALU, fixed=ENDS, damping=ao.Rayleigh(alpha=20.0))


@cache
def top(x: float = 0.05, y: float = 0.04) -> ao.ContactPoint:
    """In the middle it is on planes of symmetry, and the last Krylov vectors hang on rounding."""
    return plate().contact(point=(x, y, 0.01))


def sheet(made: Any, kind: str = "quad") -> ao.ContactPoint:
    mesh = ao.sheet_mesh((0.1, 0.1), (16, 16), kind=kind)
    return ao.FEModel.from_mesh(mesh, made, fixed=RIM).contact(point=(0.03, 0.04, 0))


def block() -> ao.ContactPoint:
    mesh = ao.box_mesh((0.02, 0.02, 0.02), (3, 3, 3), kind="hexahedron20")
    return ao.FEModel.from_mesh(mesh, STEEL).contact(point=(0.01, 0.01, 0.02))


def few(tip: ao.ContactPoint) -> ao.AOModel:
    """So few oscillators that they do not hang on rounding; more than about 15 do."""
    return ao.antioscillators(tip, 10, method="krylov", contact_time=1e-4)


def rod() -> ao.FEModel:
    line = np.linspace((0, 0, 0), (0.2, 0, 0), 21)
    mesh = ao.Mesh(line, np.stack([np.arange(20), np.arange(1, 21)], axis=1), "line")
    beam = ao.Beam(ao.RectangularSection(0.01, 0.005), STEEL, orientation=(0, 0, 1))
    return ao.FEModel.from_mesh(mesh, beam)


@cache
def on_plate() -> ao.Result:
    """A record of the plate that is read in many ways."""
    return ao.simulate(BALL, ao.modal(top(), 12), 1.0, law=ao.Hertz(1e10), duration=3e-4)


def stack() -> dict[str, float]:
    """Two balls at rest on a star under gravity; one is lifted and dropped by a load."""
    scene = ao.Scene(gravity=9.81)
    low, high, star = scene.add(BALL), scene.add(BALL), scene.add(STAR)
    scene.connect(low, star, ao.HuntCrossley(1e9, 0.2))
    scene.connect(high, low, ao.Hertz(1e9))
    scene.apply(high, force=([0.0, 1e-4, 2e-4], [0.0, -5.0, 0.0]))
    return told(scene.simulate(duration=1e-3))


def two_places() -> dict[str, float]:
    """Two balls that strike one plate in two places, one a little later."""
    tips = [plate().contact(point=(x, 0.04, 0.01)) for x in (0.0375, 0.0625)]
    scene = ao.Scene()
    body = scene.add(ao.interface(tips, 12, contact_time=1e-4))
    for place, gap in enumerate((0.0, 2e-5)):
        ball = scene.add(BALL, velocity=1.0)
        scene.connect(ball, body.port(place), ao.Hertz(1e10), gap=gap)
    return told(scene.simulate(duration=3e-4))


def many() -> dict[str, float]:
    cases = [
        {"projectile": BALL, "target": STAR, "law": ao.Hertz(1e9), "velocity": v, "duration": 2e-3}
        for v in (0.5, 1.0, 2.0)
    ]
    peaks = {f"case {i}": hit.peak_force for i, hit in enumerate(ao.simulate_many(cases))}
    grid = {"velocity": [0.5, 2.0], "law": [ao.Hertz(1e9), ao.Tsuji(1e9, 0.1, 0.03)]}
    swept = ao.sweep(cases[0], grid, keep=["peak_force", "restitution"], progress=False)
    return peaks | {name: swept[name] for name in ("peak_force", "restitution")}


def histories() -> dict[str, float]:
    """Displacement, stress and strain of a plate over time, its support's force, and a filter."""
    body, place, times = on_plate().target, (0.025, 0.02, 0.01), np.linspace(5e-5, 3e-4, 6)
    probe = body.probe(place, direction=(0, 0, 1), times=times)
    return {
        "velocity": probe.velocity,
        "filtered": probe.filtered(cfc=1e4).acceleration[2:4],
        "gauge": body.gauge(place, direction=(1, 0, 0), length=2e-3, times=times).strain,
        "reaction": body.reaction("xmin", times=times).force,
        "stress": body.field(times).stress().von_mises[:, ::50],
    }


def frf() -> dict[str, float]:
    given = {"excitation": top(), "frequencies": [0.0, 1e3, 3e3, 1e4]}
    found = plate().frf(**given, kind="receptance")
    return {"real": found.values.real, "imaginary": found.values.imag}


def matrices() -> dict[str, float]:
    body = plate()
    bare = ao.FEModel(K=body.K, M=body.M, nodes=body.nodes, free=body.free)
    tip = bare.contact(point=(0.05, 0.04, 0.01), direction=(0, 0, 1), radius=0)
    hit = ao.simulate(BALL, ao.antioscillators(tip, 8), 1.0, law=ao.Hertz(1e9))
    return told(hit) | {"frequencies": bare.frequencies(5)}


def fitted() -> dict[str, float]:
    law = ao.HuntCrossley(1e9, 0.2)
    signal = testrig.Signal.of(ao.simulate(ao.rigid(0.1), WALL, 1.0, law=law), rate=1e6)
    fit = ao.fit_law(ao.Hertz(9e8), indentation=[0, 1e-5, 2e-5, 3e-5], force=[0, 33, 88, 165])
    drop = testrig.drop_weight(signal, mass=0.1, velocity=1.0)
    return {"k": fit.law.k, "energy": drop.energy[::20]}


SCENES: dict[str, Callable[[], Mapping[str, Any]]] = {
    **{
        f"rigid, {name}": lambda name=name: told(
            ao.simulate(ao.rigid(0.032), ao.rigid(0.032), 1.0, law=law_of(name))
        )
        for name in LAWS
    },
    "restitution": lambda: {
        name: ao.restitution(law_of(name), mass=0.016, velocity=1.0)
        for name in ("HuntCrossley", "Tsuji", "KuwabaraKono", "KelvinVoigt", "Thornton")
    },
    "star": lambda: told(ao.simulate(BALL, STAR, 1.0, law=ao.Hertz(1e9), duration=2e-3)),
    "star, Newmark": lambda: told(
        ao.simulate(
            *(BALL, STAR, 1.0), law=ao.Hertz(1e9), duration=1e-3, solver=ao.Newmark(dt=1e-6)
        )
    ),
    "balls of numbers": lambda: told(ao.simulate(BALL, BALL, 1.0)),
    "spheres of a mesh": lambda: told(ao.simulate(sphere(), sphere(), 1.0)),
    "sphere on plate": lambda: told(ao.simulate(sphere(), top(0.04, 0.03), 1.0)),
    "modes of a plate": lambda: told(on_plate()),
    "all of a plate": lambda: told(
        ao.simulate(BALL, ao.full(top()), 1.0, law=ao.Hertz(1e10), duration=2e-4)
    ),
    "shell": lambda: told(ao.simulate(BALL, few(sheet(ao.Shell(3e-3, STEEL))), 1.0)),
    "shell of triangles": lambda: told(
        ao.simulate(BALL, few(sheet(ao.Shell(3e-3, STEEL), "triangle")), 1.0, duration=1e-4)
    ),
    "laminate": lambda: told(
        ao.simulate(
            BALL,
            sheet(ao.Laminate([ao.Ply(1e-3, PLY, a) for a in (0, 90, 90, 0)], (1, 0, 0))),
            *(0.3,),
            duration=1e-4,
        )
    ),
    "beam": lambda: told(
        ao.simulate(BALL, rod().contact(point=(0.1, 0, 0), direction=(0, 0, 1)), 1.0)
    ),
    "friction": lambda: told(ao.simulate(BALL, WALL, TURNED, friction=0.1)),
    "friction, Newmark": lambda: told(
        ao.simulate(BALL, WALL, TURNED, friction=0.1, duration=7e-5, solver=ao.Newmark(dt=2e-7))
    ),
    "friction on a block": lambda: told(
        ao.simulate(BALL, block(), TURNED, friction=0.2, duration=7e-5)
    ),
    "stress at a point": lambda: told(
        ao.simulate(
            *(BALL, top(), 1.0),
            duration=1.5e-4,
            quantity=ao.StressAt(plate(), (0.05, 0.04, 0.0), component="xx"),
            rtol=0.05,
        )
    ),
    **{made.__name__: made for made in (stack, two_places, many, histories, frf, matrices, fitted)},
}


def numbers(name: str) -> dict[str, Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ao.AOImpactWarning)
        return {what: np.asarray(value).tolist() for what, value in SCENES[name]().items()}


def digits(name: str, what: str) -> float:
    if what.startswith("error"):
        return OF_ERRORS
    if name in CHOSEN:
        return OF_CHOSEN_PEAK_TIMES if what.endswith("peak_time") else OF_CHOSEN
    if what.endswith("peak_time"):
        return OF_PEAK_TIMES
    return DIGITS if name.startswith(("rigid", "star", "stack", "many")) else OF_MESHES


@pytest.mark.parametrize("name", SCENES)
def test_digits_stay(name: str) -> None:
    stored, found = json.loads(STORED.read_text("utf-8"))[name], numbers(name)
    assert list(found) == list(stored)
    for what, value in found.items():
        wanted = np.array(stored[what])
        bound = digits(name, what) * np.abs(np.nan_to_num(wanted, posinf=0.0)).max()
        assert np.array(value) == pytest.approx(wanted, rel=0.0, abs=bound, nan_ok=True), what


if __name__ == "__main__":
    STORED.write_text(json.dumps({name: numbers(name) for name in SCENES}, indent=1) + "\n")
