"""Cards that would change the answer and are not understood are refused, with file and line."""

from __future__ import annotations

from pathlib import Path

import pytest
from decks import MAT1, PLY, STEEL, abaqus, deck
from rows import each
from thinmeshes import line

import aoimpact as ao
from aoimpact.base import MissingFileError

SHEET = ao.sheet_mesh((0.2, 0.1), (4, 2))
SHELL = "*SHELL SECTION, ELSET=ALL, MATERIAL=STEEL\n.001\n"
PLIED = "*SHELL SECTION, ELSET=ALL, MATERIAL=PLY, ORIENTATION=O\n.001\n*ORIENTATION, NAME=O"
BEAM = STEEL + PLY + "*BEAM SECTION, ELSET=ALL, MATERIAL=STEEL, SECTION="
GENERAL = "*BEAM GENERAL SECTION, ELSET=ALL, SECTION=GENERAL, DENSITY=7800.\n"


def made(*options: str) -> str:
    return "\n".join(["*MATERIAL, NAME=STEEL", *options, ""])


# Cards of which the keyword, or the entry, is refused at its line.
KEYWORDS = {
    "MATERIAL": [SHELL + made("*DENSITY", "7800."), SHELL + made("*ELASTIC", "2.1E11, .3")],
    "ELASTIC": [
        SHELL + STEEL.replace(", 0.3", ", 0.3, 20.\n2E11, 0.3, 200."),
        SHELL + STEEL.replace("*ELASTIC", "*ELASTIC, DEPENDENCIES=1"),
        SHELL + STEEL.replace("*ELASTIC", "*ELASTIC, TYPE=ANISOTROPIC"),
        SHELL + STEEL.replace(", 0.3", ""),
        SHELL + STEEL.replace("0.3", "0.6"),
    ],
    "DENSITY": [SHELL + STEEL.replace("7800.", "7800., 20.\n7700., 200.")],
    "SHELLSECTION": [
        SHELL + STEEL.replace("STEEL", "OTHER"),
        SHELL,
        SHELL.replace("\n", ", NODAL THICKNESS\n", 1) + STEEL,
        SHELL.replace("\n", ", DENSITY=3.\n", 1) + STEEL,
        SHELL.replace("ALL", "NONE") + STEEL,
        SHELL + SHELL.replace("ELSET=ALL, ", "") + STEEL,
        SHELL.replace(".001\n", "") + STEEL,
        SHELL.replace(".001", "-.001") + STEEL,
        SHELL + SHELL + STEEL,
        SHELL.replace("\n.001", ", COMPOSITE") + STEEL,
        PLIED + "\n1,0,0, 0,1,0\n1, 0.\n" + PLY,
        PLIED + "\n1,0,0, 0,1,0\n, 30.\n" + PLY,
        PLIED.replace("NAME=O", "NAME=P") + "\n1,0,0, 0,1,0\n" + PLY,
    ],
    "SHELLGENERALSECTION": ["*SHELL GENERAL SECTION, ELSET=ALL\n1E9, 0., 1E9\n" + STEEL],
    "SHELLSECTON": [SHELL.replace("SECTION", "SECTON") + STEEL],
    "SHELLSECTION2": [SHELL.replace("SECTION", "SECTION 2") + STEEL],
    "SURFACESECTON": ["*SURFACE SECTON, ELSET=ALL\n" + SHELL + STEEL],
    "ELEMENT": [  # without a section: all, and one
        "*MEMBRANE SECTION, ELSET=ALL, MATERIAL=STEEL\n.001\n" + STEEL,
        "*ELSET, ELSET=SOME, GENERATE\n1, 7\n" + SHELL.replace("ALL", "SOME") + STEEL,
    ],
    "TRANSVERSESHEARSTIFFNESS": [SHELL + "*TRANSVERSE SHEAR STIFFNESS\n1E6, 1E6, 0.\n" + STEEL],
    "NONSTRUCTURALMASS": [SHELL + "*NONSTRUCTURAL MASS, ELSET=ALL, UNITS=TOTAL MASS\n2.\n" + STEEL],
    "ORIENTATION": [
        PLIED + "\n1,0,0, 0,1,0\n*ORIENTATION, NAME=O\n0,1,0, -1,0,0\n" + PLY,
        PLIED + ", SYSTEM=CYLINDRICAL\n0,0,0, 0,0,1\n" + PLY,
        PLIED + ", DEFINITION=NODES\n1, 2\n" + PLY,
        PLIED + "\n1,0,0, 2,0,0\n" + PLY,
        PLIED + "\n1,0,0, 0,1,0\n4, 0.\n" + PLY,
    ],
    "BEAMSECTION": [
        BEAM + "ELBOW\n.1, .01, 1",
        *(BEAM + f"BOX\n.1, .1, {walls}" for walls in (".06, .01, .06, .01", ".01, 0., .01, .01")),
        BEAM + "HEX\n.1, 0.",
        BEAM + "ARBITRARY\n2, 0, 0, 1, 0, .1",
        BEAM + "ARBITRARY\n1E30, 0, 0, 1, 0, .1",
        BEAM + "ARBITRARY\n1.5, 0, 0, 1, 0, .1\n1, 1, .1",
        BEAM + "RECT\n.01",
        BEAM + "RECT\n.01, .02\n5",
        BEAM + "RECT\n.01, .02\n1,0,0",
        BEAM + "RECT, OFFSET1=.5\n.01, .02",
        BEAM + "CIRC\n.01, .02",
        BEAM.replace("=STEEL, S", "=PLY, S") + "CIRC\n.01",
    ],
    "BEAMGENERALSECTION": [
        GENERAL + "2E-4, 1E-9, 2E-9, 1E-9, 4E-9\n0,0,1\n2E11, 8E10",
        GENERAL + "2E-4, 1E-9, 0., 1E-9, 4E-9\n0,0,1",
        GENERAL + "2E-4, 1E-9, 0., 1E-9, 4E-9\n0,0,1\n2E11, 8E10, 0., 20.\n1E11, 4E10, 0., 300.",
        GENERAL + "2E-4, 1E-9, 0., 1E-9, 4E-9\n2E11, 8E10, 0., 20.\n1E11, 4E10, 0., 300.",
    ],
    "NORMAL": [BEAM + "RECT\n.01, .02\n*NORMAL, TYPE=ELEMENT\n1, 1, 0., 1., 0."],
    "NODE": [BEAM + "RECT\n.01, .02\n*NODE\n99, 0., 5., 0., 0., 0., 1."],
    "CENTROID": [BEAM + "RECT\n.01, .02\n*CENTROID\n.01, 0."],
    "RELEASE": [BEAM + "RECT\n.01, .02\n*RELEASE\n1, S1, ALLM"],
    "BEAMFLUIDINERTIA": [BEAM + "RECT\n.01, .02\n*BEAM FLUID INERTIA\n1., 1."],
    "BEAMSECTIONOFFSET": [BEAM + "RECT\n.01, .02\n*BEAM SECTION OFFSET\n.01, 0."],
}

