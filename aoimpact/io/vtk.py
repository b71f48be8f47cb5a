"""VTK's files of unstructured grids: legacy (.vtk) and XML (.vtu).

The formats are those of "VTK File Formats" (docs.vtk.org). They have no groups and no numbers of
nodes or elements.
"""

from __future__ import annotations

import base64
import binascii
import lzma
import re
import zlib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, IntArray
from ..mesh import right_handed
from .raw import RawBlock, RawMesh, check_count, firsts, integers, nodes_in, numbers_of

# Kinds of cells by VTK's numbers.
_LINEAR = "vertex line triangle quad quad tetra hexahedron hexahedron wedge pyramid"
_QUADRATIC = "line3 triangle6 quad8 tetra10 hexahedron20 wedge15 pyramid13 quad9 hexahedron27"
_KINDS = {
    **dict(zip((1, 3, 5, 8, 9, 10, 11, 12, 13, 14), _LINEAR.split(), strict=True)),
    **dict(enumerate(_QUADRATIC.split(), start=21)),
}

# Points, lines and surfaces of any number of nodes or order.
_WITHOUT_VOLUME = (0, 2, 4, 6, 7, 30, 34, 35, 36, 51, 60, 61, 62, 68, 69, 70, 75, 76, 77)

# Pixels and voxels go along the axes, quadrilaterals and hexahedra around.
_ORDERS = {8: (0, 1, 3, 2), 11: (0, 1, 3, 2, 4, 5, 7, 6)}

# Types of numbers in XML, which are NumPy's but for capitals, and NumPy's by those of legacy files.
_XML_TYPES = re.compile("U?Int(8|16|32|64)|Float(32|64)")
_LEGACY_TYPES = {
    **{"char": "i1", "short": "i2", "int": "i4", "long": "i8", "vtktypeint64": "i8"},
    **{"unsigned_char": "u1", "unsigned_short": "u2", "unsigned_int": "u4", "unsigned_long": "u8"},
    **{"float": "f4", "double": "f8", "vtkidtype": "i4"},
}

_SAVE = "save it as an unstructured grid"

_COMPRESSORS: dict[str, Any] = {
    "": None,
    "vtkZLibDataCompressor": zlib.decompress,
    "vtkLZMADataCompressor": lzma.decompress,
}


def _raw_mesh(points: FloatArray, types: IntArray, ends: IntArray, nodes: IntArray) -> RawMesh:
    """Return the mesh of cells whose nodes end at `ends` in `nodes`."""
    starts = np.concatenate([[0], ends])[:-1]
    counts = ends - starts
    if len(types) != len(ends) or counts.sum() != len(nodes) or (counts < 0).any():
        raise ValueError("the numbers of cells, types and nodes do not fit each other")
    blocks = []
    for type_ in np.setdiff1d(types, _WITHOUT_VOLUME).tolist():
        of = np.flatnonzero(types == type_)
        if type_ not in _KINDS:
            blocks.append(RawBlock(f"VTK type {type_}", np.zeros((len(of), 1), np.int64)))
            continue
        kind, width = _KINDS[type_], nodes_in(_KINDS[type_])
        if wrong := set(counts[of].tolist()) - {width}:
            raise ValueError(f"a {kind} has {width} nodes, not {wrong.pop()}")
        cells = nodes[starts[of][:, None] + np.arange(width)][:, _ORDERS.get(type_, slice(None))]
        # Wedges of VTK's own are left-handed, those of other programs are not.
        if kind in ("wedge", "wedge15") and 0 <= cells.min() <= cells.max() < len(points):
            cells = right_handed(kind, points, cells)
        blocks.append(RawBlock(kind, cells))
    return RawMesh(points, tuple(blocks))


def _from_bytes(content: bytes, dtype: np.dtype[Any], count: int) -> npt.NDArray[Any]:
    if not 0 <= count <= len(content) // dtype.itemsize:
        raise ValueError(f"{count} numbers are announced, but there is room for fewer")
    return np.frombuffer(content, dtype, count)


# --------------------------------------------------------------------------------------- legacy


