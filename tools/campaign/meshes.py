"""Mesh files of every format that meshio reads, damaged."""

from __future__ import annotations

import contextlib
import io
import random
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import meshio
import numpy as np

import aoimpact as ao
from aoimpact.mesh import KINDS, meshio_of_all_kinds

from .mutate import damaged

__all__ = ["Given", "make", "seeds"]

_OWN = Path(__file__).parents[2] / "tests" / "meshes"

# Formats, the end of their files' names, and what their writers are told.
_FORMATS: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("gmsh22", ".msh", {"binary": False}),
    ("gmsh22", ".msh", {"binary": True}),
    ("gmsh40", ".msh", {"binary": False}),
    ("gmsh40", ".msh", {"binary": True}),
    ("gmsh", ".msh", {"binary": False}),
    ("gmsh", ".msh", {"binary": True}),
    ("ansys", ".msh", {"binary": False}),
    ("ansys", ".msh", {"binary": True}),
    ("abaqus", ".inp", {}),
    ("avsucd", ".avs", {}),
    ("cgns", ".cgns", {}),
    ("dolfin-xml", ".xml", {}),
    ("exodus", ".e", {}),
    ("flac3d", ".f3grid", {"binary": False}),
    ("flac3d", ".f3grid", {"binary": True}),
    ("h5m", ".h5m", {}),
    ("hmf", ".hmf", {}),
    ("mdpa", ".mdpa", {}),
    ("med", ".med", {}),
    ("medit", ".mesh", {}),
    ("medit", ".meshb", {}),
    ("nastran", ".bdf", {}),
    ("nastran", ".fem", {"point_format": "fixed-small", "cell_format": "fixed-large"}),
    ("netgen", ".vol", {}),
    ("netgen", ".vol.gz", {}),
    ("permas", ".dato", {}),
    ("stl", ".stl", {"binary": False}),
    ("su2", ".su2", {}),
    ("tecplot", ".tec", {}),
    ("tetgen", ".node", {}),
    ("ugrid", ".ugrid", {}),
    ("ugrid", ".b8.ugrid", {}),
    ("vtk42", ".vtk", {"binary": False}),
    ("vtk42", ".vtk", {"binary": True}),
    ("vtk51", ".vtk", {"binary": False}),
    ("vtk51", ".vtk", {"binary": True}),
    ("vtu", ".vtu", {"binary": False}),
    ("vtu", ".vtu", {"binary": True}),
    ("vtu", ".vtu", {"binary": True, "compression": None}),
    ("wkt", ".wkt", {}),
    ("xdmf", ".xdmf", {"data_format": "XML"}),
    ("xdmf", ".xdmf", {"data_format": "Binary"}),
)


@dataclass(frozen=True)
class Seed:
    """A sound file: the end of its name, its bytes, and those of what lies beside it."""

    end: str
    content: bytes
    beside: tuple[tuple[str, bytes], ...] = ()


@dataclass(frozen=True)
class Given:
    """An input: its file, and what a user would do with it."""

    saved: Path

    def run(self) -> None:
        mesh = ao.read_mesh(self.saved)
        body = ao.FEModel.from_mesh(mesh, ao.Material(E=1e9, nu=0.3, rho=1e3))
        assert body.surface is not None

    def named(self, message: str) -> bool:
        return self.saved.name in message


def _boxes() -> list[meshio.Mesh]:
    boxes = []
    meshio_of_all_kinds()
    for kind in KINDS:
        box = ao.box_mesh((1.0, 0.5, 0.5), (2, 1, 1), kind=kind)
        sides = {"xmin": np.flatnonzero(box.nodes[:, 0] == 0.0)}
        everything = np.arange(len(box.cells))
        boxes.append(
            meshio.Mesh(
                np.array(box.nodes),
                [(kind, np.array(box.cells))],
                point_sets=sides,
                cell_sets={"all": [everything]},
            )
        )
        tagged = {
            "gmsh:physical": [np.ones(len(box.cells), int)],
            "gmsh:geometrical": [np.ones(len(box.cells), int)],
        }
        boxes.append(
            meshio.Mesh(
                np.array(box.nodes),
                [(kind, np.array(box.cells))],
                point_data={"u": np.linspace(0.0, 1.0, len(box.nodes))},
                cell_data=tagged,
                field_data={"body": np.array([1, 3])},
            )
        )
    skin = np.array([[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]])
    boxes.append(meshio.Mesh(np.eye(4)[:, :3], [("triangle", skin)]))
    return boxes


def seeds(folder: Path) -> list[Seed]:
    """Return sound files of every format and element, as far as meshio writes them."""
    found = [Seed(path.suffix, path.read_bytes()) for path in sorted(_OWN.iterdir())]
    for name, end, how in _FORMATS:
        for box in _boxes():
            place = folder / "seed"
            place.mkdir()
            file = place / f"a{end}"
            quiet = contextlib.redirect_stdout(io.StringIO())
            # Formats differ in what they can hold, and some need packages that are not there.
            with (
                quiet,
                contextlib.redirect_stderr(io.StringIO()),
                contextlib.suppress(BaseException),
            ):
                box.write(file, file_format=name, **how)
                beside = [
                    (one.name, one.read_bytes()) for one in sorted(place.iterdir()) if one != file
                ]
                found.append(Seed(end, file.read_bytes(), tuple(beside)))
            for one in place.iterdir():
                one.unlink()
            place.rmdir()
    return found


def make(rng: random.Random, sound: list[Seed], folder: Path) -> Given:
    """Write a damaged file."""
    for old in folder.iterdir():
        old.unlink()
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
    return Given(file)
