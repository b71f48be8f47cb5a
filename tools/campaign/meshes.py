"""Damaged mesh files of every format that the package reads and meshio writes."""

from __future__ import annotations

import contextlib
import io
import random
import re
import tempfile
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from runpy import run_path
from typing import Any

import meshio
import numpy as np

import aoimpact as ao
from aoimpact.mesh import KINDS, meshio_of_all_kinds

from .inputs import trials
from .mutate import damaged

_TESTS = Path(__file__).parents[2] / "tests"

# Formats and suffixes of their files, and all sets of keywords for their writers.
_BINARY = ({"binary": False}, {"binary": True})
_PLAIN = """
    abaqus.inp nastran.bdf permas.dato
    exodus.e med.med medit.mesh medit.meshb
    avsucd.avs dolfin-xml.xml su2.su2
    ugrid.ugrid ugrid.b8.ugrid
"""
_FORMATS = {
    **{(name, ".msh"): _BINARY for name in ("gmsh22", "gmsh40", "gmsh")},
    **{(name, ".vtk"): _BINARY for name in ("vtk42", "vtk51")},
    ("vtu", ".vtu"): (*_BINARY, {"binary": True, "compression": None}),
    ("xdmf", ".xdmf"): ({"data_format": "XML"}, {"data_format": "Binary"}),
    ("nastran", ".fem"): ({"point_format": "fixed-small", "cell_format": "fixed-large"},),
    **{(name, f".{end}"): ({},) for name, _, end in (of.partition(".") for of in _PLAIN.split())},
}


@dataclass(frozen=True)
class Seed:
    """A sound file: its suffix, its bytes, and names and bytes of the files beside it."""

    end: str
    content: bytes
    beside: tuple[tuple[str, bytes], ...] = ()


_MATERIAL = ao.Material(E=1e9, nu=0.3, rho=1e3)
_PLY = ao.Orthotropic(E=(3e9, 1e9, 1e9), G=(4e8, 4e8, 3e8), nu=(0.3, 0.3, 0.4), rho=1e3)

# Keywords of `from_mesh` that name groups of the mesh.
_OPTIONS = (
    {"part": "all"},
    {"part": ["low", "wedges"]},
    {"part": "first"},
    {"material": {"all": _PLY}},
    {"material": {"first": _MATERIAL, "rest": _PLY}},
    {"material": {"low": _MATERIAL, "wedges": _PLY, "middle": _MATERIAL, "high": _MATERIAL}},
    {"fixed": [("xmin", "xyz")]},
    {"masses": [("xmin", 1.0)]},
    {"masses": [ao.RigidMass("xmin", 2.0, centre=(-0.1, 0.0, 0.0), inertia=(1.0, 1.0, 1.0))]},
    {"springs": [("xmin", "xy", 1e6)]},
)
_ARGUMENT = re.compile(r"\b(mesh|part|material|fixed|masses|springs|point|radius)\b")


@dataclass(frozen=True)
class Given:
    """A mesh file, keywords of `from_mesh`, and whether to make a contact point."""

    file: Path
    options: dict[str, Any]
    touched: bool

    def run(self) -> None:
        mesh = ao.read_mesh(self.file)
        body = ao.FEModel.from_mesh(mesh, **({"material": _MATERIAL} | self.options))
        assert body.surface is not None
        if self.touched:
            face = np.zeros(1, dtype=int)
            place, _ = body.surface.at(face, body.surface.middle(face))
            tip = body.contact(point=place[0])
            assert np.isfinite(tip.b).all()

    def named(self, message: str) -> bool:
        return self.file.name in message or bool(_ARGUMENT.search(message))


def _boxes() -> list[meshio.Mesh]:
    meshio_of_all_kinds()
    mixed = run_path(str(_TESTS / "bodies.py"))["mixed_box"]
    boxes = [ao.box_mesh((1.0, 0.5, 0.5), (2, 1, 1), kind=kind) for kind in KINDS]
    boxes += [mixed((1.0, 0.5, 0.5), (2, 1, 3), order=order) for order in (1, 2)]
    return [made for box in boxes for made in (_with_sets(box), _with_tags(box))] + [_skin()]


