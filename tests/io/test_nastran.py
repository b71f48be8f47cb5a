"""Nastran decks: each way to write a mesh gives that mesh; unknown lines are refused."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import numpy.typing as npt
import pytest
from bodies import no_solid
from rows import each

import aoimpact as ao

FloatArray = npt.NDArray[np.float64]

# Two bricks of 1 × 1 × 1 in a row along x; nodes 1 to 12.
NODES = {1 + i + 3 * j + 6 * k: (i, j, k) for k in (0, 1) for j in (0, 1) for i in range(3)}
CELLS = {1: [1, 2, 5, 4, 7, 8, 11, 10], 2: [2, 3, 6, 5, 8, 9, 12, 11]}


def small(*fields: object) -> str:
    """A line of small fields."""
    return "".join(f"{field:<8}" for field in fields) + "\n"


def grids(write: Callable[[float], str] = "{}.".format) -> str:
    return "".join(
        small("GRID", label, "", *map(write, place)).rstrip() + "\n"
        for label, place in NODES.items()
    )


def brick(label: int, of: int | None = None, marks: tuple[str, str] = ("+", "+")) -> str:
    first, last = CELLS[label][:6], CELLS[label][6:]
    of = label if of is None else of
    return small("CHEXA", label, of, *first, marks[0]) + small(marks[1], *last)


def large(label: int, of: int) -> str:
    nodes = [f"{node:<16}" for node in CELLS[label]]
    lines = [f"CHEXA*  {label:<16}{of:<16}{nodes[0]}{nodes[1]}*", "*       " + "".join(nodes[2:6])]
    return "\n".join([*lines, "*       " + "".join(nodes[6:]), ""])


def free(label: int, of: int) -> str:
    nodes = [str(node) for node in CELLS[label]]
    return f"CHEXA,{label},{of},{','.join(nodes[:6])}\n,{','.join(nodes[6:])}\n"


PLAIN = "BEGIN BULK\n" + grids() + brick(1) + brick(2) + "ENDDATA\n"
HEAD = "SOL 101\nCEND\nTITLE = two bricks, BEGIN to end\n"


def read(folder: Path, text: str, name: str = "deck.bdf", encoding: str = "latin-1") -> ao.Mesh:
    (folder / name).write_bytes(text.encode(encoding))
    return ao.read_mesh(folder / name)


def volume(mesh: ao.Mesh) -> float:
    """The volume, as mass of a body of density 1; in decimetres, not to be larger than bodies."""
    return float(ao.FEModel.from_mesh(ao.read_mesh(mesh, scale=0.1), no_solid()).M.sum() / 3) * 1e3


def assert_two_bricks(mesh: ao.Mesh) -> None:
    assert mesh.node_labels is not None
    assert mesh.cell_labels is not None
    for label, place in zip(mesh.node_labels, mesh.nodes, strict=True):
        np.testing.assert_allclose(place, NODES[int(label)], atol=1e-14)
    for label, cell in zip(mesh.cell_labels, mesh.cells, strict=True):
        assert mesh.node_labels[cell].tolist() == CELLS[int(label)]
    assert sorted(mesh.cell_labels) == [1, 2]


DECKS = {
    "plain": PLAIN,
    "case control": HEAD + PLAIN,
    "large fields": "BEGIN BULK\n" + grids() + large(1, 1) + large(2, 2),
    "small and large": "BEGIN BULK\n" + grids() + brick(1) + large(2, 2),
    "free fields": "BEGIN BULK\n" + grids() + free(1, 1) + free(2, 2),
    "free, large and blank nodes": "BEGIN BULK\n"
    + "".join(f"GRID*,{n},,{x}.,{y}.,+\n*,{z}.,\n" for n, (x, y, z) in NODES.items())
    + large(1, 1)
    + free(2, 2),
    "blank for zero": PLAIN.replace("0.      ", "        "),
    "no BEGIN BULK": "$ a writer\n" + grids() + brick(1) + brick(2) + "ENDDATA\n",
    "no ENDDATA": "BEGIN BULK\n" + grids() + brick(1) + brick(2),
    "nonsense after ENDDATA": PLAIN + "CHEXA,9,9\nFOO\n",
    "continuation without mark": PLAIN.replace("\n+ ", "\n  ").replace("+\n", "\n"),
    "marks with names": grids() + brick(1, None, ("+A1", "+A1")) + brick(2, None, ("*B", "+B")),
    "lower case": PLAIN.lower(),
    "1.D0": PLAIN.replace("1.      ", "1.D0    "),
    "1.+0": PLAIN.replace("1.      ", "1.+0    ").replace("2.      ", "20.-1   "),
    "all fields in one line": "BEGIN BULK\n"
    + grids()
    + "".join(free(label, label).replace("\n", "", 1) for label in CELLS),
    "comments": PLAIN.replace("GRID    7", "$ GRID\n\n  $ more\nGRID    7").replace(
        "+\n", "+\n$ in\n"
    ),
    "comments at ends": re.sub("(GRID.*)\n", r"\1 $ a, node\n", PLAIN),
    "elements first": "BEGIN BULK\n" + brick(2) + brick(1) + grids(),
    "other entries": PLAIN.replace(
        "ENDDATA",
        "MAT1,1,2.1E11,,.3,7800.\nPSOLID,1,1\nSPC1,1,123,1,THRU,4\nPARAM,POST,-1\nENDDATA",
    ),
    "windows": PLAIN.replace("\n", "\r\n"),
    "tabs": re.sub("(.{8})", lambda one: one[0].rstrip() + "\t", grids() + brick(1) + brick(2)),
    "node twice": PLAIN.replace("ENDDATA", small("GRID", 3, "", "2.", "0.", "0.") + "ENDDATA"),
}


def shuffled() -> str:
    """Continuations before and far from the lines that they continue."""
    lines = [line for label in CELLS for line in brick(label, None, ("+", "+")).splitlines()]
    first, second, third, fourth = lines
    return "\n".join(
        [f"{first[:72]}+A", f"+B{fourth[2:]}", grids(), f"{third[:72]}+B", f"+A{second[2:]}", ""]
    )


DECKS["continuations in any order"] = shuffled()


@each("text", DECKS.values())
def test_a_mesh_may_be_written_in_many_ways(text: str, tmp_path: Path) -> None:
    mesh = read(tmp_path, text)
    assert_two_bricks(mesh)
    assert {name: len(cells) for name, cells in mesh.cell_sets.items()} == {
        "property 1": 1,
        "property 2": 1,
    }


@each("encoding", ["latin-1", "utf-8-sig", "utf-16"])
@each("name", ["deck.nas", "deck.inp", "deck.dat", "deck.fem", "deck.blk", "DECK.BDF"])
def test_a_deck_is_known_by_its_content(name: str, encoding: str, tmp_path: Path) -> None:
    assert_two_bricks(read(tmp_path, "$ Größe in Metern\n" + PLAIN, name, encoding))


@each(
    "written, value",
    [
        ("1.5", 1.5),
        (".5", 0.5),
        ("-3", -3.0),
        ("1.5+1", 15.0),
        ("-1.5-3", -0.0015),
        ("1.5E-3", 0.0015),
        ("15.D-1", 1.5),
        ("+2.d-1", 0.2),
        ("", 0.0),
        ("-1.0927391975-14", -1.0927391975e-14),
        ("1.23456789012345", 1.23456789012345),
        ("1.2345678901234567890", 1.2345678901234567890),
    ],
)
def test_numbers_as_nastran_writes_them(written: str, value: float, tmp_path: Path) -> None:
    deck = "GRID,1\nGRID,2,,1.\nGRID,3,,,1.\nCTETRA,1,1,1,2,3,4\n"
    forms = [f"GRID,4,,{written},,1.\n"]
    if len(written) <= 16:
        forms.append(f"GRID*   {4:<16}{'':16}{written:<16}{'':16}*\n*       {'1.':<16}\n")
    if len(written) <= 8:
        forms.append(small("GRID", 4, "", written, "", "1."))
    for form in forms:
        assert read(tmp_path, deck + form).nodes[3].tolist() == [value, 0.0, 1.0]


def test_included_files(tmp_path: Path) -> None:
    """In quotes or not, over several lines, within each other, from where they themselves are.

    One that is missing before CEND holds no mesh.
    """
    lines = grids().splitlines(keepends=True)
    (tmp_path / "parts" / "more").mkdir(parents=True)
    (tmp_path / "parts" / "grids.inc").write_text("include 'more/first.inc'\n" + "".join(lines[5:]))
    (tmp_path / "parts" / "more" / "first.inc").write_text("".join(lines[:5]))
    (tmp_path / "parts" / "cells.inc").write_text(brick(1) + "$ INCLUDE 'none'\n")
    deck = (
        "INCLUDE 'dmap'\n"
        + HEAD
        + "BEGIN BULK\nINCLUDE 'parts/\n  grids.inc'\nINCLUDE parts\\cells.inc $ bricks\n"
    )
    assert_two_bricks(read(tmp_path, deck + brick(2) + "ENDDATA\n"))


# ------------------------------------------------------------------------- coordinate systems

# An origin, and axes turned by 30° about z.
ORIGIN = np.array([0.3, -2.0, 0.7])
C, S = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
TURN = np.array([[C, S, 0.0], [-S, C, 0.0], [0.0, 0.0, 1.0]])


def rectangular(x: FloatArray) -> FloatArray:
    return x


def cylindrical(x: FloatArray) -> FloatArray:
    return np.array([np.hypot(x[0], x[1]), np.degrees(np.arctan2(x[1], x[0])), x[2]])


def spherical(x: FloatArray) -> FloatArray:
    r = float(np.linalg.norm(x))
    theta = np.degrees(np.arccos(x[2] / r)) if r else 0.0
    return np.array([r, theta, np.degrees(np.arctan2(x[1], x[0]))])


def in_system(local: Callable[[FloatArray], FloatArray], system: int | str) -> str:
    """The nodes, given in the coordinates of a system at `ORIGIN` with axes `TURN`."""
    lines = []
    for label, place in NODES.items():
        x = local(TURN @ (np.array(place) - ORIGIN))
        lines.append(f"GRID,{label},{system},{','.join(repr(float(c)) for c in x)}\n")
    return "".join(lines)


def points(axes: FloatArray, origin: FloatArray) -> str:
    """Three points that define axes: the origin, one on z, one in the plane of x and z."""
    numbers = np.concatenate([origin, origin + 2 * axes[2], origin + 3 * axes[0] - axes[2]])
    text = [repr(float(number)) for number in numbers]
    return ",".join(text[:6]) + "\n," + ",".join(text[6:])


SYSTEMS = [("R", rectangular), ("C", cylindrical), ("S", spherical)]


@each("kind, local", SYSTEMS)
def test_coordinates_in_systems_of_points(
    kind: str, local: Callable[[FloatArray], FloatArray], tmp_path: Path
) -> None:
    system = f"CORD2{kind},5,,{points(TURN, ORIGIN)}\n"
    cells = brick(1) + brick(2)
    assert_two_bricks(read(tmp_path, in_system(local, 5) + system + cells))
    assert_two_bricks(read(tmp_path, "GRDSET,,5\n" + in_system(local, "") + system + cells))


@each("kind, local", SYSTEMS)
@each("second", [False, True])
def test_coordinates_in_systems_of_nodes(
    second: bool, kind: str, local: Callable[[FloatArray], FloatArray], tmp_path: Path
) -> None:
    """By three nodes, which may be in systems themselves; an entry may define two systems."""
    places = [ORIGIN, ORIGIN + 2 * TURN[2], ORIGIN + 3 * TURN[0] - TURN[2]]
    nodes = "".join(
        f"GRID,{101 + i},0,{','.join(repr(float(c)) for c in x)}\n" for i, x in enumerate(places)
    )
    system = f"CORD1{kind},{'4,103,101,102,' if second else ''}5,101,102,103\n"
    with pytest.warns(ao.AOImpactWarning, match="nodes"):
        mesh = read(tmp_path, in_system(local, 5) + nodes + system + brick(1) + brick(2))
    assert_two_bricks(mesh)


def test_systems_that_refer_to_each_other(tmp_path: Path) -> None:
    """A rectangular system in a cylindrical one, in whose coordinates its points are given."""
    outer = np.array([5.0, 1.0, 0.0])
    axes = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    inner = [ORIGIN, ORIGIN + 2 * TURN[2], ORIGIN + 3 * TURN[0] - TURN[2]]
    text = [repr(float(c)) for x in inner for c in cylindrical(axes @ (x - outer))]
    systems = (
        f"CORD2R,5,70,{','.join(text[:6])}\n,{','.join(text[6:])}\n"
        f"CORD2C,70,,{points(axes, outer)}\n"
    )
    assert_two_bricks(read(tmp_path, systems + in_system(rectangular, 5) + brick(1) + brick(2)))


# ----------------------------------------------------------------------------------- elements

# Corners of an element and, by their numbers from 1, the edges in the order in which the Quick
# Reference Guide numbers the nodes in their middles.
ELEMENTS = {
    "CTETRA": ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], "12 23 31 14 24 34"),
    "CPYRAM": (
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)],
        "12 23 34 41 15 25 35 45",
    ),
    "CPENTA": (
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
        "12 23 31 14 25 36 45 56 64",
    ),
    "CHEXA": (
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
        "12 23 34 41 15 26 37 48 56 67 78 85",
    ),
}
VOLUMES = {"CTETRA": 1 / 6, "CPYRAM": 1 / 3, "CPENTA": 1 / 2, "CHEXA": 1.0}


def element(name: str, quadratic: bool, *, nodes: int | None = None) -> str:
    corners, edges = ELEMENTS[name]
    x = np.array(corners, dtype=float)
    middles = [(x[int(a) - 1] + x[int(b) - 1]) / 2 for a, b in edges.split()]
    x = np.concatenate([x, middles]) if quadratic else x
    text = "".join(f"GRID,{10 + i},,{a},{b},{c}\n" for i, (a, b, c) in enumerate(x.tolist()))
    fields = ["7", "3", *(str(10 + i) for i in range(len(x)))][
        : None if nodes is None else 2 + nodes
    ]
    lines = [",".join(fields[i : i + 8]) for i in range(0, len(fields), 8)]
    return text + f"{name}," + "\n,".join(lines) + "\n"


@each("quadratic", [False, True])
@each("name", ELEMENTS)
def test_solids(name: str, quadratic: bool, tmp_path: Path) -> None:
    """Curved midside nodes that were out of order would change the volume, or be warned of."""
    mesh = read(tmp_path, element(name, quadratic))
    assert mesh.quadratic == quadratic
    assert mesh.cell_labels is not None
    assert mesh.cell_labels.tolist() == [7]
    assert volume(mesh) == pytest.approx(VOLUMES[name], rel=1e-12)


@each("points", ["free", "fixed-small", "fixed-large"])
@each(
    "kind, cells",
    [("tetra10", "fixed-small"), ("tetra10", "fixed-large"), ("hexahedron20", "fixed-small")],
)
def test_what_meshio_writes(kind: str, points: str, cells: str, tmp_path: Path) -> None:
    box = ao.box_mesh((2.0, 1.5, 1.0), (2, 1, 1), kind=kind)
    blocks = [(block.kind, block.cells) for block in box.blocks]
    written = meshio.Mesh(box.nodes, blocks)
    meshio.nastran.write(tmp_path / "deck.bdf", written, points, cells)
    mesh = ao.read_mesh(tmp_path / "deck.bdf")
    np.testing.assert_allclose(mesh.nodes, box.nodes, atol=1e-6)
    np.testing.assert_array_equal(mesh.cells, box.cells)


def test_either_sense_of_numbering_is_right(tmp_path: Path) -> None:
    mirrored = "CHEXA,2,2,2,5,6,3,8,11\n,12,9\n"
    mesh = read(tmp_path, "BEGIN BULK\n" + grids() + brick(1) + mirrored)
    assert volume(mesh) == pytest.approx(2.0, rel=1e-12)


def test_sides_and_edges_are_groups_of_nodes(tmp_path: Path) -> None:
    sides = (
        "CQUAD4,11,11,1,4,10,7\nCTRIA3,12,12,1,2,5\nCBAR,13,13,1,2,,,1.\nCONROD,14,3,6,99,1.\n"
        "CQUAD8,15,15,1,2,5,4,101,102\n,103,104\n"
    )
    mids = "GRID,101,,.5\nGRID,102,,1.,.5\nGRID,103,,.5,1.\nGRID,104,,0.,.5\n"
    with pytest.warns(ao.AOImpactWarning, match="nodes"):
        mesh = read(tmp_path, PLAIN.replace("ENDDATA", mids + sides + "ENDDATA"))
    assert mesh.node_labels is not None
    found = {name: mesh.node_labels[ids].tolist() for name, ids in mesh.node_sets.items()}
    assert found["property 11"] == [1, 4, 7, 10]
    assert found["property 12"] == [1, 2, 5]
    assert found["property 13"] == [1, 2]
    assert found["property 15"] == [1, 2, 4, 5]
    assert set(mesh.cell_sets) == {"property 1", "property 2"}


def test_sets_of_numbers(tmp_path: Path) -> None:
    """SET does not name the type of its members; both nodes and elements are tried."""
    head = (
        "CEND\nSET 1 = 1 THRU 9 EXCEPT 4, 5, 11\nSET 2 = 1,\n 2\nSET 3 = ALL\nSET 4 = 0.1, 0.2\n"
        "SET 5 = 1, 77\nDISP = 1\nOUTPUT(PLOT)\nSET 2 = 7\n"
    )
    bulk = (
        "SET1,1,1,THRU,3\nSET1,2,2,5,6,7,8,9,10\n,11\nSET3,3,ELEM,1,THRU,2\nSET3,4,GRID,1,2\n"
        "SET,6,GRID,LIST\n,4,5,6\n"
    )
    mesh = read(tmp_path, head + PLAIN.replace("ENDDATA", bulk + "ENDDATA"))
    assert mesh.node_labels is not None
    assert mesh.cell_labels is not None
    nodes = {name: mesh.node_labels[ids].tolist() for name, ids in mesh.node_sets.items()}
    cells = {name: mesh.cell_labels[ids].tolist() for name, ids in mesh.cell_sets.items()}
    assert nodes["SET 1 nodes"] == [1, 2, 3, 6, 7, 8, 9, 11]
    assert nodes["SET 2 nodes"] == [1, 2]
    assert nodes["SET1 1 nodes"] == [1, 2, 3]
    assert nodes["SET1 2 nodes"] == [2, 5, 6, 7, 8, 9, 10, 11]
    assert nodes["SET3 4 nodes"] == [1, 2]
    assert nodes["SET 6 nodes"] == [4, 5, 6]
    assert cells["SET 2 elements"] == [1, 2]
    assert cells["SET1 1 elements"] == [1, 2]
    assert cells["SET3 3 elements"] == [1, 2]
    assert nodes["SET3 3 elements"] == list(range(1, 13))
    named = {"SET 1", "SET 2", "SET1 1", "SET1 2", "SET3 3", "SET3 4", "SET 6"}
    assert {name.rsplit(" ", 1)[0] for name in nodes} == named | {"property"}


def test_a_set_given_twice_is_left_out(tmp_path: Path) -> None:
    head = "CEND\nSUBCASE 1\nSET 1 = 1, 2\nSUBCASE 2\nSET 1 = 3\nSET 2 = 3\n"
    with pytest.warns(ao.AOImpactWarning, match="control"):
        mesh = read(tmp_path, head + PLAIN)
    assert "SET 1 nodes" not in mesh.node_sets
    assert "SET 2 nodes" in mesh.node_sets


@each(
    "entries",
    [
        "CELAS2,9,1.,1,1\nCELAS2,10,1.,2,1\nCONM2,11,1,,5.\n",
        "RBE2,9,1,123,2,3\nMPC,1,1,1,1.,2,1,-1.\n",
        "DMIG,KX,0,6,1,0\nDMIG,KX,1,1,,1,1,1.+6\n",
        "CQUAD4,11,11,1,3,12,10\n",  # shells and beams beside solids
        "CBEAM,13,13,1,12,0.,0.,1.\nCROD,14,4,1,12\n",
        "CQUAD4,11,11,1,4,10,7\nPSHELL,11,1,.001\n",
    ],
)
def test_what_is_left_out_is_said(entries: str, tmp_path: Path) -> None:
    head = "SOL 103\nCEND\nK2GG = KX\n M2PP=KX\n" if "DMIG" in entries else ""
    with pytest.warns(ao.AOImpactWarning, match="left out"):
        assert_two_bricks(read(tmp_path, head + PLAIN.replace("ENDDATA", entries + "ENDDATA")))


@each("name", ["CROD", "CTUBE"])
def test_an_entry_may_have_two_rods(name: str, tmp_path: Path) -> None:
    """NASTRAN-95's manual: one or two elements may be defined on a single card."""
    mesh = read(tmp_path, f"GRID,1\nGRID,2,,1.\nGRID,3,,2.\n{name},5,8,1,2,6,9,2,3\nCBAR,4,7,1,3\n")
    assert mesh.cell_labels is not None
    nodes = dict(zip(mesh.cell_labels.tolist(), mesh.cells.tolist(), strict=True))
    assert nodes == {5: [0, 1], 6: [1, 2], 4: [0, 2]}
    assert list(mesh.cell_sets) == ["property 7", "property 8", "property 9"]


