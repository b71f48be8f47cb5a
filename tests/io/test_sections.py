"""Sections of decks: what cards mean, by closed forms and by what is written by hand."""

from __future__ import annotations

import itertools
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse.linalg
from decks import CARBON, ELASTIC, MAT1, PLY, STEEL, abaqus, deck, nastran
from rows import each
from thinmeshes import line

import aoimpact as ao

# Warnings name a ply's E3, which is assumed, CIRC, and nodes that only say how a bar is turned.
pytestmark = pytest.mark.filterwarnings(
    "ignore:.*have no E3",
    "ignore:.*taken as in Abaqus",
    "ignore:.*nodes belong to no element",
    "ignore:.*taken for a radius",
    "ignore:.*at the centroid",
)

SHEET = ao.sheet_mesh((0.2, 0.1), (4, 2))
STEEL_SI = ao.Material(2.1e11, 0.3, 7800)
STEEL_SHELL = "*SHELL SECTION, ELSET=ALL, MATERIAL=STEEL\n.001"
EULER = 1.8751040687**2 / (2 * np.pi)  # of a cantilever, times √(EI/m)/L²


def read(path: Path, **given: Any) -> Any:
    (section,) = ao.read_sections(path, **given).values()
    return section


# ---------------------------------------------------------------------------------- units


@each(
    "E, rho, units",
    [
        ("2.1E11", "7800.", {}),
        ("210000.", "7.8E-9", {"scale": 1e-3}),  # mm, N, t, s
        ("210.", "7.8E-6", {"scale": 1e-3, "force": 1e3, "time": 1e-3}),  # mm, kN, kg, ms
        ("3.0457925E7", "7.2986E-4", {"scale": 0.0254, "force": 4.4482216}),  # in, lbf, s
    ],
)
def test_a_sheet_is_the_same_in_every_system_of_units(
    E: str, rho: str, units: dict[str, float], tmp_path: Path
) -> None:
    scale = units.get("scale", 1.0)
    cards = ["*SHELL SECTION, ELSET=ALL, MATERIAL=STEEL", f"{2e-3 / scale}", ELASTIC(E=E, rho=rho)]
    path = abaqus(tmp_path / "a.inp", SHEET, cards, scale=scale)
    sections = ao.read_sections(path, **units)
    mesh = ao.read_mesh(path, scale=scale, part=list(sections))
    body = ao.FEModel.from_mesh(mesh, sections)
    true = ao.FEModel.from_mesh(SHEET, ao.Shell(2e-3, STEEL_SI))
    assert body.mass == pytest.approx(true.mass, rel=1e-4)
    assert body.frequencies(8)[6:] == pytest.approx(true.frequencies(8)[6:], rel=1e-4)


@each("text", ["PARAM,WTMASS,.101972", "PARAM   WTMASS  .101972"])
@each("before", ["", "SOL 103\nCEND\n"])
def test_weights_are_masses_by_wtmass(text: str, before: str, tmp_path: Path) -> None:
    """In bulk data, and in case control."""
    path = deck(tmp_path, SHEET, "PSHELL,7,1,.002,1", MAT1.replace("7800.", "76492."))
    entry = f"{before}{text}\nBEGIN BULK\n" if before else f"BEGIN BULK\n{text}\n"
    path.write_text(path.read_text().replace("BEGIN BULK\n", entry))
    assert read(path).rho == pytest.approx(7800, rel=1e-5)
    path.write_text(path.read_text().replace("BEGIN BULK\n", "BEGIN BULK\nPARAM,WTMASS,.2\n"))
    with pytest.raises(ao.MeshError, match=r"line 3\b"):
        read(path)


# ------------------------------------------------------------------------------- laminates

# Bottom to top, degrees: neither symmetric nor balanced, so that every sign matters.
STACK = (0, 30, 90, -45)


