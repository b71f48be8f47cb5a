"""Meshes of meshio: its files, and the names that they give to groups of nodes and cells."""

from __future__ import annotations

import contextlib
import gzip
import io
import re
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import IntArray, MemoryLimitError, MeshError
from .elements import KINDS
from .guard import Reading, bounded, bounded_text
from .rawmesh import RawBlock, RawMesh

__all__ = ["from_meshio", "is_meshio", "meshio_of_all_kinds", "read"]


# meshio's names of kinds of cells: a shape and its number of nodes.
_KIND = re.compile(r"(vertex|line|triangle|quad|tetra|hexahedron|wedge|pyramid)\d*")

# Formats that hold no volume cells: there is nothing to be read.
_SURFACES = (".obj", ".off", ".ply", ".stl", ".svg", ".wkt")

# Groups of FLAC3D's files, of which meshio numbers the members through, not by blocks.
_FLAC3D = re.compile("(zone|face):")

_DIMENSION_NAMES = ("point", "line", "surface", "volume")


def read(file: Path) -> RawMesh:
    """Return what meshio reads of a file.

    Raises
    ------
    MeshError
        If meshio does not read its format, or it has cells of a kind that meshio cannot hold.
    MemoryLimitError
        If there is not enough memory for it.
    """
    size = file.stat().st_size
    if file.suffix.lower() in _SURFACES:
        raise MeshError(
            f"mesh file {str(file)!r}: files {file.suffix} hold surfaces, without volume cells; "
            "mesh the inside, and write .msh, .vtu or .inp"
        )
    said = io.StringIO()
    reading = Reading(size)
    try:
        mesh = _silently_read(file, reading, said)
    except SystemExit:
        reason = " ".join(said.getvalue().split())
    except MemoryError:
        raise MemoryLimitError(
            f"mesh file {str(file)!r} ({size} bytes) needs more memory than there is: coarsen the "
            "mesh, or look for a count in the file that is wrong"
        ) from None
    except ModuleNotFoundError as error:
        raise MeshError(
            f"mesh file {str(file)!r} needs the package {error.name}: pip install {error.name}"
        ) from None
    except KeyError as error:
        # Some readers know more kinds of cells, such as tetra4, than meshio's meshes can hold.
        if _KIND.fullmatch(str(error.args[0] if error.args else "")):
            raise MeshError(
                f"mesh file {str(file)!r} has cells of an unsupported kind: {error.args[0]}; "
                f"supported are {', '.join(KINDS)}"
            ) from None
        reason = f"KeyError: {error}"
    except Exception as error:
        # Readers meet malformed files with whatever their parsing happens to raise.
        reason = f"{type(error).__name__}: {error}"
    else:
        return from_meshio(mesh)
    where = f", at {reading.place} or before" if reading.place else ""
    raise MeshError(
        f"mesh file {str(file)!r} cannot be read{where}: {reason or 'meshio gives no reason'}; "
        "write it anew, or convert it to another of meshio's formats (.msh, .vtu, .inp, …)"
    )