class _Legacy:
    """A legacy file, read from its beginning on."""

    def __init__(self, content: bytes) -> None:
        self.content, self.at = content, 0
        if not self.line().startswith("# vtk DataFile Version"):
            raise ValueError("it does not begin with '# vtk DataFile Version'")
        self.line()  # a title
        kind = self.line().upper()
        if kind not in ("ASCII", "BINARY"):
            raise ValueError(f"{kind!r} is neither ASCII nor BINARY")
        self.binary = kind == "BINARY"

    def line(self) -> str:
        end = self.content.find(b"\n", self.at)
        end = len(self.content) if end < 0 else end
        text = self.content[self.at : end].decode("latin-1").strip()
        self.at = end + 1
        return text

    def words(self) -> list[str]:
        """Return the words of the next line that is not blank; none at the end."""
        while self.at < len(self.content):
            if found := self.line().split():
                return found
        return []

    def numbers(self, count: int, type_: str) -> FloatArray:
        if type_.lower() not in _LEGACY_TYPES:
            raise ValueError(f"data of type {type_!r} are not read")
        dtype = np.dtype(">" + _LEGACY_TYPES[type_.lower()])
        if self.binary:
            start, self.at = self.at, self.at + count * dtype.itemsize
            return _from_bytes(self.content[start:], dtype, count).astype(np.float64)
        end = re.compile(rb"\n[ \t]*[A-Z]").search(self.content, self.at - 1)
        stop = end.start() + 1 if end else len(self.content)
        values = numbers_of(self.content[self.at : stop])
        self.at = stop
        check_count("numbers", count, len(values))
        return values

    def cells(self, count: int, size: int) -> tuple[IntArray, IntArray]:
        """Return where the nodes of each cell end, and the nodes of all."""
        start, found = self.at, []
        for name, length in (("OFFSETS", count), ("CONNECTIVITY", size)):  # of version 5
            words = self.words()
            if words[:1] == [name] and len(words) == 2:
                found.append(integers(self.numbers(length, words[1])))
            elif found or words[:1] == [name]:
                raise ValueError(f"{name} with its type of numbers is expected")
            else:
                break
        if found:
            return found[0][1:], found[1]  # there is one offset more than cells
        self.at = start
        rows = integers(self.numbers(size, "int"))
        heads: list[int] = []
        at = 0
        while len(heads) < count and 0 <= at < size and rows[at] >= 0:
            heads.append(at)
            at += 1 + int(rows[at])
        if at != size or len(heads) < count:
            raise ValueError("the cells do not fill the numbers announced for them")
        return np.cumsum(rows[heads]), np.delete(rows, heads)


def read_legacy(file: Path) -> RawMesh:
    """Return the mesh in a legacy file of an unstructured grid.

    Raises
    ------
    ValueError
        If the file is damaged or has another kind of data set.
    """
    reader = _Legacy(file.read_bytes())
    points: FloatArray | None = None
    types = ends = nodes = np.zeros(0, np.int64)
    while words := reader.words():
        # CELL_DATA and POINT_DATA, after the mesh, are no part of it.
        match [words[0].upper(), *words[1:]]:
            case ["CELL_DATA" | "POINT_DATA", *_]:
                break
            case ["DATASET", "UNSTRUCTURED_GRID"]:
                pass
            case ["DATASET", *kind]:
                raise ValueError(f"the data set is {' '.join(kind)}; {_SAVE}")
            case ["METADATA"]:
                while reader.at < len(reader.content) and reader.line():
                    pass
            case ["FIELD", _, count]:
                for _ in range(int(count)):
                    words = reader.words()
                    if len(words) != 4:
                        raise ValueError(f"{' '.join(words)[:40]!r} is no head of a field")
                    reader.numbers(int(words[1]) * int(words[2]), words[3])
            case ["POINTS", count, type_]:
                points = reader.numbers(3 * int(count), type_).reshape(-1, 3)
            case ["CELLS", count, size]:
                ends, nodes = reader.cells(int(count), int(size))
            case ["CELL_TYPES", count]:
                types = integers(reader.numbers(int(count), "int"))
            case _:
                raise ValueError(f"{' '.join(words)[:40]!r} is not understood")
    if points is None:
        raise ValueError("it has no POINTS")
    return _raw_mesh(points, types, ends, nodes)


# ------------------------------------------------------------------------------------------ XML