def closed_form(t: float, z0: float) -> Any:
    """A, B and D of the stack by the invariants of Tsai and Pagano, from z0 upwards."""
    E1, E2, nu, G = 135e9, 9e9, 0.3, 5e9
    q = 1 - nu**2 * E2 / E1
    a, b, c = E1 / q, E2 / q, nu * E2 / q
    U1, U2, U3 = (3 * a + 3 * b + 2 * c + 4 * G) / 8, (a - b) / 2, (a + b - 2 * c - 4 * G) / 8
    U4, U5 = (a + b + 6 * c - 4 * G) / 8, (a + b - 2 * c + 4 * G) / 8
    sums = np.zeros((3, 3, 3))
    for k, degrees in enumerate(STACK):
        two, four = 2 * np.radians(degrees), 4 * np.radians(degrees)
        xy = U2 / 2 * np.sin(two) + U3 * np.sin(four), U2 / 2 * np.sin(two) - U3 * np.sin(four)
        xx, yy = (U1 + s * U2 * np.cos(two) + U3 * np.cos(four) for s in (1, -1))
        q12, q66 = U4 - U3 * np.cos(four), U5 - U3 * np.cos(four)
        Q = np.array([[xx, q12, xy[0]], [q12, yy, xy[1]], [xy[0], xy[1], q66]])
        low, high = z0 + k * t, z0 + (k + 1) * t
        sums += [Q * (high**n - low**n) / n for n in (1, 2, 3)]
    A, B, D = sums
    return np.block([[A, B], [B, D]])


PCOMP = "PCOMP,7,{z0}\n,2,.001,0.,,2,.001,30.,\n,2,.001,90.,,,,-45."
PCOMPG = "PCOMPG,7,{z0}\n,1,2,.001,0.\n,2,2,.001,30.\n,3,2,.001,90.\n,4,2,.001,-45.".format
COMPOSITE = "\n.001, 3, PLY, 0.\n.001, 3, PLY, 30.\n.001, 3, PLY, 90.\n.001, 3, PLY, -45.".__add__
AXES = "\n*ORIENTATION, NAME=O{}\n{:.9f}, {:.9f}, 0., {:.9f}, {:.9f}, 0.".format
NAMED = "".join(  # as CalculiX has it: every ply with axes of its own
    AXES(k, np.cos(a), np.sin(a), -np.sin(a), np.cos(a)) for k, a in enumerate(np.radians(STACK))
)
BY_NAME = "*SHELL SECTION, COMPOSITE, ELSET=ALL" + "".join(f"\n.001,, PLY, O{k}" for k in range(4))


PLIES = "*SHELL SECTION, COMPOSITE, ELSET=ALL"
GENERAL_PLIES = "*SHELL GENERAL SECTION, COMPOSITE, ELSET=ALL, OFFSET=SNEG"


@each(
    "cards, z0",
    [
        (PCOMP.format(z0=""), -2e-3),
        (PCOMP.format(z0="0."), 0.0),
        (PCOMPG(z0="-.003"), -3e-3),
        (PLIES + COMPOSITE(""), -2e-3),
        (PLIES + ", OFFSET=SPOS" + COMPOSITE(""), -4e-3),
        (GENERAL_PLIES + COMPOSITE(""), 0.0),
        (PLIES + ", OFFSET=.25" + COMPOSITE(""), -3e-3),
        (BY_NAME + NAMED, -2e-3),
    ],
)
def test_the_stiffness_of_plies_is_that_of_the_closed_form(
    cards: str, z0: float, tmp_path: Path
) -> None:
    path = deck(tmp_path, SHEET, cards)
    laminate = read(path)
    assert laminate.stiffness[:6, :6] == pytest.approx(closed_form(1e-3, z0), rel=1e-6, abs=1e-6)
    assert laminate.reference == pytest.approx([1, 0, 0])
    assert laminate.interfaces[0] == pytest.approx(z0)


@each(
    "cards",
    [
        "PCOMP,7,,,,,,,SYM\n,2,.001,0.,,2,.001,90.",
        PLIES + ", SYMMETRIC\n.001,3,PLY,0\n.001,3,PLY,90",
    ],
)
def test_symmetric_stacks_are_given_by_halves(cards: str, tmp_path: Path) -> None:
    path = deck(tmp_path, SHEET, cards)
    assert [ply.angle_deg for ply in read(path).plies] == [0, 90, 90, 0]
    assert read(path).plies[0].material == CARBON


