"""Files of VTK, Exodus, MED and of meshio: meshes and groups whole, or refused by name."""

from __future__ import annotations

import base64
import contextlib
import io
import struct
import zlib
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import scipy.io
from bodies import mixed_box, no_solid
from rows import each
from test_gmsh import DAMAGED, TWO

import aoimpact as ao
from aoimpact import MeshError
from aoimpact.fem import stiffness_mass
from aoimpact.mesh import KINDS, meshio_of_all_kinds, reference_element

LENGTHS = (2.0, 1.5, 1.0)


def boxes() -> list[ao.Mesh]:
    mixed = [mixed_box(LENGTHS, (2, 2, 3), order=order) for order in (1, 2)]
    return [ao.box_mesh(LENGTHS, (2, 1, 1), kind=kind) for kind in KINDS] + mixed


def write(mesh: ao.Mesh, file: Path, name: str, **how: Any) -> None:
    blocks = [(block.kind, np.array(block.cells)) for block in mesh.blocks]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        meshio_of_all_kinds().Mesh(np.array(mesh.nodes), blocks).write(
            file, file_format=name, **how
        )


def assert_same(found: ao.Mesh, wanted: ao.Mesh) -> None:
    assert found.nodes == pytest.approx(wanted.nodes, abs=1e-15)
    cells = {block.kind: block.cells for block in wanted.blocks}
    assert {block.kind for block in found.blocks} == set(cells)
    for block in found.blocks:
        assert np.array_equal(block.cells, cells[block.kind])


# ------------------------------------------------------------------------------------------ VTK


@each(
    "name, end, how",
    [
        ("vtk42", ".vtk", {"binary": False}),
        ("vtk42", ".vtk", {"binary": True}),
        ("vtk51", ".vtk", {"binary": False}),
        ("vtk51", ".vtk", {"binary": True}),
        ("vtu", ".vtu", {"binary": True}),
        ("vtu", ".vtu", {"binary": True, "compression": "lzma"}),
        ("vtu", ".vtu", {"binary": True, "compression": None}),
    ],
)
def test_grids_of_vtk_as_meshio_writes_them(
    tmp_path: Path, name: str, end: str, how: dict[str, Any]
) -> None:
    for mesh in boxes():
        write(mesh, tmp_path / f"a{end}", name, **how)
        assert_same(ao.read_mesh(tmp_path / f"a{end}"), mesh)


HEADER = "# vtk DataFile Version 3.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\n"
BRICK = (
    "POINTS 8 float\n0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1\n"
    "CELLS 2 12\n8 0 1 2 3 4 5 6 7\n2 0 1\nCELL_TYPES 2\n12\n3\n"
)


LEGACY = [
    ("# vtk", "# ptk"),
    ("ASCII", "OTHER"),
    ("UNSTRUCTURED_GRID", "STRUCTURED_POINTS"),
    ("POINTS 8", "POINTS 9"),
    ("0 0 0  1", "0 zero 0  1"),
    ("CELLS 2 12", "CELLS 2 13"),
    ("2 12\n8", "3 12\nOFFSETS\n8"),
    ("8 0 1", "7 0 1"),
    ("\n12\n3", "\n42\n3"),
    ("\n12\n3", "\n10\n3"),
    ("\n12\n3", "\n14\n3"),
    ("\n12\n3", "\n12\n3\n3"),
    ("6 7\n", "6 8\n"),
    ("CELL_TYPES 2", "TYPES 2"),
]


def pieces(arrays: list[dict[str, str]], more: str = "") -> str:
    """An XML file of pieces, each with the text of its four arrays."""
    array = '<DataArray type="{}" Name="{}" {}>{}</DataArray>'
    body = ""
    for of in arrays:
        how = of.get("how", 'format="ascii"')
        named = {
            name: array.format(type_, name, how, of[name])
            for name, type_ in (
                ("points", "Float64"),
                ("connectivity", "Int64"),
                ("offsets", "Int64"),
                ("types", "UInt8"),
            )
        }
        body += (
            f'<Piece NumberOfPoints="{of["n_points"]}" NumberOfCells="{of["n_cells"]}">'
            f"<Points>{named.pop('points')}</Points><Cells>{''.join(named.values())}</Cells>"
            f"{of.get('more', '')}</Piece>"
        )
    return (
        f'<VTKFile type="UnstructuredGrid" byte_order="LittleEndian"{more}><UnstructuredGrid>{body}'
        "</UnstructuredGrid></VTKFile>"
    )


