"""Meshes of meshio: its files, and the names that they give to groups of nodes and cells."""

from __future__ import annotations

import contextlib
import gzip
import io
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...base import IntArray, MeshError, warn
from ..elements import KINDS
from .rawmesh import RawBlock, RawMesh

__all__ = ["from_meshio", "is_meshio", "meshio_of_all_kinds", "read"]


# meshio's names of kinds of cells: a shape and its number of nodes.
_KIND = re.compile(r"(vertex|line|triangle|quad|tetra|hexahedron|wedge|pyramid)\d*")

# Formats that are not read, by the end of a file's name, and why.
_REFUSED = {
    **dict.fromkeys(
        (".obj", ".off", ".ply", ".stl", ".svg", ".wkt"),
        "files {} hold surfaces, without volume cells; mesh the inside, and write .msh or .vtu",
    ),
    **dict.fromkeys(
        (".cgns", ".ele", ".h5m", ".hmf", ".node"),
        "files {} are not read; convert it to .msh, .vtu or .med",
    ),
}

# Formats that meshio reads from a stream, which is not read beyond its end for ever.
_STREAMS = ("ansys", "netgen", "tecplot")

# A zone of Tecplot.
_ZONE = re.compile(rb"^[ \t]*ZONE\b", re.I | re.M)

# Groups of FLAC3D's files, of which meshio numbers the members through, not by blocks.
_FLAC3D = re.compile("(zone|face):")

_DIMENSION_NAMES = ("point", "line", "surface", "volume")

# Integers of a text that may be counts or numbers of nodes, for which meshio's readers make arrays
# and loops: as large as this, or as this times the bytes of the file.
_LARGEST, _PER_BYTE = 10**6, 8


def read(file: Path) -> RawMesh:
    """Return what meshio reads of a file, with a warning of what was not checked.

    Raises
    ------
    MeshError
        If its format is not read, or it has cells of a kind that meshio cannot hold.
    ValueError
        If meshio cannot read the file, or numbers in it are out of proportion to its size.
    """
    suffix = file.suffix.lower()
    if suffix in _REFUSED:
        raise MeshError(f"mesh file {str(file)!r}: {_REFUSED[suffix].format(suffix)}")
    formats = _formats(file)
    if suffix == ".dat" and not _ZONE.search(file.read_bytes()):
        raise ValueError("it is neither a Nastran deck nor a file of Tecplot")
    _check_numbers(file)
    said = io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")  # NumPy's, about arithmetic on rubbish
            name, mesh = _tried(file, formats, said)
    except MemoryError:
        raise
    except ModuleNotFoundError as error:
        raise MeshError(
            f"mesh file {str(file)!r} needs the package {error.name}: pip install {error.name}"
        ) from None
    except Exception as error:
        # Readers meet malformed files with whatever their parsing happens to raise; some know
        # more kinds of cells, such as tetra4, than meshio's meshes can hold.
        kind = str(error.args[0]) if isinstance(error, KeyError) and error.args else ""
        if _KIND.fullmatch(kind):
            raise MeshError(
                f"mesh file {str(file)!r} has cells of an unsupported kind: {kind}; supported are "
                f"{', '.join(KINDS)}"
            ) from None
        plain = type(error) is ValueError
        said_why = (
            str(error) if plain else f"as {' or '.join(formats)}, {type(error).__name__}, {error}"
        )
        raise ValueError(said_why.rstrip(", ")) from None
    if said.getvalue().strip():
        warn(f"mesh file {file.name!r}: meshio says: {' '.join(said.getvalue().split())}")
    if np.ndim(mesh.points) != 2:
        raise ValueError("it has no table of coordinates")
    if name == "tecplot":
        _check_tecplot(file, mesh)
    else:
        warn(
            f"mesh file {file.name!r}: files of the format {name} are read by meshio, which may "
            "leave out what it does not know. Check the numbers of nodes, elements and groups: "
            f"{len(mesh.points)} nodes, {sum(len(block.data) for block in mesh.cells)} cells"
        )
    return from_meshio(mesh)