ORIENTED = "*SHELL SECTION, ELSET=ALL, MATERIAL=PLY, ORIENTATION=O\n.001\n*ORIENTATION, NAME=O\n"


SIXTY = "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,.5,.8660254038,0."


@each(
    "cards, after, degrees",
    [
        (ORIENTED + "1,0,0, 0,1,0", "", 0),
        (ORIENTED + "1,0,0, 0,1,0\n3, 20.", "", 20),
        (ORIENTED + "0,0,1, 1,0,0\n1, 0.", "", 0),  # axis 1 is normal; 2, which follows, is x
        (ORIENTED + "0,0,1, 1,0,0\n1, 35.", "", 35),
        (ORIENTED + "0,0,1, 1,0,0\n, 35.", "", 35),  # blank is 1 in Abaqus
        (ORIENTED + "0,1,0, 0,0,1\n2, 0.", "", 0),  # axis 2 is normal; 3 is x
        (ORIENTED + "2,2,1, 1,3,1, 1,1,1\n3, 0.", "", 45),  # with an origin
        (f"PSHELL,7,2,.001,2\n{SIXTY}", "", 0),
        (f"PSHELL,7,2,.001,2\n{SIXTY}", ",30.", 30),
        (f"PSHELL,7,2,.001,2\n{SIXTY}", ",5", 60),
    ],
)
def test_fibres_lie_as_the_cards_say(
    cards: str, after: str, degrees: float, tmp_path: Path
) -> None:
    """A sheet whose elements' first edges are along x."""
    path = deck(tmp_path, SHEET, cards, after=after)
    x, y, z = read(path).reference
    assert np.degrees(np.arctan2(y, x)) == pytest.approx(degrees, abs=1e-5)
    assert abs(z) < 1e-9


LAMINA = "*ELASTIC, TYPE=LAMINA\n60E9, 58E9, .05, 4.5E9, 4E9, 4E9\n*DENSITY\n1550."


@each(
    "cards",
    [
        f"*SHELL SECTION, ELSET=ALL, MATERIAL=F\n.001\n*MATERIAL, NAME=F\n{LAMINA}",
        "PSHELL,7,2,.001,2\nMAT8,2,60.E9,58.E9,.05,4.5E9,4.E9,4.E9,1550.",
    ],
)
def test_a_fabric_is_stiff_along_both_fibres_and_soft_across(cards: str, tmp_path: Path) -> None:
    """A, B, D do not depend on E3. It is 2 (1 + ν) G of the resin that carries both."""
    path = deck(tmp_path, SHEET, cards)
    with pytest.warns(ao.AOImpactWarning, match="E3"):
        ply = read(path)
    material = ply.plies[0].material
    assert list(material.E) == pytest.approx([60e9, 58e9, 2 * 1.4 * 4e9])
    q = 1 - 0.05**2 * 58 / 60
    assert np.diag(ply.stiffness)[:3] == pytest.approx([60e6 / q, 58e6 / q, 4.5e6], rel=1e-9)


# ------------------------------------------------------------------------- beams and solids


@each("shape", ["BAR\n,.02,.01", "T\n,.02,.01,.002,.002"])
def test_offsets_of_bars_lead_from_their_nodes_to_the_centroid(shape: str, tmp_path: Path) -> None:
    after = ",0.,1.,0.\n,,,0.,.03,.05,0.,.03,.05"
    beam = read(deck(tmp_path, line(), f"PBARL,7,1,,{shape}", after=after))
    z = np.array(beam.orientation)
    y = np.cross(z, [1, 0, 0])
    assert beam.offset[0] * y + beam.offset[1] * z == pytest.approx([0, 0.03, 0.05])