def _silently_read(file: Path, reading: Reading, said: io.StringIO) -> Any:
    """What meshio reads, with bounds on what it takes, and what it prints in `said`.

    It tries one reader after the other, prints why each failed, and then exits.
    """
    meshio = meshio_of_all_kinds()  # before `bounded`, which puts bounds into its modules
    with (
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(said),
        bounded(reading),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")  # of deprecations, and of arithmetic on rubbish
        warnings.filterwarnings("error", message="string or file could not be read")
        return _read(file, meshio.read)


def meshio_of_all_kinds() -> Any:
    """Return meshio, taught the kinds of cells that its readers know and its meshes do not."""
    import meshio  # slow to import
    from meshio._mesh import topological_dimension

    for kind in KINDS:
        topological_dimension.setdefault(kind, 3)
    return meshio


def _read(file: Path, read: Callable[..., Any]) -> Any:
    if file.name.lower().endswith(".vol.gz"):  # unpacked by a reader of its own, without bounds
        with bounded_text(gzip.open(file)) as text:
            return read(text, "netgen")
    return read(file)


def is_meshio(source: Any) -> bool:
    """Return whether `source` is a `meshio.Mesh`, or looks like one."""
    return all(hasattr(source, name) for name in ("points", "cells", "point_sets", "cell_sets"))


def from_meshio(mesh: Any) -> RawMesh:
    """Return a `meshio.Mesh` as a `RawMesh`.

    Its groups are node sets, cell sets, Gmsh's physical groups and MED's groups, of any dimension.
    A physical group without a name is called after its dimension and tag, as in "surface 3".
    Groups of the same name are joined.

    Raises
    ------
    MeshError
        If groups name what is not there, or not by numbers.
    """
    blocks = tuple(RawBlock(str(block.type), np.asarray(block.data)) for block in mesh.cells)
    raw = RawMesh(mesh.points, blocks)
    try:
        node_sets = [(str(name), _indices(of)) for name, of in mesh.point_sets.items()]
        cell_sets = [
            (name, raw.first[i] + np.arange(len(blocks[i].cells))[members])
            for name, i, members in _cell_groups(mesh, blocks)
        ]
        node_sets += _med_points(mesh)
        named = (_joined(node_sets), _joined(cell_sets))
    except (ValueError, TypeError, LookupError, OverflowError, AttributeError) as error:
        raise MeshError(f"the named groups of the mesh are wrong: {error}") from None
    return RawMesh(mesh.points, blocks, *named)


def _joined(groups: list[tuple[str, IntArray]]) -> dict[str, IntArray]:
    found: dict[str, list[IntArray]] = {}
    for name, members in groups:
        if len(members):
            found.setdefault(name, []).append(members)
    return {name: np.unique(np.concatenate(parts)) for name, parts in found.items()}


# A group of cells: its name, the number of the block, and the cells' numbers there.
_CellGroup = tuple[str, int, npt.NDArray[Any]]


def _cell_groups(mesh: Any, blocks: tuple[RawBlock, ...]) -> Iterator[_CellGroup]:
    counts = [0, *(len(block.cells) for block in blocks)]
    for name, parts in mesh.cell_sets.items():
        if name.startswith("gmsh:"):  # a table of meshio's own, not a group
            continue
        through = _FLAC3D.match(name) is not None and "cell_ids" in mesh.cell_data
        first = np.cumsum(counts) if through else np.zeros(len(counts), int)
        for i, (_, members) in enumerate(zip(blocks, parts, strict=False)):
            if members is not None and len(members):
                yield str(name), i, _indices(members) - first[i]
    yield from _physical_groups(mesh, blocks)
    yield from _med_cells(mesh)


def _physical_groups(mesh: Any, blocks: tuple[RawBlock, ...]) -> Iterator[_CellGroup]:
    names = {
        (int(value[1]), int(value[0])): str(name)
        for name, value in mesh.field_data.items()
        if np.size(value) == 2
    }
    all_tags = mesh.cell_data.get("gmsh:physical", ())
    for i, (block, tags) in enumerate(zip(blocks, all_tags, strict=False)):
        for tag in np.unique(tags):
            if tag != 0:
                name = f"{_DIMENSION_NAMES[block.dim]} {tag}"
                yield names.get((block.dim, int(tag)), name), i, np.flatnonzero(tags == tag)


def _med_points(mesh: Any) -> Iterator[tuple[str, IntArray]]:
    tags = mesh.point_data.get("point_tags")
    if tags is not None:
        for tag, names in getattr(mesh, "point_tags", {}).items():
            for name in names:
                yield str(name), np.flatnonzero(tags == tag)


def _med_cells(mesh: Any) -> Iterator[_CellGroup]:
    all_tags = mesh.cell_data.get("cell_tags", ())
    for i, (_, tags) in enumerate(zip(mesh.cells, all_tags, strict=False)):
        for tag, names in getattr(mesh, "cell_tags", {}).items():
            for name in names:
                yield str(name), i, np.flatnonzero(tags == tag)


def _indices(members: Any) -> IntArray:
    array = np.asarray(members)
    return np.flatnonzero(array) if array.dtype == bool else array.astype(np.int64).reshape(-1)
