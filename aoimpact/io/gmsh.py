"""Reader of Gmsh's mesh files, versions 2.2 and 4.1, text and binary, with all groups.

The formats are those of the chapter "Gmsh file formats" of Gmsh's reference manual.
"""

from __future__ import annotations

import codecs
import re
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from ..base import FloatArray, IntArray, decoded, warn
from ..mesh import right_handed
from . import raw
from .raw import RawBlock, RawMesh

# meshio's kinds of elements in the order of Gmsh's type numbers, from 1.
_NAMES = (
    "line triangle quad tetra hexahedron wedge pyramid line3 triangle6 quad9 tetra10 hexahedron27 "
    "wedge18 pyramid14 vertex quad8 hexahedron20 wedge15 pyramid13"
)
_KINDS = dict(enumerate(_NAMES.split(), start=1))

# For each node in VTK's order, its number in Gmsh's order.
_HEXAHEDRON20 = (*range(9), 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15)
_ORDERS = {
    "tetra10": (*range(8), 9, 8),
    "hexahedron20": _HEXAHEDRON20,
    "hexahedron27": (*_HEXAHEDRON20, 22, 23, 21, 24, 20, 25, 26),
    "wedge15": (*range(7), 9, 7, 12, 14, 13, 8, 10, 11),
    "pyramid13": (*range(6), 8, 10, 6, 7, 9, 11, 12),
}

_PART = "it holds one part of a partitioned mesh, or says so; save all of it, without partitions"

# NumPy's types for the codes "i", "P" and "d" of `_Numbers.rows` in a binary file; None for text.
_Types = dict[str, np.dtype[np.generic]] | None

# For each entity (dimension, tag): numbers of its physical groups, or of its partitions.
_Tags = dict[tuple[int, int], set[int]]


# Elements of one type in one entity: the type, a key of `_KINDS`; element tags, shape (n,); node
# tags in Gmsh's order, shape (n, nodes per element); and for each physical group the row numbers of
# its elements.
_Elements = tuple[int, IntArray, IntArray, dict[int, IntArray]]


class _Numbers:
    """Reads the numbers of one section of a file in sequence."""

    def __init__(self, content: bytes, types: _Types) -> None:
        self.types, self.at = types, 0
        self.content: Any = raw.numbers_of(content) if types is None else content

    def rows(self, layout: str, count: int) -> FloatArray:
        """Return `count` rows; `layout`: type of each column, "i" int, "P" size_t, "d" double."""
        kind = np.dtype([("", self.types[name] if self.types else "f8") for name in layout])
        size = kind.itemsize if self.types else len(layout)
        start, left = self.at, (len(self.content) - self.at) // size
        if not 0 <= count <= left:
            raise ValueError(f"{count} rows of numbers are announced, but {left} are left")
        self.at += count * size
        if self.types is None:
            return np.reshape(self.content[start : self.at], (count, size))
        table = np.frombuffer(self.content, kind, count, start)
        return np.stack([table[name].astype(np.float64) for name in kind.names or ()], axis=1)

    def take(self, kind: str, count: int) -> FloatArray:
        return self.rows(kind, count)[:, 0]

    def ints(self, kind: str, count: int) -> IntArray:
        return raw.integers(self.take(kind, count))

    def count(self) -> int:
        return int(self.ints("P", 1)[0])

    def finish(self) -> None:
        left = self.content[self.at :]
        if len(left if self.types is None else left.strip()):
            raise ValueError("it has more numbers than it announces")


def read(file: Path) -> RawMesh:
    """Return the mesh in a file of Gmsh.

    Groups of the mesh are Gmsh's physical groups. A group without a name is called after its
    dimension and tag, as in "surface 3".

    Raises
    ------
    ValueError
        If the file is damaged, of another version, or one part of a partitioned mesh.
    """
    sections = _sections(file.read_bytes().removeprefix(codecs.BOM_UTF8))
    for name in ("MeshFormat", "Nodes", "Elements"):
        if name not in sections:
            raise ValueError(f"the section ${name} is missing")
    with raw.naming("section $MeshFormat"):
        version, types = _format(sections["MeshFormat"])
    groups: _Tags = {}
    parts: _Tags = {}
    n_parts = 0
    for name in ("Entities", "PartitionedEntities"):
        if name in sections:
            with raw.naming(f"section ${name}"):
                groups, parts, n_parts = _entities(_Numbers(sections[name], types), name)
    with raw.naming("section $PhysicalNames"):
        names = _names(sections.get("PhysicalNames", b"0"))
    with raw.naming("section $Nodes"):
        if version > 4.0:
            tags, places = _nodes_4(_Numbers(sections["Nodes"], types))
        else:
            count, _, rest = sections["Nodes"].partition(b"\n")
            numbers = _Numbers(rest, types)
            rows = numbers.rows("iddd", int(count))
            tags, places = raw.integers(rows[:, 0]), rows[:, 1:]
            numbers.finish()
    with raw.naming("section $Elements"):
        if version > 4.0:
            numbers = _Numbers(sections["Elements"], types)
            elements = _elements_4(numbers, groups, parts, n_parts)
        else:
            elements = _elements_2(sections["Elements"], types)
    return _mesh(tags, places, elements, names)