def test_a_strip_with_a_stringer_rings_as_steiner_says(tmp_path: Path) -> None:
    """A cantilever of a plate and a bar below it, which share a property's number."""
    strip = ao.sheet_mesh((1.0, 0.1), (20, 2))
    at = [np.flatnonzero(np.isclose(strip.nodes[:, 1], y)) for y in (0, 0.05, 0.1)]
    middle = at[1][np.argsort(strip.nodes[at[1], 0])] + 1
    bars = [
        f"CBAR,{100 + i},7,{a},{b},0.,0.,1.\n,,,0.,0.,-.021,0.,0.,-.021"
        for i, (a, b) in enumerate(itertools.pairwise(middle))
    ]
    cards = ["PSHELL,7,1,.002,1", "PBARL,7,1,,BAR\n,.002,.04", "MAT1,1,7.E10,,0.,2700.", *bars]
    path = nastran(tmp_path / "a.bdf", strip, cards)
    root = [int(one[np.argmin(strip.nodes[one, 0])]) + 1 for one in at]
    body = ao.FEModel.from_mesh(path, ao.read_sections(path), fixed=[(root, "xyz", "xyz")])
    areas, places = np.array([0.1 * 0.002, 0.002 * 0.04]), np.array([0.0, -0.021])
    centre = areas @ places / areas.sum()
    second = areas @ (np.array([0.002, 0.04]) ** 2 / 12 + (places - centre) ** 2)
    assert body.mass == pytest.approx(2700 * areas.sum())
    euler = EULER * np.sqrt(7e10 * second / (2700 * areas.sum()))
    assert body.frequencies(1)[0] == pytest.approx(euler, rel=0.01)


def test_a_shell_and_a_bar_may_have_one_number(tmp_path: Path) -> None:
    bars = "CBAR,99,7,1,2,0.,0.,1.\nPBARL,07,+1,,BAR\n,.02,.01"
    path = deck(tmp_path, SHEET, "PSHELL,+7,01,.001,+1", bars)
    body = ao.FEModel.from_mesh(path, ao.read_sections(path))
    assert body.mass == pytest.approx(7800 * (0.2 * 0.1 * 1e-3 + 0.05 * 0.02 * 0.01))


def test_values_of_no_solid_are_said(tmp_path: Path) -> None:
    cards = ["*SHELL SECTION, ELSET=ALL, MATERIAL=STEEL", ".1", ELASTIC(E="10.3E6", rho="2.59E-4")]
    with pytest.warns(ao.AOImpactWarning, match="scale="):  # in, lbf, s
        read(abaqus(tmp_path / "a.inp", SHEET, cards))


RECT = "*BEAM SECTION, ELSET=ALL, SECTION=RECT, MATERIAL=STEEL\n.01, .02\n0, 0, 1"
GENERAL = (
    "*BEAM GENERAL SECTION, ELSET=ALL, SECTION=GENERAL, DENSITY=7800.\n{}\n{}\n2.1E11, 8.0769231E10"
)
AREA, ALONG, OTHER = "2.E-4", "1.6666667E-9", "6.6666667E-9"  # of 10 mm along z, 20 mm along y


