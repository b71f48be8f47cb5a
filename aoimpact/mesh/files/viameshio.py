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
from .raw import DIMENSIONS, RawBlock, RawMesh, check_count, grouped

# meshio's names of kinds of cells: a shape and its number of nodes.
_KIND = re.compile(r"(vertex|line|triangle|quad|tetra|hexahedron|wedge|pyramid)\d*")

# Reasons to refuse formats, by the end of a file's name.
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

# Formats that meshio reads from a stream, of which readers would go on beyond the end for ever.
_STREAMS = ("ansys", "netgen", "tecplot")

# A zone of Tecplot.
_ZONE = re.compile(rb"^[ \t]*ZONE\b", re.I | re.M)

# Groups of FLAC3D's files, of which meshio numbers the members through, not by blocks.
_FLAC3D = re.compile("(zone|face):")

# Integers of a text may be counts or numbers of nodes, for which meshio's readers make arrays and
# loops. Refused are those above both this number and this number times the bytes of the file.
_LARGEST, _PER_BYTE = 10**6, 8


def read(file: Path) -> RawMesh:
    """Return the mesh that meshio reads, with a warning that it was not checked.

    Raises
    ------
    MeshError
        If its format is not read, or it has cells of a kind that meshio cannot hold.
    ValueError
        If meshio cannot read the file, or numbers in it are out of proportion to its size.
    """
    suffix, where = file.suffix.lower(), f"mesh file {str(file)!r}"
    if suffix in _REFUSED:
        raise MeshError(f"{where}: {_REFUSED[suffix].format(suffix)}")
    suffixes = [each.lower() for each in file.suffixes[-2:]]
    known = meshio_of_all_kinds().extension_to_filetypes
    formats = [name for i in range(len(suffixes)) for name in known.get("".join(suffixes[i:]), ())]
    if not formats:
        raise ValueError(f"no format of files {file.suffix or 'without a suffix'} is known")
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
        raise MeshError(f"{where} needs the package {error.name}: pip install it") from None
    except Exception as error:
        # Readers raise any error on malformed files. A KeyError may name a kind of cells, such as
        # tetra4, that meshio's meshes cannot hold.
        kind = str(error.args[0]) if isinstance(error, KeyError) and error.args else ""
        if _KIND.fullmatch(kind):
            kinds = ", ".join(KINDS)
            raise MeshError(
                f"{where} has cells of an unsupported kind: {kind}; supported are {kinds}"
            ) from None
        why = f"as {' or '.join(formats)}, {type(error).__name__}, {error}".rstrip(", ")
        raise ValueError(str(error) if type(error) is ValueError else why) from None
    if said.getvalue().strip():
        warn(f"mesh file {file.name!r}: meshio says: {' '.join(said.getvalue().split())}")
    if np.ndim(mesh.points) != 2:
        raise ValueError("it has no table of coordinates")
    n_nodes, n_cells = len(mesh.points), sum(len(block.data) for block in mesh.cells)
    if name == "tecplot":
        _check_tecplot(file, n_nodes, n_cells)
    else:
        warn(
            f"mesh file {file.name!r}: files of the format {name} are read by meshio, and parts "
            f"that it does not know may be missing. Check the numbers of nodes, elements and "
            f"groups: {n_nodes} nodes, {n_cells} cells"
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
            line, text = 1 + content.count(b"\n", 0, match.start()), match[0][:40].decode()
            raise ValueError(
                f"the number {text} in line {line} is out of proportion to the size of the file, "
                f"{len(content)} bytes"
            )


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


class _Ending:
    """A stream that raises an error if it is read on and on beyond its end."""

    _empty = 0

    def _checked(self, got: Any) -> Any:
        self._empty = 0 if got else self._empty + 1
        if self._empty > 10:
            raise EOFError("unexpected end of file")
        return got

    def read(self, size: Any = -1, /) -> Any:
        return self._checked(super().read(size))  # type: ignore[misc]

    def readline(self, size: Any = -1, /) -> Any:
        return self._checked(super().readline(size))  # type: ignore[misc]


class _Binary(_Ending, io.BufferedReader):
    """A binary file of this sort."""


class _Text(_Ending, io.TextIOWrapper):
    """A text of this sort."""


def _check_tecplot(file: Path, n_nodes: int, n_cells: int) -> None:
    """Compare numbers with those that the file's zone announces; meshio reads the first zone."""
    text = re.sub(r'"[^"]*"', "", file.read_text("latin-1")).upper()
    zones = re.split(r"^\s*ZONE\b", text, flags=re.MULTILINE)[1:]
    if len(zones) != 1:
        raise ValueError(f"it has {len(zones)} zones; write the mesh as one")
    for names, there in (("NODES|N", n_nodes), ("ELEMENTS|E", n_cells)):
        found = re.search(rf"\b(?:{names})\s*=\s*(\d+)", zones[0])
        check_count(names.partition("|")[0].lower(), -1 if found is None else int(found[1]), there)


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
    first = RawMesh(mesh.points, blocks).first
    try:
        node_sets = grouped((str(name), _indices(of)) for name, of in _point_groups(mesh))
        cell_sets = grouped(
            (str(name), first[i] + np.arange(len(blocks[i].cells))[_indices(members)])
            for name, i, members in _cell_groups(mesh, blocks)
        )
    except (ValueError, TypeError, LookupError, OverflowError, AttributeError) as error:
        raise MeshError(f"the named groups of the mesh are wrong: {error}") from None
    return RawMesh(mesh.points, blocks, node_sets, cell_sets)


def _point_groups(mesh: Any) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    yield from mesh.point_sets.items()
    if (tags := mesh.point_data.get("point_tags")) is not None:
        for tag, names in getattr(mesh, "point_tags", {}).items():  # MED's
            for name in names:
                yield name, tags == tag


def _cell_groups(
    mesh: Any, blocks: tuple[RawBlock, ...]
) -> Iterator[tuple[str, int, npt.NDArray[Any]]]:
    """Yield names of groups, numbers of blocks, and members in these by number or mask."""
    first = RawMesh(mesh.points, blocks).first
    for name, parts in mesh.cell_sets.items():
        if name.startswith("gmsh:"):  # a table of meshio's own, not a group
            continue
        through = _FLAC3D.match(name) is not None and "cell_ids" in mesh.cell_data
        for i, members in enumerate(parts[: len(blocks)]):
            if members is not None and len(members):
                yield name, i, _indices(members) - first[i] if through else members
    names = {
        (int(value[1]), int(value[0])): name
        for name, value in mesh.field_data.items()
        if np.size(value) == 2
    }
    physical = mesh.cell_data.get("gmsh:physical", ())
    for i, (block, tags) in enumerate(zip(blocks, physical, strict=False)):
        for tag in np.unique(tags).astype(int).tolist():
            if tag != 0:
                unnamed = f"{DIMENSIONS[block.dim]} {tag}"
                yield names.get((block.dim, tag), unnamed), i, np.asarray(tags) == tag
    for i, (_, tags) in enumerate(zip(blocks, mesh.cell_data.get("cell_tags", ()), strict=False)):
        for tag, called in getattr(mesh, "cell_tags", {}).items():  # MED's
            for name in called:
                yield name, i, tags == tag


def _indices(members: Any) -> IntArray:
    array = np.asarray(members)
    return np.flatnonzero(array) if array.dtype == bool else array.astype(np.int64).reshape(-1)
