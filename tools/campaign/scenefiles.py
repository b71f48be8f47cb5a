"""Scene files, damaged: by their grammar, and byte by byte."""

from __future__ import annotations

import copy
import json
import math
import random
import re
import tempfile
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import aoimpact as ao

from .meshes import grouped
from .mutate import NUMBERS, damaged

_IN_A_RUN = re.compile(r" at t = |^preload: .* body \d")

_ROOT = Path(__file__).parents[2]

_STAR = "{ m0 = 0.045, k0 = 26880.0, m = [0.2482, 0.0767], k = [5.897e6, 1.914e7] }"
_BOX = "{ box = [0.1, 0.02, 0.02], divisions = [2, 1, 1] }"
_PLATE = "{ box = [0.1, 0.02, 0.02], divisions = [4, 2, 2] }"
_STEEL = "[materials.steel]\nE = 210e9\nnu = 0.3\nrho = 7800\n"
_TIP = "{ point = [0.1, 0.0, 0.0], direction = [-1, 0, 0], radius = 0 }"


def _body(model: str, *, more: str = "", contact: str = _TIP) -> str:
    return (
        f'[bodies.bar]\nmesh = {_BOX}\nmaterial = "steel"\ncontact = {contact}\n{more}\n'
        f"model = {model}\n"
    )


def _impact(target: str, law: str, more: str = "") -> str:
    return (
        f'[impact]\nprojectile = "ball"\ntarget = "{target}"\nvelocity = 1.0\nduration = 1e-3\n'
        f"law = {law}\n{more}\n"
    )


_BALL = "[bodies.ball]\nmass = 0.03\n"
_HERTZ = '{ type = "Hertz", k = 1e9 }'
_LAWS = (
    _HERTZ,
    '{ type = "PowerLaw", k = 1e9, n = 1.4 }',
    '{ type = "Linear", k = 1e6 }',
    '{ type = "HuntCrossley", k = 1e9, restitution = 0.8, velocity = 1.0 }',
    '{ type = "HuntCrossley", k = 1e9, restitution = 0.8, velocity = 1.0, formula = "gonthier" }',
    '{ type = "Tsuji", k = 1e9, alpha = 0.1, mass = 0.02 }',
    '{ type = "KuwabaraKono", k = 1e9, A = 1e-6 }',
    '{ type = "KelvinVoigt", k = 1e6, c = 10.0, end = "indentation" }',
    '{ type = "Thornton", k = 1e9, yield_force = 100.0 }',
    '{ type = "Tabulated", indentation = [0.0, 1e-4, 1e-3], force = [0.0, 100.0, 3000.0] }',
    '{ type = "Hertz", k = { between = [{ material = "steel", radius = 0.01 }, '
    '{ material = "steel", radius = inf }] } }',
    '{ type = "HuntCrossley", k = 1e9, damping = 0.2, relative_radius = 0.01 }',
    '{ type = "KelvinVoigt", k = 1e6, restitution = 0.5, mass = 0.02 }',
    '{ type = "Thornton", k = { between = [{ material = "steel", radius = 0.01 }, '
    '{ material = "steel", radius = -0.1 }] }, yield_pressure = 1e9 }',
)
_MODELS = (
    '{ type = "antioscillators", n = 3 }',
    '{ type = "antioscillators", n = 3, method = "krylov", contact_time = 1e-4 }',
    '{ type = "modal", n = 4, solver = "superlu" }',
    '{ type = "full" }',
)
_ENDS = 'fixed = [{ x = 0.0, hold = "xyz" }, { x = 0.1, hold = "xyz" }]'
_FIXED = 'fixed = [{ x = 0.0, hold = "xyz" }, { nodes = "ymin", hold = "y" }]'


_PILE = (
    "[bodies.ball]\nmass = 0.03\n[bodies.floor]\nmass = inf\n[scene]\nduration = 0.01\n"
    'gravity = 9.81\npreload = true\nsolver = { type = "Adaptive", rtol = 1e-6 }\n'
    '[[scene.bodies]]\nname = "upper"\nbody = "ball"\n[[scene.bodies]]\nname = "lower"\n'
    'body = "ball"\n[[scene.bodies]]\nbody = "floor"\n[[scene.contacts]]\n'
    'between = ["upper", "lower"]\nlaw = { type = "HuntCrossley", k = 1e9, damping = 0.3 }\n'
    '[[scene.contacts]]\nbetween = ["lower", "floor"]\nlaw = { type = "Hertz", k = 1e9 }\n'
    '[[scene.loads]]\nbody = "upper"\ntimes = [0.0, 0.01]\nforces = [0.0, 5.0]\n'
)