@each(
    "card, after",
    [
        (RECT, ""),
        (RECT.replace(".01, .02\n0, 0, 1", ".02, .01\n0, 1, 0"), ""),
        (RECT.replace("\n0, 0, 1", ""), ""),  # the default is -z
        (GENERAL.format(f"{AREA}, {OTHER}, 0., {ALONG}, 4.6E-9", "0, 0, 1"), ""),
        (GENERAL.format(f"{AREA}, {OTHER}, 0., {ALONG}, 4.6E-9", "").replace("\n\n", "\n"), ""),
        ("PBARL,7,1,,BAR\n,.02,.01", ",0.,0.,1."),
        ("PBEAML,7,1,,BAR\n,.01,.02", ",0.,1.,0."),
        ("PBARL,7,1,,BAR $ CD\n,.01,.02", ",0.,0.,1."),  # in axes of node GA
        ("PBARL,7,1,,BAR $ CD\n,.02,.01", ",0.,0.,1.,BGG"),
        (f"PBAR,7,1,{AREA},{ALONG},{OTHER},4.6E-9", ",0.3,0.,1."),
        (f"PBAR,7,1,{AREA},{OTHER},{ALONG},4.6E-9", ",99"),
        (f"PBEAM,7,1,{AREA},{ALONG},{OTHER},,4.6E-9", ",0.,0.,1."),
    ],
)
def test_a_cantilever_rings_across_each_of_its_sides(card: str, after: str, tmp_path: Path) -> None:
    """Of 10 mm along z and 20 mm along y: Euler's frequencies, and the directions of both modes."""
    more = ["GRID,99,,0.,3.,0."] if card[0] == "P" else []
    path = deck(tmp_path, line(), card, *more, after=after)
    if "CD" in card:
        axes = "\nCORD2R,5,,0.,0.,0.,0.,1.,0.\n,1.,0.,0.\nCBAR"
        path.write_text(path.read_text().replace(",0\n", ",0,5\n").replace("\nCBAR", axes, 1))
    if "PBEAM" in card:
        path.write_text(path.read_text().replace("CBAR", "CBEAM"))
    body = ao.FEModel.from_mesh(path, ao.read_sections(path), fixed=[([1], "xyz", "xyz")])
    for axis, height, width in ((2, 0.01, 0.02), (1, 0.02, 0.01)):
        tip = np.flatnonzero(body.free == 3 * 10 + axis)
        unit = np.zeros(body.n_dofs)
        unit[tip] = 1.0
        stiffness = 1 / scipy.sparse.linalg.spsolve(body.K.tocsc(), unit)[tip]
        assert stiffness == pytest.approx(3 * 2.1e11 * width * height**3 / 12, rel=2e-3)
    root = np.sqrt(2.1e11 / 7800 / 12)
    assert body.frequencies(2) == pytest.approx(
        [EULER * root * 0.01, EULER * root * 0.02], rel=2e-3
    )


@each(
    "card, factors",
    [  # K1 is of shear along z, K2 along y
        ("PBAR,7,1,1.E-2,8.E-6,8.E-6,1.E-5", (math.inf, math.inf)),
        ("PBAR,7,1,1.E-2,8.E-6,8.E-6,1.E-5\n,\n,0.,.8", (0.8, math.inf)),
        ("PBAR,7,1,1.E-2,8.E-6,8.E-6,1.E-5\n,\n,.85,.8", (0.8, 0.85)),
        ("PBEAM,7,1,1.E-2,8.E-6,8.E-6,,1.E-5", (1.0, 1.0)),
        ("PBEAM,7,1,1.E-2,8.E-6,8.E-6,,1.E-5\n,\n,0.,0.", (math.inf, math.inf)),
    ],
)
def test_bars_are_rigid_in_shear_unless_they_have_factors(
    card: str, factors: tuple[float, float], tmp_path: Path
) -> None:
    beam = read(deck(tmp_path, line(), card, after=",0.,0.,1."))
    assert beam.section.shear_factors == pytest.approx(factors)


BEAM = "*BEAM SECTION, ELSET=ALL, MATERIAL=STEEL, SECTION="


@each(
    "card, section",
    [
        (BEAM + "CIRC\n.01\n0,1,0", ao.CircularSection(0.01)),
        (BEAM + "CIRC\n.02, .02", ao.CircularSection(0.01)),  # diameters, of CalculiX
        (BEAM + "PIPE\n.01, .002", ao.TubularSection(0.01, 0.002)),
        (BEAM.replace("SEC", "GENERAL SEC", 1) + "PIPE\n.01, .002", ao.TubularSection(0.01, 0.002)),
        ("PBARL,7,1,,ROD\n,.01", ao.CircularSection(0.01)),
        ("PBARL,7,1,,TUBE\n,.01,.008,0.", ao.TubularSection(0.01, 0.002)),
        ("PBEAML,7,1,,TUBE2\n,.01,.002", ao.TubularSection(0.01, 0.002)),
    ],
)
def test_round_sections_are_read(card: str, section: Any, tmp_path: Path) -> None:
    beam = read(deck(tmp_path, line(), card, after=",0.,1.,0."))
    assert vars(beam.section) == pytest.approx(vars(section))
    assert beam.material == STEEL_SI


