"""Cards that would change the answer and are not understood are refused, with file and line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from decks import MAT1, MAT8, PLY, STEEL, abaqus, line, nastran

import aoimpact as ao
from aoimpact.base import MissingFileError

SHEET = ao.sheet_mesh((0.2, 0.1), (4, 2))
SHELL = "*SHELL SECTION, ELSET=ALL, MATERIAL=STEEL\n.001\n"
PLIED = "*SHELL SECTION, ELSET=ALL, MATERIAL=PLY, ORIENTATION=O\n.001\n*ORIENTATION, NAME=O"
BEAM = "*BEAM SECTION, ELSET=ALL, MATERIAL=STEEL, SECTION="
GENERAL = "*BEAM GENERAL SECTION, ELSET=ALL, SECTION=GENERAL, DENSITY=7800.\n"


def made(*options: str) -> str:
    return "\n".join(["*MATERIAL, NAME=STEEL", *options, ""])


STEELS = {  # what is wrong with a material
    made("*DENSITY", "7800."): r"line 61\b",
    made("*ELASTIC", "2.1E11, .3"): r"line 61\b",
    STEEL.replace(", 0.3", ", 0.3, 20.\n2E11, 0.3, 200."): r"line 62\b",
    STEEL.replace("7800.", "7800., 20.\n7700., 200."): r"line 64\b",
    STEEL.replace("*ELASTIC", "*ELASTIC, DEPENDENCIES=1"): r"line 62\b",
    STEEL.replace("*ELASTIC", "*ELASTIC, TYPE=ANISOTROPIC"): r"line 62\b",
    STEEL.replace(", 0.3", ""): r"line 62\b",
    STEEL.replace("0.3", "0.6"): r"line 62\b",
    STEEL.replace("STEEL", "OTHER"): r"line 59\b",
    "": r"line 59\b",
}

SHELLS = {
    SHELL.replace("\n", ", NODAL THICKNESS\n", 1): r"line 59\b",
    SHELL.replace("\n", ", DENSITY=3.\n", 1): r"line 59\b",
    SHELL.replace("ALL", "NONE"): r"line 59\b",
    SHELL + SHELL.replace("ELSET=ALL, ", ""): r"line 61\b",
    SHELL.replace(".001\n", ""): r"line 59\b",
    SHELL.replace(".001", "-.001"): r"line 59\b",
    SHELL + SHELL: r"line 61\b",
    SHELL.replace("\n.001", ", COMPOSITE"): r"line 59\b",
    "*SHELL GENERAL SECTION, ELSET=ALL\n1E9, 0., 1E9": r"line 59\b",
    SHELL + "*TRANSVERSE SHEAR STIFFNESS\n1E6, 1E6, 0.": (r"line 61\b"),
    SHELL + "*NONSTRUCTURAL MASS, ELSET=ALL, UNITS=TOTAL MASS\n2.": (r"line 61\b"),
    PLIED + ", SYSTEM=CYLINDRICAL\n0,0,0, 0,0,1": r"line 61\b",
    PLIED + ", DEFINITION=NODES\n1, 2": r"line 61\b",
    PLIED + "\n1,0,0, 2,0,0": r"line 61\b",
    PLIED + "\n1,0,0, 0,1,0\n1, 0.": r"line 59\b",
    PLIED + "\n1,0,0, 0,1,0\n, 30.": r"line 59\b",
    PLIED + "\n1,0,0, 0,1,0\n4, 0.": r"line 61\b",
    PLIED.replace("NAME=O", "NAME=P") + "\n1,0,0, 0,1,0": r"line 59\b",
}

BEAMS = {
    BEAM + "ELBOW\n.1, .01, 1": r"line 28\b",
    BEAM + "BOX\n.1, .1, .06, .01, .06, .01": r"line 28\b",
    BEAM + "BOX\n.1, .1, .01, 0., .01, .01": r"line 28\b",
    BEAM + "HEX\n.1, 0.": r"line 28\b",
    BEAM + "ARBITRARY\n2, 0, 0, 1, 0, .1": r"line 28\b",
    BEAM + "RECT\n.01": r"line 28\b",
    BEAM + "RECT\n.01, .02\n5": r"line 28\b",
    BEAM + "RECT\n.01, .02\n1,0,0": r"line 28\b",
    BEAM + "RECT, OFFSET1=.5\n.01, .02": r"line 28\b",
    BEAM + "CIRC\n.01, .02": r"line 28\b",
    BEAM.replace("STEEL", "PLY") + "CIRC\n.01": r"line 28\b",
    GENERAL + "2E-4, 1E-9, 2E-9, 1E-9, 4E-9\n0,0,1\n2E11, 8E10": r"line 28\b",
    BEAM + "RECT\n.01, .02\n*NORMAL, TYPE=ELEMENT\n1, 1, 0., 1., 0.": (r"line 30\b"),
    BEAM + "RECT\n.01, .02\n*NODE\n99, 0., 5., 0., 0., 0., 1.": r"line 30\b",
    BEAM + "RECT\n.01, .02\n*CENTROID\n.01, 0.": r"line 30\b",
    BEAM + "RECT\n.01, .02\n*RELEASE\n1, S1, ALLM": r"line 30\b",
    BEAM + "RECT\n.01, .02\n*BEAM FLUID INERTIA\n1., 1.": r"line 30\b",
    BEAM + "RECT\n.01, .02\n*BEAM SECTION OFFSET\n.01, 0.": r"line 30\b",
    GENERAL + "2E-4, 1E-9, 0., 1E-9, 4E-9\n0,0,1": r"line 28\b",
}

SHELL_ENTRIES = {
    "PSHELL,7,1,,1": r"line 25\b",
    "PSHELL,7,1,.001": r"line 25\b",
    "PSHELL,7,1,.001,2": r"line 25\b",
    "PSHELL,7,1,.001,1,1.5": r"line 25\b",
    "PSHELL,7,1,.001,1,,1,.5": r"line 25\b",
    "PSHELL,7,1,.001,1,,2": r"line 25\b",
    "PSHELL,7,1,.001,1,,1,.833333,2.": "mesh",
    "PSHELL,7,1,.001,1\n,,,1": r"line 25\b",
    "PSHELL,7,9,.001,9": r"line 25\b",
    "PCOMP,7,,,,,,,MEM\n,2,.001,0.": r"line 25\b",
    "PCOMP,7,,2.\n,2,.001,0.": "mesh",
    "PCOMP,7\n,2,,0.": r"line 25\b",
    "PSHEAR,7,1,.001": r"line 25\b",
    "PBAR,7,1,1.,1.,1.,1.": r"line 17\b",
    "PSHELL,7,1,.001,1\nNSM1,3,PSHELL,2.,7": r"line 26\b",
    "PSHELL,8,1,.001,1": r"line 17\b",
    "PSHELL,7,1,.001,1\nPSHELL,7,1,.002,1": r"line 26\b",
}

FIELDS = {  # after the nodes of a quadrilateral
    ",,,\n,,,.002,.002,.002,.002": r"line 17\b",
    ",9": r"line 17\b",
    ",5": r"line 25\b",
}

BAR_ENTRIES = {
    "PBAR,7,1,1.E-4,1.E-9,1.E-9": r"line 23\b",
    "PBAR,7,1,1.E-4,1.E-9,1.E-9,1.E-9,2.": "mesh",
    "PBAR,7,1,1.E-4,1.E-9,1.E-9,1.E-9\n,\n,,,1.E-8": r"line 23\b",
    "PBAR,7,2,1.E-4,1.E-9,1.E-9,1.E-9": r"line 23\b",
    "PBEAM,7,1,1.E-4,1.E-9,1.E-9,,1.E-9\n,\n,YES,1.,2.E-4": r"line 23\b",
    "PBARL,7,1,,DBOX\n,.1,.1,.1,.1": r"line 23\b",
    "PBARL,7,1,,HAT\n,.1,.1,.1,.1": r"line 23\b",
    "PBARL,7,1,,BAR\n,.1": r"line 23\b",
    "PBARL,7,1,,ROD\n,.1,3.": r"line 23\b",
    "PBEAML,7,1,,ROD\n,.1,0.,YES,1.,.05": r"line 23\b",
    "PROD,7,1,.1": "mesh",
}

AFTER_BARS = {
    ",,,": r"line 13\b",
    ",0.,0.,1.,EGG": r"line 13\b",
    ",98": r"line 13\b",
    ",0.,0.,1.\n,5": r"line 13\b",
    ",0.,0.,1.\n,,,0.,0.,.1": r"line 13\b",
    ",0.,0.,1.,GOO\n,,,0.,0.,.1,0.,0.,.1": r"line 13\b",
    ",0.,0.,1.\n,,,.1,0.,0.,.1,0.,0.": r"line 33\b",
}

MATERIALS = {
    MAT1.replace("7800.", ""): r"line 26\b",
    MAT1.replace(".3", ""): r"line 26\b",
    MAT1.replace(",.3", "0.,"): r"line 26\b",
    MAT1.replace(",,", ",2.1E11,"): r"line 26\b",
    MAT1 + "\nMATT1,1,3": r"line 26\b",
}


@pytest.mark.parametrize(
    ("cards", "said"),
    [
        *((SHELL + cards, said) for cards, said in STEELS.items()),
        *((cards + "\n" + STEEL + PLY, said) for cards, said in SHELLS.items()),
        *((cards + "\n" + STEEL + PLY, said) for cards, said in BEAMS.items()),
    ],
)
def test_a_keyword_is_refused(cards: str, said: str, tmp_path: Path) -> None:
    beam = "*BEAM" in cards
    path = abaqus(tmp_path / "a.inp", line() if beam else SHEET, [cards], "B31" if beam else "S4")
    with pytest.raises(ao.MeshError, match=said):
        ao.read_sections(path)


@pytest.mark.filterwarnings("ignore:.*(have no E3|carries no bending)")
@pytest.mark.parametrize(
    ("card", "material", "after", "said"),
    [
        *((card, MAT1, "", said) for card, said in SHELL_ENTRIES.items()),
        *(("PSHELL,7,2,.001,2", MAT1, after, said) for after, said in FIELDS.items()),
        *((card, MAT1, ",0.,0.,1.", said) for card, said in BAR_ENTRIES.items()),
        *(("PBARL,7,1,,BAR\n,.1,.2", MAT1, after, said) for after, said in AFTER_BARS.items()),
        *(("PSHELL,7,1,.001,1", material, "", said) for material, said in MATERIALS.items()),
    ],
)
def test_an_entry_is_refused(
    card: str, material: str, after: str, said: str, tmp_path: Path
) -> None:
    bars = re.match("PBARL|PBEAM|PBAR,7,[12],1.E-4|PROD", card) is not None
    cards = [card, material, MAT8, "CORD2C,5,,0.,0.,0.,0.,0.,1.\n,1.,0.,0."]
    path = nastran(tmp_path / "a.bdf", line() if bars else SHEET, cards, after)
    with pytest.raises(ao.MeshError, match=said):
        ao.read_sections(path)


def test_elements_of_one_property_agree(tmp_path: Path) -> None:
    """Fibres by the first edges of a sheet that is folded; offsets, and bars about a ring."""
    path = nastran(tmp_path / "a.bdf", SHEET, ["PSHELL,7,2,.001,2", MAT8])
    text = path.read_text()
    path.write_text(text.replace("\nCQUAD4,4", ",20.\nCQUAD4,4"))
    with pytest.raises(ao.MeshError, match=r"line 25\b"):
        ao.read_sections(path)
    path.write_text(text.replace("\nCQUAD4,4", ",,.001\nCQUAD4,4"))
    with pytest.raises(ao.MeshError, match=r"line 25\b"):
        ao.read_sections(path)
    path = nastran(tmp_path / "b.bdf", line(), ["PBARL,7,1,,BAR\n,.1,.2", MAT1], ",0.,0.,1.")
    path.write_text(path.read_text().replace("0.,0.,1.", "0.,1.,1.", 1))
    with pytest.raises(ao.MeshError, match=r"line 23\b"):
        ao.read_sections(path)


def test_what_is_no_deck_has_no_sections(tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n0\n$EndNodes\n$Elements\n0\n$EndElements\n"
    )
    with pytest.raises(ao.MeshError, match=r"^mesh"):
        ao.read_sections(tmp_path / "a.msh")
    with pytest.raises(MissingFileError):
        ao.read_sections(tmp_path / "none.inp")
    with pytest.raises(ao.InputError, match=r"^scale"):
        ao.read_sections(tmp_path / "a.msh", scale=0.0)