def seeds(folder: Path) -> list[dict[str, Any]]:
    """Return sound scene files, read."""
    star = f"[bodies]\nball = {{ mass = 0.03 }}\nstar = {_STAR}\n"
    texts = [(star + _STEEL if "steel" in law else star) + _impact("star", law) for law in _LAWS]
    texts += [
        _STEEL + _BALL + _body(model, more=_FIXED) + _impact("bar", _HERTZ) for model in _MODELS
    ]
    texts += [
        *_bars(),
        *_fitted_out(),
        star
        + _impact("star", _HERTZ)
        + '[sweep]\nkeep = ["peak_force"]\nworkers = 1\n[sweep.over]\nvelocity = [0.5, 1.0]\n'
        'gap = { from = 0.0, to = 1e-4, count = 3 }\n"bodies.ball.mass" = [0.01, 0.02]\n',
        (_ROOT / "examples" / "ball_on_two_beams.toml").read_text(),
        _PILE,
    ]
    return [tomllib.loads(text) for text in texts]


def _bars() -> list[str]:
    """Bars that are damped, read from a file and run in full, and touched in two places."""
    return [
        _STEEL
        + _BALL
        + _body(
            '{ type = "antioscillators", n = 2 }',
            contact="{ dof = 5 }",
            more="damping = { ratio = 0.02 }",
        )
        + _impact("bar", _HERTZ, 'solver = { type = "Newmark", dt = 1e-6 }\ngap = 1e-5'),
        _STEEL
        + _BALL
        + _body(
            '{ type = "full" }',
            more='fixed = [{ nodes = "base", hold = "xyz" }]',
            contact="{ point = [2.0, 1.5, 1.0], direction = [-1, -1, -1], radius = 0 }",
        ).replace(_BOX, '"box.msh"')
        + _impact("bar", _HERTZ, 'quantity = "peak_force"\nrtol = 0.05'),
        _STEEL
        + _BALL
        + _body(
            '{ type = "interface", n = 6 }',
            more=_FIXED,
            contact="[{ point = [0.1, 0, 0], direction = [-1, 0, 0], radius = 0 }, "
            "{ point = [0.05, 0.02, 0.02], direction = [-1, -1, -1], radius = 0 }]",
        )
        + '[scene]\nduration = 1e-3\n[[scene.bodies]]\nbody = "ball"\nvelocity = 1.0\n'
        '[[scene.bodies]]\nbody = "bar"\n[[scene.contacts]]\n'
        f'between = ["ball", {{ body = "bar", port = 1 }}]\nlaw = {_HERTZ}\n',
    ]


_PLY = (
    "[materials.ply]\nrho = 1500\naxes = [[1, 0, 0], [0, 1, 0]]\nturned = 0.5\n"
    "orthotropic = { E = [130e9, 9e9, 9e9], G = [5e9, 5e9, 3e9], nu = [0.3, 0.3, 0.4] }\n"
)

_GROUPS = (
    'mesh = { file = "groups.msh", scale = 0.1 }\npart = ["low", "wedges", "middle", "high"]\n'
    'material = { low = "steel", wedges = "ply", middle = "steel", high = "ply" }\n'
    "masses = [{ nodes = [1, 2], mass = 0.1 }, "
    "{ x = 0.1, mass = 2.0, centre = [0.2, 0, 0], inertia = [1e-3, 1e-3, 1e-3] }]\n"
    'springs = [{ z = 0.0, along = "xz", stiffness = 1e6 }]\n'
    "damping = { alpha = 10.0, beta = 1e-7 }\n"
)

_MATRICES = (
    'matrices = { K = "K.mtx", M = "M.mtx", nodes = "nodes.txt", length = 1e-3, mass = 1e3 }\n'
)