def test_replication(tmp_path: Path) -> None:
    """A bar of six bricks, of four nodes written out and the rest with increments."""
    rows = "".join(
        f"GRID,{1 + 10 * i},,0.,{y}.,{z}.\n=,*1,=,*1.,==\n=(5)\n"
        for i, (y, z) in enumerate([(0, 0), (1, 0), (0, 1), (1, 1)])
    )
    bricks = "".join(
        f"CHEXA,{i},1,{i},{i + 1},{i + 11},{i + 10},{i + 20},{i + 21}\n,{i + 31},{i + 30}\n"
        for i in range(1, 7)
    )
    mesh = read(tmp_path, rows + bricks + "DEBUG,192,1\nYPARAM,A,1\n")  # the solver's alone
    assert mesh.node_labels is not None
    expected = [((n - 1) % 10, (n - 1) // 10 % 2, (n - 1) // 20) for n in mesh.node_labels]
    np.testing.assert_array_equal(mesh.nodes, expected)
    assert (mesh.n_nodes, mesh.n_cells) == (28, 6)


# ----------------------------------------------------------------------------------- refusals

# Entries from line 18 on, in place of ENDDATA, and the line that is refused.
REFUSED = {
    "unknown name": ("GRDI,13,,1.", 18),
    "no name": ("GRID 13 0 1. 2. 3.", 18),
    "decimal comma": (small("GRID", 13, "", "1,5"), 18),
    "integer": ("GRID,13.,,1.", 18),
    "underscore": ("GRID,13,,1_0", 18),
    "not a number": ("GRID,13,,nan", 18),
    "too large": ("GRID,13,,1.+999", 18),
    "label": ("GRID,,,1.", 18),
    "node twice": ("GRID,3,,1.", 18),
    "element twice": (brick(2), 18),
    "kinds with one label": ("CTETRA,2,1,1,2,4,7", 16),
    "missing node": ("CTETRA,3,1,1,2,4,99", 18),
    "missing corner": ("CTETRA,3,1,1,2,4", 18),
    "too many nodes": ("CTETRA,3,1,1,2,4,7,1,2\n,3,4,5,6,7", 18),
    "two quadrilaterals": ("CSHEAR,3,1,1,2,5,4,4,1", 18),
    "two lines too many": ("CBAR,3,1,1,2,0.,0.,1.\n,,,0.,0.,0.\n,\n,7,8,9", 18),
    "a node more": ("CTRIA3,3,1,1,2,5\n,,0,.1,.1,.1,7", 18),
    "two defaults": ("BAROR,,2,,,0.,0.,1.\nBAROR,,2,,,0.,0.,1.\nCBAR,3,1,1,2", 19),
    "midside nodes": ("CTETRA,3,1,1,2,4,7,3,5\n,6,8,,9", 18),
    "no such system": ("GRID,13,8,1.", 18),
    "system on a line": ("CORD2R,8,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\nGRID,13,8", 18),
    "system of itself": ("CORD2R,8,8,0.,0.,0.,0.,0.,1.\n,1.,0.,2.\nGRID,13,8", 18),
    "system of nodes in it": ("CORD1R,8,13,1,2\nGRID,13,8,1.", 18),
    "system twice": ("CORD1R,8,1,2,4\nCORD1R,8,1,2,7", 19),
    "mark of no line": ("GRID,13,,1.\n+A,5", 19),
    "mark of two lines": (
        f"{'MAT1,1':72}+A\nMAT1,2,,,,,,,,+A\nMAT1,3\n+A,5".replace("MAT1,1", "MAT1   1", 1),
        21,
    ),
    "many fields": ("GRID,13,,1.,2.,3.,,,,+,5", 18),
    "one field more": ("GRID,13,,1.,2.,3.,,,,7", 18),
    "half a line": (f"GRID*   {13:<16}\n+       1.", 19),
    "superelements": ("BEGIN SUPER=1", 18),
    "no such file": ("INCLUDE 'none.bdf'", 18),
    "file within itself": ("INCLUDE 'deck.bdf'", 18),
    "open quotes": ("INCLUDE 'deck", 18),
    "set of names": ("SET1,1,A,B", 18),
    "replication": ("=,x", 18),
    "too many copies": ("GRID,13,,1.\n=,*1,==\n=(9999999)", 20),
}


@each("entries, line", REFUSED.values())
def test_what_is_not_understood_is_refused_by_line(entries: str, line: int, tmp_path: Path) -> None:
    with pytest.raises(ao.MeshError, match=rf"deck\.bdf', line {line}, "):
        read(tmp_path, PLAIN.replace("ENDDATA", entries.rstrip() + "\nENDDATA"))


@each(
    "text, words",
    [
        ("SOL 101\nCEND\n" + grids(), r"line 2\b"),
        ("BEGIN BULK\n,1,2\n" + grids(), r"line 2\b"),
        ("BEGIN BULK\n" + grids(), r"^mesh"),
        ("SOL 100\nCEND\nBEGIN BULK\nENDDATA\n", r"^mesh"),
        ("BEGIN BULK\n\0" + grids(), r"^mesh"),
    ],
)
def test_decks_without_a_mesh_are_refused(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(ao.MeshError, match=words):
        read(tmp_path, text)
