"""Meshes from meshio: files that meshio reads, and the groups of a `meshio.Mesh`."""

from __future__ import annotations

import contextlib
import io
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import IntArray, MeshError, warn
from ..mesh import meshio_of_all_kinds
from .raw import DIMENSIONS, RawBlock, RawMesh, check_count, grouped

# For each of meshio's formats: the suffixes of files, and two patterns that find the announced
# numbers of nodes and of cells in a text file. The numbers that one pattern finds are summed.
_FORMATS: dict[str, tuple[str, ...]] = {
    "avsucd": (".avs", r"\A(?:#.*\n)*\s*(\d+)", r"\A(?:#.*\n)*\s*\d+\s+(\d+)"),
    "dolfin-xml": (".xml", r'<vertices\s+size="(\d+)"', r'<cells\s+size="(\d+)"'),
    "medit": (
        ".mesh .meshb",
        r"\bVertices\s+(\d+)",
        r"\b(?:Edges|Triangles|Quadrilaterals|Tetrahedra|Hexah?edra|Prisms|Pyramids)\s+(\d+)",
    ),
    "permas": (".dato .post",),
    "su2": (".su2", r"\bNPOIN\s*=\s*(\d+)", r"\b(?:NELEM|MARKER_ELEMS)\s*=\s*(\d+)"),
    "ugrid": (".ugrid", r"\A\s*(\d+)", r"\A\s*\d+" + 6 * r"\s+(\d+)"),
    "vtk": (".vtk", r"(?m)^POINTS\s+(\d+)", r"(?m)^CELL_TYPES\s+(\d+)"),
    "xdmf": (
        ".xdmf .xmf",
        r'<Geometry[^>]*>\s*<DataItem[^>]*Dimensions="(\d+)',
        r'<Topology[^>]*NumberOfElements="(\d+)"',
    ),
}

# Pattern of meshio's warning that names of SU2 markers are lost. The warning is not passed on,
# since `read` restores the names.
_RENUMBERED = re.compile(r"(Warning: )?meshio does not support tags of string.*?replaced by \d+")

_INDEXED = re.compile(r"<(vertex|triangle|tetrahedron)\s+index\s*=\W(\d+)")

# Keys of meshio's cell data with group numbers, and the word before the number in the name of a
# group, as in "ref 3". Groups of Gmsh are called by their name, or by dimension and number.
_TAGS = {"avsucd:material": "material", "medit:ref": "ref", "su2:tag": "tag", "gmsh:physical": ""}


def read(file: Path) -> RawMesh:
    """Return the mesh that meshio reads from a file; check the numbers of nodes and cells.

    Raises
    ------
    MeshError
        If the format is not read, or needs a package that is missing.
    ValueError
        If meshio cannot read the file, or it has other numbers of nodes or cells than announced.

    Warns
    -----
    AOImpactWarning
        If meshio warns, or the file announces no numbers of nodes and cells.
    """
    where, suffix = f"mesh file {str(file)!r}", file.suffix.lower()
    name = next((name for name, (ends, *_) in _FORMATS.items() if suffix in ends.split()), None)
    if name is None:
        kind = f"files {file.suffix}" if file.suffix else "files without a suffix"
        raise MeshError(f"{where}: {kind} are not read; write .msh or .vtu")
    content = file.read_bytes()
    text = "" if b"\0" in content and name != "vtk" else content.decode("latin-1")
    announced = []
    for pattern in _FORMATS[name][1:] if text else ():
        found = [match.groups() for match in re.finditer(pattern, text)]
        announced.append(sum(int(count[:19]) for counts in found for count in counts))
        if not found or announced[-1] > len(content):
            raise ValueError(f"as {name}, it must announce nodes and cells that fit its size")
    if name == "dolfin-xml":  # where an entry is missing, meshio returns arbitrary numbers
        check_count("entries with an index", sum(announced), len(set(_INDEXED.findall(text))))
    said = io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")  # NumPy's warnings about invalid values
            mesh = meshio_of_all_kinds().read(file, name)
    except MemoryError:
        raise
    except ModuleNotFoundError as error:
        raise MeshError(f"{where} needs the package {error.name}: pip install it") from None
    except (Exception, SystemExit) as error:  # readers raise anything on malformed files
        why = " ".join([type(error).__name__, str(error), *said.getvalue().split()])
        raise ValueError(f"as {name}, {why}") from None
    tag = 0
    for marker in re.findall(r"^MARKER_TAG=\s*(\S+)", text, re.M) if name == "su2" else ():
        tag = int(marker) if marker.isdecimal() else tag + 1  # as meshio numbers markers
        marker = f"tag {tag}" if marker.isdecimal() else marker
        if mesh.field_data.setdefault(f"{name}:tag {tag}", marker) != marker:
            raise ValueError(f"meshio takes marker {marker!r} for another; give all of them names")
    if words := " ".join(_RENUMBERED.sub("", " ".join(said.getvalue().split())).split()):
        warn(f"mesh file {file.name!r}: meshio says: {words}")
    if np.ndim(mesh.points) != 2:
        raise ValueError("it has no table of coordinates")
    there = len(mesh.points), sum(len(block.data) for block in mesh.cells)
    for what, count, wanted in zip(("nodes", "cells"), there, announced, strict=False):
        check_count(what, wanted, count)
    if not announced:
        read = f"{there[0]} nodes and {there[1]} cells"
        warn(f"mesh file {file.name!r} announces no numbers; check that it has {read}")
    for size in re.findall(r"(?m)^CELLS\s+\d+\s+(\d+)", text) if name == "vtk" else ():
        nodes = sum(block.data.size for block in mesh.cells)
        check_count("numbers of cells", int(size) - there[1] * ("OFFSETS" not in text), nodes)
    return from_meshio(mesh)