def _sections(content: bytes) -> dict[str, bytes]:
    """Return the text between $Name and $EndName of each section, by name."""
    found: dict[str, bytes] = {}
    header = re.compile(rb"\s*\$(\w+)[ \t\r]*\n")
    at = 0
    while content[at:].strip():
        match = header.match(content, at)
        if match is None:
            raise ValueError(f"a section is expected at byte {at}, got {content[at : at + 20]!r}")
        name = match[1].decode()
        if name in ("NOD", "ELM", "ParametricNodes"):  # sections of formats 1 and 2.2
            raise ValueError(f"the section ${name} is not read; save it as version 4.1")
        if name in ("Nodes", "Elements", "Entities") and name in found:
            raise ValueError(f"the section ${name} is there twice")
        ending = b"$End" + match[1]
        end = content.find(ending, match.end())
        if end < 0:
            raise ValueError(f"the section ${name} must end with $End{name}")
        found[name] = content[match.end() : end]
        at = end + len(ending)
    return found


def _format(text: bytes) -> tuple[float, _Types]:
    line, _, rest = text.partition(b"\n")
    words = line.decode("latin-1").split()
    if len(words) != 3:
        raise ValueError(f"{line.decode('latin-1')!r} is no version, file type and data size")
    version, binary, size = float(words[0]), int(words[1]), int(words[2])
    if version not in (2.0, 2.1, 2.2, 4.1):
        raise ValueError(f"version {words[0]} is not read; save the mesh as version 4.1 or 2.2")
    if not binary:
        return version, None
    order = {b"\1\0\0\0": "<", b"\0\0\0\1": ">"}.get(rest[:4])
    if size not in (4, 8) or order is None:
        raise ValueError(f"data size must be 4 or 8, got {size}; a binary integer 1 must follow")
    codes = {"i": f"{order}i4", "P": f"{order}u{size}", "d": f"{order}f8"}
    return version, {kind: np.dtype(code) for kind, code in codes.items()}


def _names(text: bytes) -> dict[tuple[int, int], str]:
    """Return group names by dimension and tag; the dimension is -1 if the file does not give it."""
    count, *lines = (decoded(text) or "").strip().splitlines()
    found = {}
    for line in lines:
        match = re.fullmatch(r'\s*(?:(\d+)\s+)?(-?\d+)\s*"(.*)"\s*', line)
        if match is None:
            raise ValueError(f"dimension, tag and name in quotes are expected, got {line!r}")
        found[int(match[1] or -1), abs(int(match[2]))] = match[3]
    raw.check_count("names", int(count), len(found))
    return found


def _entities(numbers: _Numbers, name: str) -> tuple[_Tags, _Tags, int]:
    """Return the physical groups and the partitions of each entity, and the number of partitions.

    An entity is a pair of dimension and tag.
    """
    groups, parts, n_parts = _Tags(), _Tags(), 0
    whole = name == "Entities"
    if not whole:
        n_parts = numbers.count()
        numbers.take("i", 2 * numbers.count())  # entities of ghost elements
    for dim, count in enumerate(numbers.ints("P", 4)):
        for _ in range(count):
            entity = dim, int(numbers.ints("i", 1 if whole else 3)[0])
            if not whole:
                parts[entity] = set(numbers.ints("i", numbers.count()).tolist())
            numbers.take("d", 6 if dim else 3)  # the entity's bounding box
            # A negative tag means that the group contains the entity with reversed orientation.
            groups[entity] = set(np.abs(numbers.ints("i", numbers.count())).tolist())
            if dim:
                numbers.take("i", numbers.count())  # tags of the bounding entities
    numbers.finish()
    return groups, parts, n_parts


def _nodes_4(numbers: _Numbers) -> tuple[IntArray, FloatArray]:
    n_blocks, n_nodes, _, _ = numbers.ints("P", 4)
    tags, places = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for _ in range(n_blocks):
        dim, _, parametric = numbers.ints("i", 3)
        count = numbers.count()
        tags.append(numbers.ints("P", count))
        width = 3 + (int(dim) if parametric else 0)
        places.append(numbers.take("d", width * count).reshape(count, width)[:, :3])
    numbers.finish()
    raw.check_count("nodes", n_nodes, sum(map(len, tags)))
    return np.concatenate(tags), np.concatenate(places)


def _width(type_: int) -> int:
    if type_ not in _KINDS:
        raise ValueError(f"elements of Gmsh's type {type_} are not read, only order 1 and 2")
    return raw.nodes_in(_KINDS[type_])