def _check_numbers(file: Path) -> None:
    """Refuse a text with an integer that is out of proportion to its size."""
    content = file.read_bytes()
    if b"\0" in content or file.suffix.lower() in (".xml", ".xdmf", ".xmf"):
        return
    most = max(_LARGEST, _PER_BYTE * len(content))
    for match in re.finditer(rb"(?<![\d.+\-eEdD])\d{7,}(?![\d.eEdD])", content):
        if int(match[0][:40]) > most:
            line = 1 + content.count(b"\n", 0, match.start())
            raise ValueError(
                f"the number {match[0][:40].decode()} in line {line} is out of proportion to the "
                f"size of the file, {len(content)} bytes"
            )


def _formats(file: Path) -> list[str]:
    """Return meshio's names of the formats that a file may be of."""
    suffixes = [suffix.lower() for suffix in file.suffixes[-2:]]
    known = meshio_of_all_kinds().extension_to_filetypes
    found = [name for i in range(len(suffixes)) for name in known.get("".join(suffixes[i:]), ())]
    if not found:
        raise ValueError(f"no format of files {file.suffix or 'without a suffix'} is known")
    return found


def _tried(file: Path, formats: list[str], said: io.StringIO) -> tuple[str, Any]:
    """Return the mesh, and the name of the first of some formats that fits."""
    meshio = meshio_of_all_kinds()
    errors = []
    for name in formats:
        try:
            if name == "flac3d" and b"\0" in file.read_bytes():
                raise ValueError("binary files of FLAC3D are not read; export it as text")
            if name not in _STREAMS:
                return name, meshio.read(file, name)
            if name == "ansys":
                with _Binary(io.FileIO(file)) as binary:
                    return name, meshio.read(binary, name)
            content = file.read_bytes()
            packed = file.suffix.lower() == ".gz"
            text = _Text(io.BytesIO(gzip.decompress(content) if packed else content))
            return name, meshio.read(text, name)
        except meshio.ReadError as error:
            errors.append(f"{name}: {error}")
        except SystemExit:  # after the reason was printed
            errors.append(f"{name}: {' '.join(said.getvalue().split())}")
            said.truncate(said.seek(0))
    raise ValueError("; ".join(errors))


def meshio_of_all_kinds() -> Any:
    """Return meshio, taught the kinds of cells that its readers know and its meshes do not."""
    import meshio  # slow to import
    from meshio._mesh import topological_dimension

    for kind in KINDS:
        topological_dimension.setdefault(kind, 3)
    return meshio


class _Binary(io.BufferedReader):
    """A file that refuses to be read on and on beyond its end."""

    _empty = 0

    def read(self, size: Any = -1, /) -> bytes:
        return bytes(self._checked(super().read(size)))

    def readline(self, size: Any = -1, /) -> bytes:
        return bytes(self._checked(super().readline(size)))

    def _checked(self, got: Any) -> Any:
        self._empty = 0 if got else self._empty + 1
        if self._empty > 10:
            raise EOFError("unexpected end of file")
        return got


class _Text(io.TextIOWrapper):
    """The same of text."""

    _empty = 0

    def readline(self, size: Any = -1, /) -> str:  # type: ignore[override]
        got = super().readline(size)
        self._empty = 0 if got else self._empty + 1
        if self._empty > 10:
            raise EOFError("unexpected end of file")
        return got


def _check_tecplot(file: Path, mesh: Any) -> None:
    """Compare the mesh with what the file's zones announce; meshio reads the first one."""
    text = re.sub(r'"[^"]*"', "", file.read_text("latin-1")).upper()
    zones = re.split(r"^\s*ZONE\b", text, flags=re.MULTILINE)[1:]
    if len(zones) != 1:
        raise ValueError(f"it has {len(zones)} zones; write the mesh as one")
    for names, there in (
        (("NODES", "N"), len(mesh.points)),
        (("ELEMENTS", "E"), sum(len(block.data) for block in mesh.cells)),
    ):
        found = re.search(rf"\b({'|'.join(names)})\s*=\s*(\d+)", zones[0])
        if found is None or int(found[2]) != there:
            raise ValueError(f"{names[0].lower()}: {there} were read, not what the zone announces")


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