def test_circles_are_radii_in_abaqus_and_diameters_in_calculix(tmp_path: Path) -> None:
    """B31R are CalculiX' own, as parts are Abaqus'; a deck without these could be of either."""
    cards = [BEAM + "CIRC\n.01"]
    assert read(deck(tmp_path, line(), *cards, kind="B31R")).section == ao.CircularSection(0.005)
    with pytest.warns(ao.AOImpactWarning, match=r"^mesh"):
        assert read(deck(tmp_path, line(), *cards)).section == ao.CircularSection(0.01)
    part = abaqus(tmp_path / "c.inp", line(), cards, "B31").read_text()
    assembly = "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n*END ASSEMBLY\n"
    (tmp_path / "c.inp").write_text(f"*PART, NAME=P\n{part}\n*END PART\n{assembly}{STEEL}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read(tmp_path / "c.inp").section == ao.CircularSection(0.01)


WOOD = ao.Orthotropic((12e9, 1e9, 0.6e9), (0.8e9, 0.7e9, 0.05e9), (0.4, 0.5, 0.3), rho=500)
NINE = "12E9, 1E9, .6E9, .4, .5, .3, .8E9, .7E9,\n.05E9"


WOODEN = f"""*SOLID SECTION, ELSET=ALL, MATERIAL=WOOD, ORIENTATION=O
*ORIENTATION, NAME=O
0,1,0, -1,0,0
*MATERIAL, NAME=WOOD
*ELASTIC, TYPE=ENGINEERING CONSTANTS
{NINE}
*DENSITY
500."""
MAT11 = """PSOLID,7,2,5
MAT11,2,12.E9,1.E9,.6E9,.4,.5,.3,.8E9
,.7E9,.05E9,500.
CORD2R,5,,0.,0.,0.,0.,0.,1.
,0.,1.,0."""


@each("cards", [WOODEN, MAT11])
def test_solids_have_the_stiffness_of_nine_constants_in_axes_of_their_own(
    cards: str, tmp_path: Path
) -> None:
    """Hooke's matrix about z turned by a right angle: x and y, yz and xz change places."""
    path = deck(tmp_path, ao.box_mesh((0.2, 0.1, 0.1), (2, 1, 1)), cards)
    turned = [1, 0, 2, 3, 5, 4]
    wanted = WOOD.stiffness[np.ix_(turned, turned)]
    assert read(path).stiffness == pytest.approx(wanted, rel=1e-9, abs=1)


def test_sections_of_a_part_turn_with_its_instances(tmp_path: Path) -> None:
    """Two instances, one turned by 90° about z: the fibres of each follow."""
    strip = abaqus(
        tmp_path / "part.inp", SHEET, ["*SHELL SECTION, ELSET=ALL, MATERIAL=PLY, ORIENTATION=O"]
    )
    part = strip.read_text() + "\n.001\n*ORIENTATION, NAME=O\n1,0,0, 0,1,0\n3, 0.\n"
    text = f"*PART, NAME=P\n{part}*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=a, PART=P\n"
    text += "*END INSTANCE\n*INSTANCE, NAME=b, PART=P\n5,0,0\n0,0,0, 0,0,1, 90.\n*END INSTANCE\n"
    (tmp_path / "a.inp").write_text(f"{text}*END ASSEMBLY\n{PLY}")
    sections = ao.read_sections(tmp_path / "a.inp")
    assert list(sections) == ["a.ALL", "b.ALL"]
    first, second = (np.array(of.reference) for of in sections.values())  # type: ignore[union-attr]
    assert first == pytest.approx([1, 0, 0])
    assert second == pytest.approx([0, 1, 0], abs=1e-12)
    body = ao.FEModel.from_mesh(tmp_path / "a.inp", sections, part="b.ALL")
    assert body.mesh is not None
    assert len(body.mesh.cells) == len(SHEET.cells)


def test_what_is_given_takes_the_place_of_cards(tmp_path: Path) -> None:
    bare = STEEL.replace("*DENSITY\n7800.\n", "")
    path = deck(tmp_path, SHEET, STEEL_SHELL, bare)
    assert read(path, given={"Steel": STEEL_SI}) == ao.Shell(1e-3, STEEL_SI)
    thick = ao.Shell(5e-3, STEEL_SI)
    assert read(path, given={"all": thick}) == thick
    with pytest.raises(ao.InputError, match="given"):
        ao.read_sections(path, given={"STEEL": STEEL_SI, "STEAL": STEEL_SI})
    for wrong, said in (
        ({"STEEL": thick}, "offset="),
        ({"ALL": STEEL_SI}, "E="),
        ({1: STEEL_SI}, "given"),
    ):
        with pytest.raises(ao.InputTypeError, match=said):
            ao.read_sections(path, given={"STEEL": STEEL_SI} | wrong)  # type: ignore[dict-item]


def test_a_group_and_its_material_may_have_one_name(tmp_path: Path) -> None:
    path = deck(tmp_path, SHEET, f"{STEEL_SHELL}\n{STEEL}".replace("STEEL", "ALL"))
    other = ao.Material(7e10, 0.33, 2700)
    assert read(path, given={"ALL": other}) == ao.Shell(1e-3, other)


@each(
    "cards",
    [
        f"{STEEL_SHELL}\n{STEEL}*PLASTIC\n3E8, 0.\n*DAMPING, BETA=1E-6",
        f"{STEEL_SHELL}\n*FOUNDATION\nALL, F1, 1E6",
        f"{ORIENTED}0,0,1, 1,0,0\n, 35.",
        f"*NODE\n99, 5., 0., 0., 0., 0., 1.\n{STEEL_SHELL}",
        f"PSHELL,7,1,.001,1\n{MAT1},,,.02",
        "PCOMP,7,,,,,,.02\n,1,.001,0.",
        "PSHELL,7,1,.001,1\nMATS1,1,3",
        *(
            f"*SHELL SECTION, ELSET=ALL, MATERIAL=PLY\n.002\n{PLY}*{card}\n1, -1, 1, -1, 1"
            for card in ("FAIL STRESS", "FAIL STRAIN", "TENSILE FAILURE")
        ),
    ],
)
def test_what_is_left_out_is_said(cards: str, tmp_path: Path) -> None:
    with pytest.warns(ao.AOImpactWarning, match=r"^mesh"):
        read(deck(tmp_path, SHEET, cards))


def test_a_section_that_is_given_holds_what_cards_add(tmp_path: Path) -> None:
    mass = ["*NONSTRUCTURAL MASS, ELSET=ALL, UNITS=MASS PER AREA", "7.8"]
    heavy = ao.Shell(1e-3, ao.Material(2.1e11, 0.3, 15600))
    path = deck(tmp_path, SHEET, STEEL_SHELL, *mass)
    assert read(path, given={"ALL": heavy}) == heavy
    shear = "\n".join(["", STEEL_SHELL, "*TRANSVERSE SHEAR STIFFNESS", "1E6, 1E6, 0."])
    part = abaqus(tmp_path / "b.inp", SHEET, []).read_text() + shear
    text = f"*PART, NAME=P\n{part}\n*END PART\n*ASSEMBLY, NAME=A\n"
    text += "".join(f"*INSTANCE, NAME={of}, PART=P\n*END INSTANCE\n" for of in "ab")
    (tmp_path / "b.inp").write_text(f"{text}*END ASSEMBLY\n{STEEL}")
    both = ao.read_sections(tmp_path / "b.inp", given={"a.ALL": heavy, "b.ALL": heavy})
    assert list(both.values()) == [heavy, heavy]
    with pytest.raises(ao.MeshError, match=r"line 62\b"):
        ao.read_sections(tmp_path / "b.inp", given={"a.ALL": heavy})


@each("kind", ["BAR", "BEAM"])
@each(
    "written, defaults, whole",
    [
        (",,1,2", ",9,,,0.,3.,4.", ",9,1,2,0.,3.,4."),
        (",9,1,2,,3.", ",8,,,0.,5.,4.", ",9,1,2,0.,3.,4."),  # each field by itself
        (",9,1,2,3", ",8,,,0.,3.,4.", ",9,1,2,3"),  # G0
        (",,1,2", ",9,,,3,,,GGG", ",9,1,2,3,,,GGG"),
    ],
)
def test_blank_fields_of_bars_are_those_of_their_defaults(
    kind: str, written: str, defaults: str, whole: str, tmp_path: Path
) -> None:
    more = "GRID,1\nGRID,2,,1.\nGRID,3,,0.,1.,1.\n" + MAT1
    for label, area in ((8, 2), (9, 1), (5, 3)):
        more += f"\nP{kind},{label},1,{area}.-4,1.-9,2.-9,{',' * (kind == 'BEAM')}1.-9"
    found = []
    for text in (f"C{kind},5{written}\n{kind}OR,{defaults}", f"C{kind},5{whole}"):
        (tmp_path / "a.bdf").write_text(f"BEGIN BULK\n{text}\n{more}\n")
        found.append(ao.read_sections(tmp_path / "a.bdf"))
    assert list(found[1]) == ["property 9"]
    assert found[0] == found[1]


@each(
    "card",
    ["PBAR,7,1,1.E-4,1.E-9,1.E-9,2.E-9", "PBARL,7,1,,ROD\n,.01", "PBARL,7,1,,TUBE\n,.01,.009"],
)
def test_a_round_bar_may_be_turned_as_it_likes(card: str, tmp_path: Path) -> None:
    """One of several directions has the stiffness of one that is across both bars."""
    nodes = "BEGIN BULK\nGRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nCBAR,1,7,1,2,0.,0.,1.\n"
    bodies = []
    for vector in ("0.,0.,1.", "1.,0.,.5"):
        path = tmp_path / "a.bdf"
        path.write_text(f"{nodes}CBAR,2,7,2,3,{vector}\n{card}\n{MAT1}\n")
        bodies.append(ao.FEModel.from_mesh(path, ao.read_sections(path)))
    K, turned = (body.K.toarray() for body in bodies)
    assert turned == pytest.approx(K, rel=1e-12, abs=1e-12 * K.max())


def test_bars_take_G_as_it_is_and_solids_as_it_was_rounded(tmp_path: Path) -> None:
    of = "MAT1,1,7.+10,{},.33,2700.".format
    path = deck(tmp_path, SHEET, "PSHELL,7,1,.001,1", of("2.6+10"))
    with pytest.warns(ao.AOImpactWarning, match=r"^mesh"):
        assert read(path).material == ao.Material(7e10, 0.33, 2700)
    nastran(path, SHEET, ["PSHELL,7,1,.001,1", of("2.7+10")])
    with pytest.raises(ao.MeshError, match="MAT1"):
        ao.read_sections(path)
    nastran(path, line(), ["PBARL,7,1,,ROD\n,.01", of("2.9+10")], ",0.,0.,1.")
    assert read(path).material.shear_modulus == pytest.approx(2.9e10, rel=1e-12)


def test_rods_beside_bars_are_left_out_aloud(tmp_path: Path) -> None:
    more = ["PBARL,7,1,,ROD\n,.01", "GRID,99,,,1.", "CROD,99,8,1,99", "PROD,8,1,.1"]
    path = deck(tmp_path, line(), *more, after=",0.,0.,1.")
    with pytest.warns(ao.AOImpactWarning, match=r"^mesh"):
        sections = ao.read_sections(path)
    with pytest.warns(ao.AOImpactWarning, match="elements"):
        body = ao.FEModel.from_mesh(path, sections)
    assert body.mass == pytest.approx(7800 * np.pi * 1e-4, rel=1e-12)