def _fitted_out() -> list[str]:
    """Bars of groups, with added masses, of matrices, and touched by a ball of known surface."""
    model = 'model = { type = "antioscillators", n = 2 }\n'
    on_top = "contact = { point = [0.05, 0.01, 0.02] }\n"
    at_node = on_top.replace(" }", ", radius = 0 }")
    plate = f'[bodies.bar]\nmesh = {_PLATE}\nmaterial = "steel"\n{_ENDS}\n{on_top}'
    ball = '[bodies.ball]\nball = 0.001\nmaterial = "steel"\n'
    place = '{ body = "bar", point = [0.05, 0, 0], direction = [0, 0, 1] }'
    hit = '[impact]\nprojectile = "ball"\ntarget = "bar"\nvelocity = 1.0\n'
    return [
        _STEEL
        + _PLY
        + _BALL
        + f"[bodies.bar]\n{_GROUPS}{model}"
        + "contact = { node = 4, direction = [0, 0, 1], radius = 0 }\n"
        + _impact("bar", _HERTZ, 'report = ["peak_force", "error.time"]'),
        _BALL
        + f"[bodies.bar]\n{_MATRICES}{model}contact = {{ node = 8, direction = [0, 0, 1] }}\n"
        + _impact("bar", _HERTZ),
        _STEEL + ball + plate + model + hit,
        _STEEL
        + _BALL
        + plate.replace(on_top, at_node)
        + _impact("bar", _HERTZ, f"rtol = 0.05\nquantity = {place}"),
    ]


@cache
def _beside() -> dict[str, bytes]:
    """The files that scene files name."""
    box = ao.box_mesh((100.0, 20.0, 20.0), (2, 1, 1))
    body = ao.FEModel.from_mesh(box, ao.Material(E=210e3, nu=0.3, rho=7.8e-9))
    with tempfile.TemporaryDirectory() as folder:
        ao.write_matrices(body, folder)
        files = {file.name: file.read_bytes() for file in Path(folder).iterdir()}
    return files | {
        "groups.msh": grouped("gmsh22", ".msh"),
        "box.msh": (_ROOT / "tests" / "meshes" / "tetra10_v4.msh").read_bytes(),
    }


# ------------------------------------------------------------------------- as text again


def text_of(data: dict[str, Any]) -> str:
    return "".join(f"{_key(name)} = {_value(value)}\n" for name, value in data.items())


def _key(name: str) -> str:
    plain = name and all(c.isascii() and (c.isalnum() or c in "-_") for c in name)
    return name if plain else json.dumps(name)


class _Raw(str):
    """What is written as it is."""