TETRAHEDRON = {
    "n_points": "4",
    "n_cells": "1",
    "points": "0 0 0 1 0 0 0 1 0 0 0 1",
    "connectivity": "0 1 2 3",
    "offsets": "4",
    "types": "10",
}


def test_all_pieces_of_a_file_are_read(tmp_path: Path) -> None:
    beside = TETRAHEDRON | {"points": "2 0 0 3 0 0 2 1 0 2 0 1"}
    (tmp_path / "a.vtu").write_text(pieces([TETRAHEDRON, beside]))
    mesh = ao.read_mesh(tmp_path / "a.vtu")
    assert mesh.cells.tolist() == [[0, 1, 2, 3], [4, 5, 6, 7]]


def block(values: np.ndarray, compressed: bool) -> bytes:
    content = values.tobytes()
    if not compressed:
        return struct.pack("<I", len(content)) + content
    packed = zlib.compress(content)
    return struct.pack("<4I", 1, len(content), len(content), len(packed)) + packed


@each("compressed", [False, True])
@each("encoding", ["raw", "base64"])
def test_appended_data_as_paraview_writes_them(
    tmp_path: Path, encoding: str, compressed: bool
) -> None:
    types = {"points": "f8", "connectivity": "i8", "offsets": "i8", "types": "u1"}
    offsets, tail = {}, b""
    for name, dtype in types.items():
        offsets[name] = len(tail)
        part = block(np.array(TETRAHEDRON[name].split(), dtype=float).astype(dtype), compressed)
        if encoding == "base64" and compressed:  # the header is encoded by itself
            part = base64.b64encode(part[:16]) + base64.b64encode(part[16:])
        tail += base64.b64encode(part) if encoding == "base64" and not compressed else part
    text = pieces([TETRAHEDRON], ' compressor="vtkZLibDataCompressor"' if compressed else "")
    for name in types:
        old = f'Name="{name}" format="ascii">{TETRAHEDRON[name]}<'
        assert old in text
        text = text.replace(old, f'Name="{name}" format="appended" offset="{offsets[name]}"><')
    head, end = text.encode().split(b"</VTKFile>")
    appended = f'<AppendedData encoding="{encoding}">_'.encode()
    (tmp_path / "a.vtu").write_bytes(head + appended + tail + b"</AppendedData></VTKFile>" + end)
    mesh = ao.read_mesh(tmp_path / "a.vtu")
    assert mesh.nodes.reshape(-1).tolist() == [float(x) for x in TETRAHEDRON["points"].split()]
    assert mesh.cells.tolist() == [[0, 1, 2, 3]]


GHOST = '<CellData><DataArray type="UInt8" Name="vtkGhostType">1</DataArray></CellData>'


PIECES = [
    {"n_points": "5"},
    {"n_cells": "2"},
    {"offsets": "5"},
    {"connectivity": "0 1 2 9"},
    {"connectivity": "0 1 2 2.5"},
    {"points": "0 0 0 1 0 0 0 1 0 0 0 x"},
    {"more": GHOST},
    {"how": 'format="appended" offset="0"'},
]
ENDLESS = "TIN (((" + 40 * "0.0 0.0 0.0, " + "x"  # takes minutes in a pattern
GRIDS = [
    "<VTKFile",
    "<VTKFile/>",
    '<!DOCTYPE a [<!ENTITY b "c">]><VTKFile/>',
    '<VTKFile type="PolyData"/>',
    '<VTKFile type="UnstructuredGrid"/>',
    pieces([TETRAHEDRON], ' compressor="vtkLZ4DataCompressor"'),
    *(pieces([TETRAHEDRON | changed]) for changed in PIECES),
]


