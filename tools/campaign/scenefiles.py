"""Damaged scene files: changed in their tree of values, or byte by byte."""

from __future__ import annotations

import copy
import json
import random
import re
import tempfile
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import aoimpact as ao

from .inputs import trials
from .meshes import grouped
from .mutate import NUMBERS, damaged
from .package import in_time

# Maximum time of a run, s.
_LONGEST = 2.0

_IN_A_RUN = re.compile(r" at t = |^preload: .* body \d")

_ROOT = Path(__file__).parents[2]


def seeds(folder: Path) -> list[dict[str, Any]]:
    """Return the contents of sound scene files."""
    sound = tomllib.loads(Path(__file__).with_name("sound.toml").read_text())
    (star, bar, *_), examples = sound["files"], _ROOT / "examples"
    laws = [star | {"impact": star["impact"] | {"law": law}} for law in sound["laws"]]
    bars = [bar["bodies"]["bar"] | {"model": model} for model in sound["models"]]
    models = [bar | {"bodies": bar["bodies"] | {"bar": one}} for one in bars]
    example = tomllib.loads((examples / "ball_on_two_beams.toml").read_text())
    return [*laws, *models, *sound["files"][2:], example]


@cache
def _beside() -> dict[str, bytes]:
    """Return the files that scene files refer to, by name."""
    box = ao.box_mesh((100.0, 20.0, 20.0), (2, 1, 1))
    body = ao.FEModel.from_mesh(box, ao.Material(E=210e3, nu=0.3, rho=7.8e-9))
    with tempfile.TemporaryDirectory() as folder:
        ao.write_matrices(body, folder)
        files = {file.name: file.read_bytes() for file in Path(folder).iterdir()}
    return files | {
        "groups.msh": grouped("gmsh22", ".msh"),
        "box.msh": (_ROOT / "tests" / "meshes" / "tetra10_v4.msh").read_bytes(),
    }


# ------------------------------------------------------------------------- writing


def text_of(data: dict[str, Any]) -> str:
    return "".join(f"{_key(name)} = {_value(value)}\n" for name, value in data.items())


def _key(name: str) -> str:
    return name if re.fullmatch(r"[\w-]+", name, re.ASCII) else json.dumps(name)


class _Raw(str):
    """Text that is written without quotes."""


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, _Raw):
        return str(value)
    return repr(value) if isinstance(value, float) else json.dumps(value)


# ------------------------------------------------------------------------------- damage


_WORDS = r"""
    true false
    0 -1 1000000 9223372036854775807 9223372036854775808 1_0 0x10
    0.0 -1.0 2.5 1e23 1e308 5e-324 1e-308
    nan inf -inf
    1979-05-27 07:32:00 1979-05-27T07:32:00Z
    "" "x" "../x" "/dev/null" "a\u0000b"
    "Hertz" "auto" "nodes" "peak_force"
    [] [[]] [[1.0]] ["a"] [0,1] [nan,1,2] [1e308,1e308,1e308]
    {} {a=1} {type=[]} {type="Hertz"}
"""
_LONG = [*("1" + n * "0" for n in (400, 5000)), *(n * "[" + n * "]" for n in (60, 3000))]
_ODD = [*_WORDS.split(), *_LONG, '"' + 300 * "long" + '"']


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
    """Damage the tree of values in place, perhaps with a part of another tree."""
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

    file: Path

    def run(self) -> None:
        scene = ao.read_scene(self.file)
        repr(scene), scene.title, scene.grid, scene.swept
        if any(20 < x < 1e7 for x in _divisions(scene.data)):
            return  # a large mesh is not malformed
        scene.case()
        # Extreme bodies may take long without being malformed: the run is cut off.
        in_time(lambda: str(scene.simulate()), _LONGEST)

    def named(self, message: str) -> bool:
        # An error of the run itself, such as a contact law without a number, has no line.
        return self.file.name in message or bool(_IN_A_RUN.search(message))


def _divisions(data: dict[str, Any]) -> list[Any]:
    meshes = [body["mesh"] for body in data["bodies"].values() if "mesh" in body]
    return [n for mesh in meshes if isinstance(mesh, dict) for n in mesh.get("divisions", [])]


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
    """Write a scene file, and the files that it may refer to."""
    for name, bytes_of in _beside().items():
        if not (folder / name).exists():
            (folder / name).write_bytes(bytes_of)
    file = folder / "scene.toml"
    file.write_bytes(content)
    return Given(file)


trial = trials(seeds, make)