# Entries of sheets with what stands after the nodes of each element, and of bars.
ENTRIES = {
    "PSHELL": [
        *("PSHELL,7,1,,1", "PSHELL,7,1,.001", "PSHELL,7,1,.001,2", "PSHELL,7,1,.001,1,1.5"),
        *("PSHELL,7,1,.001,1,,1,.5", "PSHELL,7,1,.001,1,,2", "PSHELL,7,1,.001,1,,1,.833333,2."),
        *("PSHELL,7,1,.001,1\n,,,1", "PSHELL,7,9,.001,9", "PSHELL,7,1.,.001,1"),
        "PSHELL,7,1,.001,1\nPSHELL,7,1,.002,1",
        ("PSHELL,7,2,.001,2", ",5"),
    ],
    "PCOMP": [
        *("PCOMP,7,,,,,,,MEM\n,2,.001,0.", "PCOMP,7,,2.\n,2,.001,0.", "PCOMP,7\n,2,,0."),
        "PCOMP,7\n,4.7,.001,0.",
    ],
    "PSHEAR": ["PSHEAR,7,1,.001"],
    "NSM1": ["PSHELL,7,1,.001,1\nNSM1,3,PSHELL,2.,7"],
    "CQUAD4": [
        *("PBAR,7,1,1.,1.,1.,1.", "PSHELL,8,1,.001,1", ("PSHELL,7,2,.001,2", ",9")),
        ("PSHELL,7,2,.001,2", ",,,\n,,,.002,.002,.002,.002"),
    ],
    "MAT1": [
        "PSHELL,7,1,.001,1\n" + one
        for one in (
            MAT1.replace("7800.", ""),
            MAT1.replace(".3", ""),
            MAT1.replace(",.3", "0.,"),
            MAT1.replace(",,", ",2.1E11,"),
            MAT1 + "\nMATT1,1,3",
        )
    ],
}

BAR = "PBARL,7,1,,BAR\n,.1,.2"
BARS = {
    "PBAR": [
        *("PBAR,7,1,1.E-4,1.E-9,1.E-9", "PBAR,7,1,1.E-4,1.E-9,1.E-9,1.E-9,2."),
        "PBAR,7,1,1.E-4,1.E-9,1.E-9,1.E-9\n,\n,,,1.E-8",
        "PBAR,7,2,1.E-4,1.E-9,1.E-9,1.E-9",
    ],
    "PBEAM": ["PBEAM,7,1,1.E-4,1.E-9,1.E-9,,1.E-9\n,\n,YES,1.,2.E-4"],
    "PBARL": [
        *("PBARL,7,1,,DBOX\n,.1,.1,.1,.1", "PBARL,7,1,,HAT\n,.1,.1,.1,.1", "PBARL,7,1,,BAR\n,.1"),
        *("PBARL,7,1,,ROD\n,.1,3.", (BAR, ",0.,0.,1.\n,,,.1,0.,0.,.1,0.,0.")),
    ],
    "PBEAML": ["PBEAML,7,1,,ROD\n,.1,0.,YES,1.,.05"],
    "CBAR": [
        *((BAR, ",,,"), (BAR, ",0.,0.,1.,EGG"), (BAR, ",98"), (BAR, ",0.,0.,1.\n,5")),
        *((BAR, ",0.,0.,1.\n,,,0.,0.,.1"), (BAR, ",0.,0.,1.,GOO\n,,,0.,0.,.1,0.,0.,.1")),
    ],
}