@each(
    "name, text",
    [
        *(("a.vtk", (HEADER + BRICK).replace(*change, 1)) for change in LEGACY),
        *(("a.vtu", text) for text in GRIDS),
        *(("a.msh", TWO.replace(*change, 1)) for change in DAMAGED),
        *(("a.msh", text) for text in ("", "$MeshFormat\n4.1 0 8\n", "nonsense\n")),
        *((f"a.{end}", ENDLESS) for end in ("stl", "wkt", "tec", "f3grid", "vol", "mdpa", "xyz")),
        ("noextension", ENDLESS),
        ("a.ugrid", "1 2 3\n"),
        ("job.dat", "1\n   Abaqus 2023   Date 26-Nov   Time 200000000014764\n"),  # a listing
    ],
)
def test_damaged_files_and_other_formats_are_refused(
    tmp_path: Path, name: str, text: str, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(MeshError, match=rf"^mesh file .*{name}"):
        ao.read_mesh(tmp_path / name)
    assert capfd.readouterr() == ("", "")  # also of what meshio prints


# --------------------------------------------------------------------------------------- Exodus

# Sides 1 … of a brick, Exodus' numbers, by the plane that each lies in: axis and end.
BRICK_SIDES = [(1, 0), (0, 1), (1, 1), (0, 0), (2, 0), (2, 1)]


def exodus(file: Path, box: ao.Mesh, types: list[str], **more: Any) -> None:
    """Write classic Exodus with one block of elements for each of some types."""
    order = {20: [*range(12), *range(16, 20), *range(12, 16)]}.get(box.cells.shape[1], slice(None))
    with scipy.io.netcdf_file(file, "w") as nc:

        def put(name: str, values: Any, **attributes: str) -> None:
            array = np.asarray(values)
            dims = [f"{name}_{i}" for i in range(array.ndim)]
            for dim, length in zip(dims, array.shape, strict=True):
                nc.createDimension(dim, length)
            variable = nc.createVariable(name, array.dtype, dims)
            variable[:] = array
            for key, value in attributes.items():
                setattr(variable, key, value)

        def names(*words: str) -> np.ndarray:
            return np.array([list(word.ljust(33, "\0")) for word in words], dtype="S1")

        for axis, values in zip("xyz", box.nodes.T, strict=True):
            put(f"coord{axis}", values)
        put("eb_prop1", np.arange(10, 10 + len(types), dtype="i4"))
        put("eb_names", names("left", *[""] * (len(types) - 1)))
        for i, (type_, cells) in enumerate(
            zip(types, np.array_split(np.asarray(box.cells), len(types)), strict=True), 1
        ):
            put(f"connect{i}", (cells[:, order] + 1).astype("i4"), elem_type=type_)
        put("node_num_map", np.arange(100, 100 + box.n_nodes, dtype="i4"))
        put("elem_num_map", np.arange(7, 7 + box.n_cells, dtype="i4"))
        put("ns_prop1", np.array([3], "i4"))
        put("node_ns1", np.array([1, 2], "i4"))
        put("ss_prop1", np.arange(1, 7, dtype="i4"))
        put("ss_names", names(*(f"side {i}" for i in range(1, 7))))
        for i in range(1, 7):
            put(f"elem_ss{i}", np.array([1], "i4"))
            put(f"side_ss{i}", np.array([more.get("side", i)], "i4"))


@each("kind, types", [("hexahedron", ["HEX", "HEX8"]), ("hexahedron20", ["HEX20", "hex"])])
def test_blocks_and_sets_of_exodus(tmp_path: Path, kind: str, types: list[str]) -> None:
    box = ao.box_mesh(LENGTHS, (2, 1, 1), kind=kind)
    exodus(tmp_path / "a.exo", box, types)
    mesh = ao.read_mesh(tmp_path / "a.exo")
    assert_same(mesh, box)
    assert {name: ids.tolist() for name, ids in mesh.cell_sets.items()} == {
        "left": [0],
        "block 11": [1],
    }
    assert mesh.node_sets["nodeset 3"].tolist() == [0, 1]
    assert np.array_equal(mesh.node_labels, np.arange(100, 100 + box.n_nodes))
    assert np.array_equal(mesh.cell_labels, [7, 8])
    first = box.nodes[box.cells[0]]
    for i, (axis, end) in enumerate(BRICK_SIDES, 1):
        plane = first[:, axis].max() if end else first[:, axis].min()
        on = np.sort(box.cells[0][first[:, axis] == plane])
        assert np.array_equal(mesh.node_sets[f"side {i}"], on)


@each(
    "kind, type_",
    [("tetra", "TETRA4"), ("tetra", "TET"), ("wedge", "WEDGE6"), ("pyramid", "PYRAMID5")],
)
def test_names_of_elements_of_exodus(tmp_path: Path, kind: str, type_: str) -> None:
    """Sides of all kinds lie on planes through the corners of the element."""
    box = ao.box_mesh(LENGTHS, (1, 1, 1), kind=kind)
    sides = len(reference_element(kind).cell.normals)
    exodus(tmp_path / "a.e", box, [type_], side=sides)
    mesh = ao.read_mesh(tmp_path / "a.e")
    assert_same(mesh, box)
    assert len(mesh.node_sets["side 1"]) in (3, 4)


@each("type_, side", [("NSIDED", 1), ("HEX", 7)])
def test_what_exodus_readers_do_not_know(tmp_path: Path, type_: str, side: int) -> None:
    exodus(tmp_path / "a.exo", ao.box_mesh(LENGTHS, (1, 1, 1)), [type_], side=side)
    with pytest.raises(MeshError, match=r"^mesh"):
        ao.read_mesh(tmp_path / "a.exo")


# ------------------------------------------------------------------------------------------ MED


def test_groups_and_numbers_of_med(gmsh: Any, tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    gmsh.model.addPhysicalGroup(3, [1, 2], 20, "body")
    gmsh.model.addPhysicalGroup(3, [2], 21, "two")
    gmsh.model.addPhysicalGroup(2, [1], 10, "base")
    for order, kind in ((1, "tetra"), (2, "tetra10")):
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(tmp_path / "a.med"))
        mesh = ao.read_mesh(tmp_path / "a.med")
        assert mesh.kind == kind
        assert set(mesh.cell_sets) == {"body", "two"}
        assert stiffness_mass(mesh.part("two"), no_solid())[1].sum() == pytest.approx(3.0)
        wanted = gmsh.model.mesh.getNodes(2, 1, includeBoundary=True)[0]
        assert len(mesh.node_sets["base"]) == len(np.unique(wanted))
        assert mesh.node_labels is not None


@each(
    "change, words",
    [
        (lambda f: f.__delitem__("ENS_MAA"), r"no mesh \(ENS_MAA\)"),
        (lambda f: f["ENS_MAA"].copy("mesh", "other"), "2 meshes"),
        (lambda f: f["ENS_MAA/mesh"].attrs.__setitem__("TYP", 1), "structured"),
    ],
)
def test_med_files_that_hold_something_else(tmp_path: Path, change: Any, words: str) -> None:
    h5py = pytest.importorskip("h5py")
    write(ao.box_mesh(LENGTHS, (1, 1, 1)), tmp_path / "a.med", "med")
    with h5py.File(tmp_path / "a.med", "r+") as tree:
        change(tree)
    with pytest.raises(MeshError, match=words):
        ao.read_mesh(tmp_path / "a.med")


def test_an_array_beyond_the_file_is_refused_before_it_is_read(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.med", "w") as tree:
        tree.create_dataset("ENS_MAA/mesh/NOE/COO", (10**10,), "f8", chunks=(10**6,))
    with pytest.raises(MeshError, match="bytes"):
        ao.read_mesh(tmp_path / "a.med")


# ---------------------------------------------------------------------------------------- meshio


@each("name, end", [("su2", ".su2"), ("medit", ".mesh"), ("avsucd", ".avs")])
def test_meshes_that_meshio_reads_are_counted(tmp_path: Path, name: str, end: str) -> None:
    box = ao.box_mesh(LENGTHS, (2, 1, 1))
    write(box, tmp_path / f"a{end}", name)
    assert_same(ao.read_mesh(tmp_path / f"a{end}"), box)
    text = (tmp_path / f"a{end}").read_text()
    count = {"avsucd": "12 2 ", "su2": "NELEM= 2"}.get(name, "\n2\n")
    assert count in text
    (tmp_path / f"a{end}").write_text(text.replace(count, count.replace("2", "3"), 1))
    with pytest.raises(MeshError, match=f"a{end}"):
        ao.read_mesh(tmp_path / f"a{end}")


def test_tags_of_meshio_are_groups(tmp_path: Path) -> None:
    box = ao.box_mesh(LENGTHS, (2, 1, 1))
    tags = {"medit:ref": [np.array([4, 7])]}
    mesh = meshio.Mesh(np.array(box.nodes), [("hexahedron", np.array(box.cells))], cell_data=tags)
    mesh.write(tmp_path / "a.mesh")
    groups = ao.read_mesh(tmp_path / "a.mesh").cell_sets
    assert {name: own.tolist() for name, own in groups.items()} == {"ref 4": [0], "ref 7": [1]}


def test_markers_of_su2_are_groups(tmp_path: Path) -> None:
    write(ao.box_mesh(LENGTHS, (2, 1, 1)), tmp_path / "a.su2", "su2")
    side = "MARKER_TAG= {}\nMARKER_ELEMS= 1\n9 {}\n".format
    with (tmp_path / "a.su2").open("a") as file:
        file.write(f"NMARK= 2\n{side('low', '0 1 2 3')}{side('end', '4 5 6 7')}")
    groups = ao.read_mesh(tmp_path / "a.su2").node_sets
    assert [groups[name].tolist() for name in ("low", "end")] == [[0, 1, 2, 3], [4, 5, 6, 7]]
