"""Mesh files through meshio: reading any of them, and the names they give to groups of nodes."""

from __future__ import annotations

import contextlib
import gzip
import io
import os
import re
import stat
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import IntArray, MemoryLimitError, MeshError, MissingFileError, file_path
from .elements import KINDS
from .guard import Reading, bounded, bounded_text

__all__ = ["load", "meshio_of_all_kinds", "named_cells", "named_nodes"]


# meshio's names of kinds of cells: a shape and its number of nodes.
_KIND = re.compile(r"(vertex|line|triangle|quad|tetra|hexahedron|wedge|pyramid)\d*")

# Formats that hold no volume cells: there is nothing to be read.
_SURFACES = (".obj", ".off", ".ply", ".stl", ".svg", ".wkt")

# Groups of FLAC3D's files, of which meshio numbers the members through, not by blocks.
_FLAC3D = re.compile("(zone|face):")

_DIMENSION_NAMES = ("point", "line", "surface", "volume")


def load(path: str | os.PathLike[str]) -> Any:
    """Return the file as a `meshio.Mesh`.

    Raises
    ------
    MissingFileError
        If there is no such file.
    MeshError
        If it is empty, of a format that meshio does not read, or has cells of a kind that meshio
        cannot hold.
    MemoryLimitError
        If there is not enough memory for it.
    """
    file, size = _existing(path)
    if file.suffix.lower() in _SURFACES:
        raise MeshError(
            f"mesh file {str(file)!r}: files {file.suffix} hold surfaces, without volume cells; "
            "mesh the inside, and write .msh, .vtu or .inp"
        )
    said = io.StringIO()
    reading = Reading(size)
    try:
        return _silently_read(file, reading, said)
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


def _existing(path: str | os.PathLike[str]) -> tuple[Path, int]:
    """Return the file and its size in bytes."""
    file = file_path("mesh", path)
    try:
        state = file.stat()
    except FileNotFoundError:
        raise MissingFileError(
            f"mesh file {str(file)!r} does not exist (in {os.getcwd()})"
        ) from None
    except OSError as error:  # no access, or a name that is too long
        raise MeshError(f"mesh file {str(file)!r} cannot be opened: {error}") from None
    if not stat.S_ISREG(state.st_mode):
        what = "a directory" if stat.S_ISDIR(state.st_mode) else "no regular file"
        raise MeshError(f"mesh file {str(file)!r} is {what}")
    if state.st_size == 0:
        raise MeshError(f"mesh file {str(file)!r} is empty")
    return file, state.st_size


def _read(file: Path, read: Callable[..., Any]) -> Any:
    if file.name.lower().endswith(".vol.gz"):  # unpacked by a reader of its own, without bounds
        with bounded_text(gzip.open(file)) as text:
            return read(text, "netgen")
    return read(file)


# Of a group of cells: its name, the number of the block, and the cells' numbers there.
_CellGroup = tuple[str, int, npt.NDArray[Any]]


def named_nodes(mesh: Any) -> dict[str, IntArray]:
    """Return the named groups of a `meshio.Mesh` as sorted node numbers.

    Node sets, cell sets, Gmsh's physical groups and MED's groups, of any dimension; a group of
    cells is the set of their nodes. A physical group without a name is called after its dimension
    and tag, as in "surface 3". Groups of the same name are joined.

    Raises
    ------
    MeshError
        If groups name what is not there, or not by numbers.
    """
    return _joined(
        lambda: chain(
            ((str(name), _indices(members)) for name, members in mesh.point_sets.items()),
            ((name, _nodes_of(mesh.cells[i], of)) for name, i, of in _cell_groups(mesh)),
            _med_points(mesh),
        )
    )


def named_cells(mesh: Any, first: Mapping[int, int]) -> dict[str, IntArray]:
    """Return the named groups of cells of a `meshio.Mesh` as sorted numbers.

    Parameters
    ----------
    mesh : meshio.Mesh
    first : mapping of int to int
        By the number of a block, the number of its first cell; of the blocks that count.

    Raises
    ------
    MeshError
        As for `named_nodes`.
    """
    return _joined(
        lambda: (
            (name, first[i] + _checked_members(mesh.cells[i], of))
            for name, i, of in _cell_groups(mesh)
            if i in first
        )
    )


def _joined(groups: Callable[[], Iterable[tuple[str, IntArray]]]) -> dict[str, IntArray]:
    found: dict[str, list[IntArray]] = {}
    try:
        for name, members in groups():
            if len(members):
                found.setdefault(name, []).append(members)
    except (ValueError, TypeError, LookupError, OverflowError, AttributeError) as error:
        raise MeshError(f"the named groups of the mesh are wrong: {error}") from None
    return {name: np.unique(np.concatenate(parts)) for name, parts in found.items()}


def _cell_groups(mesh: Any) -> Iterator[_CellGroup]:
    counts = [0, *(len(block.data) for block in mesh.cells)]
    for name, blocks in mesh.cell_sets.items():
        if name.startswith("gmsh:"):  # a table of meshio's own, not a group
            continue
        through = _FLAC3D.match(name) is not None and "cell_ids" in mesh.cell_data
        first = np.cumsum(counts) if through else np.zeros(len(counts), int)
        for i, (_, members) in enumerate(zip(mesh.cells, blocks, strict=False)):
            if members is not None and len(members):
                yield str(name), i, _indices(members) - first[i]
    yield from _physical_groups(mesh)
    yield from _med_cells(mesh)


def _physical_groups(mesh: Any) -> Iterator[_CellGroup]:
    names = {
        (int(value[1]), int(value[0])): str(name)
        for name, value in mesh.field_data.items()
        if np.size(value) == 2
    }
    all_tags = mesh.cell_data.get("gmsh:physical", ())
    for i, (block, tags) in enumerate(zip(mesh.cells, all_tags, strict=False)):
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


def _checked_members(block: Any, members: npt.NDArray[Any]) -> IntArray:
    checked: IntArray = np.arange(len(block.data))[members]
    return checked


def _nodes_of(block: Any, members: npt.NDArray[Any]) -> IntArray:
    return np.unique(np.asarray(block.data)[members]).astype(np.int64)


def _indices(members: Any) -> IntArray:
    array = np.asarray(members)
    return np.flatnonzero(array) if array.dtype == bool else array.astype(np.int64).reshape(-1)