def _blocks(box: ao.Mesh) -> list[tuple[str, Any]]:
    return [(block.kind, np.array(block.cells)) for block in box.blocks]


def _with_sets(box: ao.Mesh) -> meshio.Mesh:
    """Return the box with named groups: of nodes, all elements, and the first of each kind."""
    counts = [len(block.cells) for block in box.blocks]
    ends = np.cumsum(counts)
    groups = {
        "all": [np.arange(count) for count in counts],
        "first": [np.arange(1) for _ in counts],
        "rest": [np.arange(1, count) for count in counts],
    }
    for name, cells in box.cell_sets.items():
        groups[name] = [
            cells[(cells >= end - count) & (cells < end)] - (end - count)
            for end, count in zip(ends, counts, strict=True)
        ]
    sides = {"xmin": np.flatnonzero(box.nodes[:, 0] == 0.0)}
    return meshio.Mesh(np.array(box.nodes), _blocks(box), point_sets=sides, cell_sets=groups)


def _with_tags(box: ao.Mesh) -> meshio.Mesh:
    """Return the box with Gmsh's physical groups, and with data at the nodes."""
    tags = [np.full(len(block.cells), 1 + i) for i, block in enumerate(box.blocks)]
    names = ("low", "wedges", "middle", "high")
    return meshio.Mesh(
        np.array(box.nodes),
        _blocks(box),
        point_data={"u": np.linspace(0.0, 1.0, len(box.nodes))},
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={name: np.array([1 + i, 3]) for i, name in enumerate(names)},
    )


def _skin() -> meshio.Mesh:
    """Return a mesh of triangles, which is no solid."""
    skin = np.array([[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]])
    return meshio.Mesh(np.eye(4)[:, :3], [("triangle", skin)])


def grouped(name: str, end: str) -> bytes:
    """Return a file of several kinds of elements in groups, in one of meshio's formats."""
    mixed = run_path(str(_TESTS / "bodies.py"))["mixed_box"]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"a{end}"
        _with_tags(mixed((1.0, 0.5, 0.5), (2, 1, 3))).write(file, file_format=name, binary=False)
        return _plain(file.read_bytes())


def seeds(folder: Path) -> list[Seed]:
    """Return sound files of every format and element, as far as meshio writes them."""
    found = [Seed(path.suffix, path.read_bytes()) for path in sorted((_TESTS / "meshes").iterdir())]
    for (name, end), every in _FORMATS.items():
        for how, box in product(every, _boxes()):
            # Some formats cannot hold all of a box, or need packages that are not installed.
            with (
                tempfile.TemporaryDirectory() as place,
                contextlib.redirect_stderr(io.StringIO()),
                contextlib.suppress(BaseException),
            ):
                file = Path(place) / f"a{end}"
                box.write(file, file_format=name, **how)
                others = sorted(one for one in file.parent.iterdir() if one != file)
                beside = tuple((one.name, one.read_bytes()) for one in others)
                found.append(Seed(end, _plain(file.read_bytes()), beside))
    return found


def _plain(content: bytes) -> bytes:
    """Return content without NumPy's type names, which some writers print around numbers."""
    return re.sub(rb"np\.\w+\(([-+.\w]*)\)", rb"\1", content)


def make(rng: random.Random, sound: list[Seed], folder: Path) -> Given:
    """Write a damaged file."""
    ends = sorted({seed.end for seed in sound})
    end = rng.choice(ends)
    seed = rng.choice([one for one in sound if one.end == end])
    other = rng.choice([one for one in sound if one.end == end])
    beside = dict(seed.beside)
    content = seed.content
    if beside and rng.random() < 0.4:
        name = rng.choice(sorted(beside))
        beside[name] = damaged(rng, beside[name])
    else:
        content = damaged(rng, content, other.content)
    for name, data in beside.items():
        (folder / name).write_bytes(data)
    file = folder / f"a{rng.choice(ends) if rng.random() < 0.02 else seed.end}"
    file.write_bytes(content)
    options = rng.choice(_OPTIONS) if rng.random() < 0.4 else {}
    return Given(file, options, touched=rng.random() < 0.5)


trial = trials(seeds, make)