def _elements_4(numbers: _Numbers, groups: _Tags, parts: _Tags, n_parts: int) -> list[_Elements]:
    n_blocks, n_elements, _, _ = numbers.ints("P", 4)
    found = []
    # For each dimension, the partitions found; an element on a boundary may be in several.
    met: dict[int, set[int]] = {0: set()}
    for _ in range(n_blocks):
        dim, tag, type_ = (int(number) for number in numbers.ints("i", 3))
        count, width = numbers.count(), 1 + _width(type_)
        rows = numbers.ints("P", width * count).reshape(count, width)
        members = {group: np.arange(count) for group in groups.get((dim, tag), ())}
        met.setdefault(dim, set()).update(parts.get((dim, tag), ()))
        found.append((type_, rows[:, 0], rows[:, 1:], members))
    numbers.finish()
    raw.check_count("elements", n_elements, sum(len(tags) for _, tags, *_ in found))
    if len(met[max(met)]) < n_parts:
        raise ValueError(_PART)
    return found


def _elements_2(content: bytes, types: _Types) -> list[_Elements]:
    """Return the elements by type and entity, without repetitions.

    The file repeats an element for each physical group that contains it. The node order is reversed
    for a group that contains the entity with reversed orientation.
    """
    line, _, rest = content.partition(b"\n")
    chunks: list[tuple[int, int, IntArray]] = []  # type, number of tags, remaining columns
    if types is None:
        alike: dict[tuple[int, int, int], list[list[bytes]]] = {}
        for words in filter(None, map(bytes.split, rest.splitlines())):
            key = int(words[1]), int(words[2]), len(words)
            alike.setdefault(key, []).append(words[:1] + words[3:])
        chunks = [(*key[:2], np.array(rows).astype(np.int64)) for key, rows in alike.items()]
    else:
        numbers = _Numbers(rest, types)
        while sum(len(rows) for *_, rows in chunks) < int(line):
            kind, count, n_tags = numbers.ints("i", 3).tolist()
            table = numbers.ints("i", count * (1 + n_tags + _width(kind)))
            chunks.append((kind, n_tags, table.reshape(count, -1)))
        numbers.finish()
    raw.check_count("elements", int(line), sum(len(rows) for *_, rows in chunks))
    found: dict[tuple[int, int], list[IntArray]] = {}
    parts: set[int] = set()
    for kind, n_tags, rows in chunks:
        if n_tags < 2 or rows.shape[1] != 1 + n_tags + _width(kind):
            raise ValueError("elements must have two or more tags, and as many nodes as their type")
        # Columns: element number, physical tag, elementary tag, nodes.
        table = rows[:, np.r_[0:3, 1 + n_tags : rows.shape[1]]]
        for entity in np.unique(rows[:, 2]).tolist():
            found.setdefault((kind, entity), []).append(table[rows[:, 2] == entity])
        parts |= set(np.unique(rows[:, 4])) if n_tags > 3 else set()
    if len(parts) == 1:
        raise ValueError(_PART)
    return [_once(kind, np.concatenate(rows)) for (kind, _), rows in found.items()]


def _once(type_: int, rows: IntArray) -> _Elements:
    """Merge repeated elements of an entity; columns of `rows`: number, group, entity, nodes."""
    nodes, tags = rows[:, 3:], np.abs(rows[:, 1])
    if (tags == tags[0]).all():
        group = {int(tags[0]): np.arange(len(rows))} if tags[0] else {}
        return type_, rows[:, 0], nodes, group
    _, first, number = np.unique(
        np.sort(nodes, axis=1), axis=0, return_index=True, return_inverse=True
    )
    order = np.argsort(first)  # restores the order of the file
    number = np.argsort(order)[number.reshape(-1)]
    groups = {int(tag): np.unique(number[tags == tag]) for tag in np.unique(tags) if tag}
    return type_, rows[first[order], 0], nodes[first[order]], groups


def _mesh(
    tags: IntArray, places: FloatArray, elements: list[_Elements], names: dict[tuple[int, int], str]
) -> RawMesh:
    if len(again := raw.repeats(tags)):
        raise ValueError(f"node {tags[again[0]]} is there twice")
    groups: list[tuple[str, IntArray]] = []
    blocks, first = [], 0
    for type_, labels, nodes, members in elements:
        kind = _KINDS[type_]
        cells = raw.cells_of(tags, labels, nodes, lambda _, why: ValueError(why))
        cells = right_handed(kind, places, cells[:, _ORDERS.get(kind, slice(None))])
        blocks.append(RawBlock(kind, cells, labels))
        for tag, own in members.items():
            dim = blocks[-1].dim
            called = names.get((-1, tag), f"{raw.DIMENSIONS[dim]} {tag}")
            groups.append((names.get((dim, tag), called), first + own))
        first += len(cells)
    for name, count in Counter(names.values()).items():
        if count > 1:
            why = f"{count} physical groups are called {name!r}, and are merged into one"
            warn(f"{why}. Give groups of different dimensions different names")
    sets = raw.grouped(groups)
    if missing := [repr(name) for name in names.values() if name not in sets]:
        why = f"groups without elements in the file: {', '.join(missing)}"
        warn(f"{why}. Save it as version 4.1, or without SaveAll")
    return RawMesh(places, tuple(blocks), {}, sets, tags)