def read_xml(file: Path) -> RawMesh:
    """Return the mesh in an XML file of an unstructured grid, all of its pieces.

    Raises
    ------
    ValueError
        If the file is damaged, of another kind of data set, or has ghost cells.
    """
    content = file.read_bytes()
    appended = re.search(rb"<AppendedData([^>]*)>\s*_", content)
    text = content if appended is None else content[: appended.start()] + b"</VTKFile>"
    if b"<!" in re.sub(rb"<!--.*?-->", b"", text, flags=re.DOTALL):
        raise ValueError("declarations of XML are not read")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"XML: {error}") from None
    if root.get("type") != "UnstructuredGrid":
        raise ValueError(f"the data set is {root.get('type')}; {_SAVE}")
    tail = b"" if appended is None else content[appended.end() : content.rfind(b"</AppendedData")]
    arrays = _Arrays(root, tail, raw=appended is not None and b"base64" not in appended[1])
    meshes = [_piece(piece, arrays) for piece in root.findall("UnstructuredGrid/Piece")]
    if not meshes:
        raise ValueError("it has no piece of an unstructured grid")
    if len(meshes) == 1:
        return meshes[0]
    blocks = [
        RawBlock(block.kind, block.cells + shift)
        for mesh, shift in zip(meshes, firsts(mesh.nodes for mesh in meshes), strict=False)
        for block in mesh.blocks
    ]
    return RawMesh(np.concatenate([mesh.nodes for mesh in meshes]), tuple(blocks))


def _piece(piece: ElementTree.Element, arrays: _Arrays) -> RawMesh:
    for array in piece.findall("CellData/DataArray"):
        if array.get("Name") in ("vtkGhostType", "vtkGhostLevels") and arrays.of(array).any():
            raise ValueError("it has ghost cells of another part; save the whole mesh in one file")
    places = piece.find("Points/DataArray")
    cells = {array.get("Name"): array for array in piece.findall("Cells/DataArray")}
    if places is None or not {"connectivity", "offsets", "types"} <= set(cells):
        raise ValueError("points, connectivity, offsets or types are missing")
    points = arrays.of(places).astype(np.float64)
    n_points = int(piece.get("NumberOfPoints", ""))
    if len(points) != 3 * n_points:
        raise ValueError(f"{n_points} points are announced, but {len(points)} coordinates")
    nodes, ends, types = (
        integers(arrays.of(cells[name])) for name in ("connectivity", "offsets", "types")
    )
    check_count("cells", int(piece.get("NumberOfCells", "")), len(types))
    return _raw_mesh(points.reshape(-1, 3), types, ends, nodes)


class _Arrays:
    """The arrays of a file, as text, in base64 or appended, compressed or not."""

    def __init__(self, root: ElementTree.Element, appended: bytes, *, raw: bool) -> None:
        self.order = ">" if root.get("byte_order") == "BigEndian" else "<"
        self.header = self.type(root.get("header_type", "UInt32"))
        self.appended, self.raw = appended, raw
        compressor = root.get("compressor", "")
        if compressor not in _COMPRESSORS:
            raise ValueError(f"{compressor} is not read; save it with zlib")
        self.decompress = _COMPRESSORS[compressor]

    def type(self, name: str) -> np.dtype[Any]:
        if not _XML_TYPES.fullmatch(name):
            raise ValueError(f"data of type {name!r} are not read")
        return np.dtype(self.order + np.dtype(name.lower()).str[1:])

    def of(self, array: ElementTree.Element) -> Any:
        dtype = self.type(array.get("type", ""))
        text = (array.text or "").encode("latin-1", "replace")
        match array.get("format", "ascii"):
            case "ascii":
                return numbers_of(text)
            case "binary":
                content = _base64(text)
            case "appended":
                tail = self.appended[int(array.get("offset", "0")) :]
                content = tail if self.raw else _base64(tail)
            case other:
                raise ValueError(f"data of format {other!r} are not read")
        size = self.header.itemsize
        count = int(_from_bytes(content, self.header, 1)[0])  # of bytes, or of blocks
        if self.decompress is None:
            return _from_bytes(content[size:], dtype, count // dtype.itemsize)
        sizes = _from_bytes(content, self.header, 3 + count)[3:]
        ends = (3 + count) * size + np.cumsum(sizes, dtype=np.int64)
        parts = [content[end - int(n) : end] for end, n in zip(ends, sizes, strict=True)]
        try:
            whole = b"".join(map(self.decompress, parts))
        except (zlib.error, lzma.LZMAError) as error:
            raise ValueError(f"its compressed data are damaged: {error}") from None
        return _from_bytes(whole, dtype, len(whole) // dtype.itemsize)


def _base64(text: bytes) -> bytes:
    """Return the bytes of a text in base64; the header and the data may each end with "="."""
    try:
        parts = re.findall(rb"[A-Za-z0-9+/]+=*", b"".join(text.split()))
        return b"".join(base64.b64decode(part) for part in parts)
    except binascii.Error as error:
        raise ValueError(f"its data in base64 are damaged: {error}") from None