def _value(value: Any) -> str:
    if isinstance(value, _Raw):
        return str(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return "nan" if math.isnan(value) else repr(value)
    return json.dumps(value) if isinstance(value, str) else str(value)


# ------------------------------------------------------------------------------- damage


_ODD = (
    "[]",
    "{}",
    "[[]]",
    "true",
    "false",
    '""',
    '"x"',
    "1979-05-27",
    "07:32:00",
    "1979-05-27T07:32:00Z",
    "nan",
    "inf",
    "-inf",
    "0",
    "-1",
    "0.0",
    "-1.0",
    "1e308",
    "1e23",
    "5e-324",
    "1e-308",
    "9223372036854775807",
    "9223372036854775808",
    "1" + 400 * "0",
    "1" + 5000 * "0",
    "[0, 1]",
    "[nan, 1, 2]",
    '["a"]',
    "{a = 1}",
    '"../x"',
    '"/dev/null"',
    '"a\\u0000b"',
    "2.5",
    "1000000",
    60 * "[" + 60 * "]",
    3000 * "[" + 3000 * "]",
    '"' + 300 * "long" + '"',
    '"Hertz"',
    '"auto"',
    "[[1.0]]",
    "{type = []}",
    '{type = "Hertz"}',
    "[1e308, 1e308, 1e308]",
    "1_0",
    "0x10",
    '"nodes"',
    '"peak_force"',
)


def _places(data: Any, above: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    if isinstance(data, dict):
        inside = [(*above, key) for key in data]
    elif isinstance(data, list):
        inside = [(*above, i) for i in range(len(data))]
    else:
        return []
    return inside + [
        deeper for place in inside for deeper in _places(_at(data, place[len(above) :]), place)
    ]


def _at(data: Any, place: tuple[Any, ...]) -> Any:
    for part in place:
        data = data[part]
    return data


def _regrown(rng: random.Random, data: dict[str, Any], other: dict[str, Any]) -> None:
    """Damage to the tree, in place."""
    places = _places(data)
    if not places:
        return
    place = rng.choice(places)
    table, last = _at(data, place[:-1]), place[-1]
    way = rng.randrange(10)
    if way <= 4:
        table[last] = _Raw(rng.choice(_ODD if rng.random() < 0.8 else NUMBERS))
    elif way == 5:
        del table[last]
    elif way == 6:
        table[last] = copy.deepcopy(_at(data, rng.choice(places)))
    elif way == 7:
        elsewhere = _places(other)
        table[last] = copy.deepcopy(_at(other, rng.choice(elsewhere)))
    elif isinstance(table, dict):
        name = rng.choice(
            ("", "x", "type", "mass", "mesh", "ä", "a.b", "contacts", "from", "k", last + "s")
        )
        table[name] = table.pop(last) if way == 8 else copy.deepcopy(table[last])
    else:
        table[last:last] = [copy.deepcopy(table[last])] * rng.choice((1, 2, 30))


@dataclass(frozen=True)
class Given:
    """A scene file."""

    saved: Path

    def run(self) -> None:
        scene = ao.read_scene(self.saved)
        repr(scene), scene.title, scene.grid, scene.swept
        if any(20 < x < 1e7 for x in _divisions(scene.data)):
            return  # a large mesh is not malformed
        scene.case()
        if _soon(scene):
            str(scene.simulate())

    def named(self, message: str) -> bool:
        # What comes up in a run, such as a contact law that gives no number, is not of one line.
        return self.saved.name in message or bool(_IN_A_RUN.search(message))


def _soon(scene: Any) -> bool:
    """Whether a run is as short as those of the sound files: one of extreme bodies, that takes
    long, is not malformed."""
    table = scene.data[scene.kind]
    bodies = _numbers([scene.data["bodies"], scene.data.get("materials", {})])
    members = table.get("bodies", [])
    names = ("contacts", "law", "solver", "loads", "gravity")
    how = _numbers([table[name] for name in names if name in table])
    duration = table.get("duration", 0.0)
    speeds = _numbers([table.get("velocity", 0.0), *(m.get("velocity", 0.0) for m in members)])
    return (
        all(x <= 0.0 or 1e-9 <= x <= 1e13 or math.isinf(x) for x in bodies + how)
        and all(x >= 1e-7 for x in _numbers([table.get("solver", {}).get("dt", 1.0)]))
        and all(x <= 1e5 for x in speeds)
        and (duration <= 0.1 or (duration >= 1e15 and scene.kind == "impact"))
    )


def _divisions(data: Any) -> list[float]:
    bodies = [body for body in data["bodies"].values() if isinstance(body.get("mesh"), dict)]
    return _numbers([body["mesh"].get("divisions", []) for body in bodies])


def _numbers(data: Any) -> list[float]:
    if isinstance(data, dict):
        data = list(data.values())
    if isinstance(data, list):
        return [x for one in data for x in _numbers(one)]
    plain = isinstance(data, (int, float)) and not isinstance(data, bool) and abs(data) < 1e300
    return [abs(float(data))] if plain else []


def make(rng: random.Random, sound: list[dict[str, Any]], folder: Path) -> Given:
    """Write a damaged file."""
    data, other = copy.deepcopy(rng.choice(sound)), rng.choice(sound)
    if rng.random() < 0.75:
        for _ in range(rng.choice((1, 1, 1, 2, 3))):
            _regrown(rng, data, other)
    content = text_of(data).encode()
    if rng.random() < 0.3:
        content = damaged(rng, content, text_of(other).encode())
    return written(content, folder)


def written(content: bytes, folder: Path) -> Given:
    """Write a scene file, and what it names beside it."""
    for name, bytes_of in _beside().items():
        if not (folder / name).exists():
            (folder / name).write_bytes(bytes_of)
    file = folder / "scene.toml"
    file.write_bytes(content)
    return Given(file)