@each("keyword, cards", [(name, one) for name, cards in KEYWORDS.items() for one in cards])
def test_a_keyword_is_refused(keyword: str, cards: str, tmp_path: Path) -> None:
    mesh, kind = (line(), "B31") if "*BEAM" in cards else (SHEET, "S4")
    path = abaqus(tmp_path / "a.inp", mesh, [cards], kind)
    with pytest.raises(ao.MeshError, match=rf"a\.inp', line \d+, \*{keyword}:"):
        ao.read_sections(path)


@pytest.mark.filterwarnings("ignore:.*have no E3")
@each(
    "entry, cards, mesh, after",
    [
        (name, *((one, mesh, after) if isinstance(one, str) else (one[0], mesh, one[1])))
        for of, mesh, after in ((ENTRIES, SHEET, ""), (BARS, line(), ",0.,0.,1."))
        for name, cards in of.items()
        for one in cards
    ],
)
def test_an_entry_is_refused(
    entry: str, cards: str, mesh: ao.Mesh, after: str, tmp_path: Path
) -> None:
    path = deck(tmp_path, mesh, cards, "CORD2C,5,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.", after=after)
    with pytest.raises(ao.MeshError, match=rf"a\.bdf', line \d+, {entry}:"):
        ao.read_sections(path)


def test_rods_alone_are_no_body(tmp_path: Path) -> None:
    with pytest.raises(ao.MeshError, match=r"a\.bdf"):
        ao.read_sections(deck(tmp_path, line(), "PROD,7,1,.1", after=",0.,0.,1."))


@each(
    "mesh, card, old, new, words",
    [
        (SHEET, "PSHELL,7,2,.001,2", "\nCQUAD4,4", ",20.\nCQUAD4,4", "PSHELL"),
        (SHEET, "PSHELL,7,2,.001,2", "\nCQUAD4,4", ",,.001\nCQUAD4,4", "ZOFFS"),
        (line(), BAR, ",0.,0.,1.", ",0.,1.,1.", "PBARL"),
    ],
)
def test_elements_of_one_property_agree(
    mesh: ao.Mesh, card: str, old: str, new: str, words: str, tmp_path: Path
) -> None:
    """Fibres by the first edges, offsets, and bars about their line."""
    path = deck(tmp_path, mesh, card, after=",0.,0.,1." if mesh.kind == "line" else "")
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(ao.MeshError, match=words):
        ao.read_sections(path)


def test_what_is_no_deck_has_no_sections(tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n0\n$EndNodes\n$Elements\n0\n$EndElements\n"
    )
    with pytest.raises(ao.MeshError, match="deck"):
        ao.read_sections(tmp_path / "a.msh")
    with pytest.raises(MissingFileError):
        ao.read_sections(tmp_path / "none.inp")
    with pytest.raises(ao.InputError, match="scale"):
        ao.read_sections(tmp_path / "a.msh", scale=0.0)


FOLDED = """*NODE
1, 0., 0., 0.
2, .1, 0., 0.
3, .1, .1, 0.
4, 0., .1, 0.
5, .2, 0., 0.
6, .2, .1, 0.
*ELEMENT, TYPE=S4, ELSET="a b"
1, 1, 2, 3, 4
2, 3, 6, 5, 2
*MATERIAL, NAME=PLY
*ELASTIC, TYPE=LAMINA
1E11, 1E10, .3, 5E9, 5E9, 4E9
*DENSITY
1600.
*SHELL SECTION, ELSET="a b", COMPOSITE
.001, 3, PLY, """


@pytest.mark.filterwarnings("ignore:.*have no E3")
def test_plies_of_one_side_are_refused_where_elements_are_turned_over(tmp_path: Path) -> None:
    """Angles about a normal that is turned round change their sign; 0 and 90° do not."""
    deck = tmp_path / "folded.inp"
    deck.write_text(FOLDED + "45.\n")
    with pytest.raises(ao.MeshError, match="a b"):
        ao.read_sections(deck)
    for text in (FOLDED + "90.\n", FOLDED.replace("3, 6, 5, 2", "2, 5, 6, 3") + "45.\n"):
        deck.write_text(text)
        assert list(ao.read_sections(deck)) == ["a b"]