def is_meshio(source: Any) -> bool:
    """Return whether `source` is a `meshio.Mesh`, or looks like one."""
    return all(hasattr(source, name) for name in ("points", "cells", "point_sets", "cell_sets"))


def from_meshio(mesh: Any) -> RawMesh:
    """Return a `meshio.Mesh` as a `RawMesh`.

    The mesh's node sets, cell sets, Gmsh's physical groups, MED's groups, and tags of other formats
    (such as "ref 3") become groups. A physical group without a name is called after its dimension
    and tag, as in "surface 3". Groups of the same name are joined.

    Raises
    ------
    MeshError
        If groups have members that do not exist, or that are no numbers.
    """
    blocks = tuple(RawBlock(str(block.type), np.asarray(block.data)) for block in mesh.cells)
    first = RawMesh(mesh.points, blocks).first
    try:
        nodes = [*mesh.point_sets.items()]
        if (tags := mesh.point_data.get("point_tags")) is not None:  # families of MED
            for tag, names in getattr(mesh, "point_tags", {}).items():
                nodes += [(name, tags == tag) for name in names]
        node_sets = grouped((str(name), _indices(of)) for name, of in nodes)
        cell_sets = grouped(
            (str(name), first[i] + np.arange(len(blocks[i].cells))[_indices(members)])
            for name, i, members in _cell_groups(mesh, blocks)
        )
    except (ValueError, TypeError, LookupError, OverflowError, AttributeError) as error:
        raise MeshError(f"the named groups of the mesh are wrong: {error}") from None
    return RawMesh(mesh.points, blocks, node_sets, cell_sets)


def _cell_groups(
    mesh: Any, blocks: tuple[RawBlock, ...]
) -> Iterator[tuple[str, int, npt.NDArray[Any]]]:
    """Yield group name, block number, and members (numbers or mask) for each group and block."""
    for name, parts in mesh.cell_sets.items():
        if name.startswith("gmsh:"):  # a table of meshio, not a group
            continue
        for i, members in enumerate(parts[: len(blocks)]):
            if members is not None and len(members):
                yield name, i, members
    names = {
        (int(value[1]), int(value[0])): name
        for name, value in mesh.field_data.items()
        if np.size(value) == 2
    }
    for key, called in _TAGS.items():
        for i, (block, tags) in enumerate(zip(blocks, mesh.cell_data.get(key, ()), strict=False)):
            for tag in np.unique(tags).astype(int).tolist():
                if called or tag:
                    name = f"{called or DIMENSIONS[block.dim]} {tag}"
                    name = name if called else names.get((block.dim, tag), name)
                    yield mesh.field_data.get(f"{key} {tag}", name), i, np.asarray(tags) == tag
    for i, (_, tags) in enumerate(zip(blocks, mesh.cell_data.get("cell_tags", ()), strict=False)):
        for tag, called in getattr(mesh, "cell_tags", {}).items():  # families of MED
            for name in called:
                yield name, i, tags == tag


def _indices(members: Any) -> IntArray:
    array = np.asarray(members)
    return np.flatnonzero(array) if array.dtype == bool else array.astype(np.int64).reshape(-1)
