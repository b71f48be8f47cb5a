"""Reader of VTK's XML files of unstructured grids (.vtu), with compressed or appended data.

The format is that of "VTK File Formats" (docs.vtk.org). It has no groups, and nodes and elements
have no numbers of their own. All pieces of a file are joined into one mesh.
"""

from __future__ import annotations

import base64
import lzma
import re
import zlib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt

from .raw import RawBlock, RawMesh, check_count, firsts, integers, nodes_in, numbers_of

# meshio's kinds of cells by VTK's type numbers.
_LINEAR = "vertex line triangle quad quad tetra hexahedron hexahedron wedge pyramid"
_QUADRATIC = "line3 triangle6 quad8 tetra10 hexahedron20 wedge15 pyramid13 quad9 hexahedron27"
_KINDS = {
    **dict(zip((1, 3, 5, 8, 9, 10, 11, 12, 13, 14), _LINEAR.split(), strict=True)),
    **dict(enumerate(_QUADRATIC.split(), start=21)),
}

# VTK's types of points, lines and surfaces beyond `_KINDS`, which are left out.
_WITHOUT_VOLUME = (0, 2, 4, 6, 7, 30, 34, 35, 36, 51, 60, 61, 62, 68, 69, 70, 75, 76, 77)

# For each node of a quadrilateral or hexahedron, its number in VTK's pixel or voxel, where nodes
# are numbered along x, y and z.
_ORDERS = {8: (0, 1, 3, 2), 11: (0, 1, 3, 2, 4, 5, 7, 6)}

# Pattern of VTK's data types, which are NumPy's with a capital letter.
_TYPES = re.compile("U?Int(8|16|32|64)|Float(32|64)")

_COMPRESSORS: dict[str, Any] = {
    "": None,
    "vtkZLibDataCompressor": zlib.decompress,
    "vtkLZMADataCompressor": lzma.decompress,
}


def _from_bytes(content: bytes, dtype: np.dtype[Any], count: int) -> npt.NDArray[Any]:
    if not 0 <= count <= len(content) // dtype.itemsize:
        raise ValueError(f"{count} numbers are announced, but fewer are there")
    return np.frombuffer(content, dtype, count)


def read(file: Path) -> RawMesh:
    """Return the mesh in an XML file of an unstructured grid, with all pieces joined.

    Raises
    ------
    ValueError
        If the file is damaged, holds another kind of data set, or has ghost cells.
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
        raise ValueError(f"the data set is {root.get('type')}; save an unstructured grid")
    tail = b"" if appended is None else content[appended.end() : content.rfind(b"</AppendedData")]
    arrays = _Arrays(root, tail, raw=appended is not None and b"base64" not in appended[1])
    meshes = [_piece(piece, arrays) for piece in root.findall("UnstructuredGrid/Piece")]
    if not meshes:
        raise ValueError("it has no piece of an unstructured grid")
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
        raise ValueError(f"{n_points} points must have x, y and z, got {len(points)} numbers")
    points = points.reshape(-1, 3)
    nodes, ends, types = (
        integers(arrays.of(cells[name])) for name in ("connectivity", "offsets", "types")
    )
    check_count("cells", int(piece.get("NumberOfCells", "")), len(types))
    starts = np.concatenate([[0], ends])[:-1]
    counts = ends - starts
    if len(types) != len(ends) or counts.sum() != len(nodes) or (counts < 0).any():
        raise ValueError("the numbers of cells, types and nodes must fit each other")
    blocks = []
    for type_ in np.setdiff1d(types, _WITHOUT_VOLUME).tolist():
        of = np.flatnonzero(types == type_)
        if type_ not in _KINDS:
            blocks.append(RawBlock(f"VTK type {type_}", np.zeros((len(of), 1), np.int64)))
            continue
        kind, width = _KINDS[type_], nodes_in(_KINDS[type_])
        if wrong := set(counts[of].tolist()) - {width}:
            raise ValueError(f"a {kind} must have {width} nodes, got {wrong.pop()}")
        table = nodes[starts[of][:, None] + np.arange(width)][:, _ORDERS.get(type_, slice(None))]
        blocks.append(RawBlock(kind, table))
    return RawMesh(points, tuple(blocks))


class _Arrays:
    """Decodes a file's data arrays, which are text, base64 or appended, and may be compressed."""

    def __init__(self, root: ElementTree.Element, appended: bytes, *, raw: bool) -> None:
        self.order = ">" if root.get("byte_order") == "BigEndian" else "<"
        self.header = self.type(root.get("header_type", "UInt32"))
        self.appended, self.raw = appended, raw
        compressor = root.get("compressor", "")
        if compressor not in _COMPRESSORS:
            raise ValueError(f"{compressor} is not read; save it with zlib")
        self.decompress = _COMPRESSORS[compressor]

    def type(self, name: str) -> np.dtype[Any]:
        if not _TYPES.fullmatch(name):
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
        count = int(_from_bytes(content, self.header, 1)[0])  # bytes, or compressed blocks
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
    """Decode base64 text, in which header and data may each be padded with "="."""
    parts = re.findall(rb"[A-Za-z0-9+/]+=*", b"".join(text.split()))
    return b"".join(map(base64.b64decode, parts))
