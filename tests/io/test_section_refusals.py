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
    made("*DENSITY", "7800."): r"\*MATERIAL: STEEL has no \*ELASTIC",
    made("*ELASTIC", "2.1E11, .3"): r"\*MATERIAL: STEEL has no \*DENSITY.*given=\{'STEEL'",
    STEEL.replace(", 0.3", ", 0.3, 20.\n2E11, 0.3, 200."): r"\*ELASTIC: it depends on temperature",
    STEEL.replace("7800.", "7800., 20.\n7700., 200."): r"\*DENSITY: it depends on temperature",
    STEEL.replace("*ELASTIC", "*ELASTIC, DEPENDENCIES=1"): "DEPENDENCIES is not supported",
    STEEL.replace("*ELASTIC", "*ELASTIC, TYPE=ANISOTROPIC"): "TYPE=ANISOTROPIC is none of ISO",
    STEEL.replace(", 0.3", ""): "it has 1 of its 2 constants",
    STEEL.replace("0.3", "0.6"): r"\*ELASTIC: nu must lie between",
    STEEL.replace("STEEL", "OTHER"): r"\*SHELLSECTION: there is no \*MATERIAL 'STEEL'",
    "": r"\*SHELLSECTION: there is no \*MATERIAL 'STEEL'",
}

SHELLS = {
    SHELL.replace("\n", ", NODAL THICKNESS\n", 1): "NODALTHICKNESS is not supported",
    SHELL.replace("\n", ", DENSITY=3.\n", 1): "the option DENSITY is not supported",
    SHELL.replace("ALL", "NONE"): "there is no ELSET 'NONE'",
    SHELL + SHELL.replace("ELSET=ALL, ", ""): "there is no ELSET ''",
    SHELL.replace(".001\n", ""): "give MATERIAL=, and its thickness in one line",
    SHELL.replace(".001", "-.001"): "thickness must be positive",
    SHELL + SHELL: "ALL has another section",
    SHELL.replace("\n.001", ", COMPOSITE"): "it has no plies",
    "*SHELL GENERAL SECTION, ELSET=ALL\n1E9, 0., 1E9": "give MATERIAL=",
    SHELL + "*TRANSVERSE SHEAR STIFFNESS\n1E6, 1E6, 0.": (
        r"\*TRANSVERSESHEARSTIFFNESS: it is not supported; .*section of ALL.*given="
    ),
    SHELL + "*NONSTRUCTURAL MASS, ELSET=ALL, UNITS=TOTAL MASS\n2.": (
        r"\*NONSTRUCTURALMASS: it is not supported; .*section of ALL.*given="
    ),
    PLIED + ", SYSTEM=CYLINDRICAL\n0,0,0, 0,0,1": r"\*ORIENTATION: only rectangular axes",
    PLIED + ", DEFINITION=NODES\n1, 2": r"\*ORIENTATION: only rectangular axes by coordinates",
    PLIED + "\n1,0,0, 2,0,0": r"\*ORIENTATION: its points are on one line",
    PLIED + "\n1,0,0, 0,1,0\n1, 0.": "axis 1 of the orientation O lies in some elements",
    PLIED + "\n1,0,0, 0,1,0\n, 30.": "axis 1 of the orientation O lies in some elements",
    PLIED + "\n1,0,0, 0,1,0\n4, 0.": "the axis of rotation must be 1, 2 or 3, got 4",
    PLIED.replace("NAME=O", "NAME=P") + "\n1,0,0, 0,1,0": r"there is no \*ORIENTATION 'O'",
}

BEAMS = {
    BEAM + "ELBOW\n.1, .01, 1": "'ELBOW' is none of .*; give its Beam",
    BEAM + "BOX\n.1, .1, .06, .01, .06, .01": "walls are thicker",
    BEAM + "BOX\n.1, .1, .01, 0., .01, .01": "walls are thicker .* or 0",
    BEAM + "HEX\n.1, 0.": "walls are thicker .* or 0",
    BEAM + "ARBITRARY\n2, 0, 0, 1, 0, .1": "give 9 numbers",
    BEAM + "RECT\n.01": "give 2 numbers of the section",
    BEAM + "RECT\n.01, .02\n5": "all three of axis 1",
    BEAM + "RECT\n.01, .02\n1,0,0": "is along some of its elements",
    BEAM + "RECT, OFFSET1=.5\n.01, .02": "OFFSET1 is not supported",
    BEAM + "CIRC\n.01, .02": "ellipses are not supported",
    BEAM.replace("STEEL", "PLY") + "CIRC\n.01": "material must be of type Material, got Orth",
    GENERAL + "2E-4, 1E-9, 2E-9, 1E-9, 4E-9\n0,0,1\n2E11, 8E10": "must be positive",
    BEAM + "RECT\n.01, .02\n*NORMAL, TYPE=ELEMENT\n1, 1, 0., 1., 0.": (
        r"\*NORMAL: normals would turn the beams of ALL; write axis 1 in \*BEAMSECTION"
    ),
    BEAM + "RECT\n.01, .02\n*NODE\n99, 0., 5., 0., 0., 0., 1.": r"\*NODE: normals would turn",
    BEAM + "RECT\n.01, .02\n*CENTROID\n.01, 0.": r"\*CENTROID: it is not supported",
    BEAM + "RECT\n.01, .02\n*RELEASE\n1, S1, ALLM": r"\*RELEASE: hinges are not supported",
    BEAM + "RECT\n.01, .02\n*BEAM FLUID INERTIA\n1., 1.": r"\*BEAMFLUIDINERTIA: it is not supp",
    BEAM + "RECT\n.01, .02\n*BEAM SECTION OFFSET\n.01, 0.": r"\*BEAMSECTIONOFFSET: it is not",
    GENERAL + "2E-4, 1E-9, 0., 1E-9, 4E-9\n0,0,1": "or E and G in its third line",
}

SHELL_ENTRIES = {
    "PSHELL,7,1,,1": "PSHELL: T is blank",
    "PSHELL,7,1,.001": r"MID2='' of bending must be MID1=1",
    "PSHELL,7,1,.001,2": r"MID2='2' of bending must be MID1=1",
    "PSHELL,7,1,.001,1,1.5": r"12I/T\*\*3=1.5 is not supported",
    "PSHELL,7,1,.001,1,,1,.5": r"TS/T=0.5 is not supported",
    "PSHELL,7,1,.001,1,,2": "MID3=2 is not supported",
    "PSHELL,7,1,.001,1,,1,.833333,2.": "NSM=2 is not supported",
    "PSHELL,7,1,.001,1\n,,,1": "MID4=1 is not supported",
    "PSHELL,7,9,.001,9": "material '9' is none of MAT1, MAT8, MAT11",
    "PCOMP,7,,,,,,,MEM\n,2,.001,0.": "LAM=MEM is not supported",
    "PCOMP,7,,2.\n,2,.001,0.": "NSM=2 is not supported",
    "PCOMP,7\n,2,,0.": "T1 is blank",
    "PSHEAR,7,1,.001": "PSHEAR: it is not read; give read_sections",
    "PBAR,7,1,1.,1.,1.,1.": "of elements of another kind",
    "PSHELL,7,1,.001,1\nNSM1,3,PSHELL,2.,7": "NSM1: its mass is not supported; delete it",
    "PSHELL,8,1,.001,1": "CQUAD4: its property 7 is not there",
    "PSHELL,7,1,.001,1\nPSHELL,7,1,.002,1": "another entry has it",
}

FIELDS = {  # after the nodes of a quadrilateral
    ",,,\n,,,.002,.002,.002,.002": "CQUAD4: thickness at the nodes is not supported",
    ",9": "coordinate system 9 is not defined",
    ",5": "PSHELL: system 5 is not rectangular",
}

BAR_ENTRIES = {
    "PBAR,7,1,1.E-4,1.E-9,1.E-9": "PBAR: J is blank",
    "PBAR,7,1,1.E-4,1.E-9,1.E-9,1.E-9,2.": "NSM=2 is not supported",
    "PBAR,7,1,1.E-4,1.E-9,1.E-9,1.E-9\n,\n,,,1.E-8": "must be positive",
    "PBAR,7,2,1.E-4,1.E-9,1.E-9,1.E-9": "material must be of type Material, got Orthotropic",
    "PBEAM,7,1,1.E-4,1.E-9,1.E-9,,1.E-9\n,\n,YES,1.,2.E-4": "along the beam=0.0002 is not supp",
    "PBARL,7,1,,DBOX\n,.1,.1,.1,.1": "'DBOX' is none of",
    "PBARL,7,1,,HAT\n,.1,.1,.1,.1": "walls are thicker",
    "PBARL,7,1,,BAR\n,.1": "DIM2 is blank",
    "PBARL,7,1,,ROD\n,.1,3.": "NSM=3 is not supported",
    "PBEAML,7,1,,ROD\n,.1,0.,YES,1.,.05": "it has fields after its first cross-section",
    "PROD,7,1,.1": "has no sections of solids, shells or beams; PROD, which carries no bending",
}

AFTER_BARS = {
    ",,,": "CBAR: it has no orientation",
    ",0.,0.,1.,EGG": "OFFT must begin with G or B",
    ",98": "CBAR: its node G0 is not there",
    ",0.,0.,1.\n,5": "hinges PA, PB are not supported",
    ",0.,0.,1.\n,,,0.,0.,.1": "CBAR: its offsets WA and WB differ",
    ",0.,0.,1.,GOO\n,,,0.,0.,.1,0.,0.,.1": "CBAR: its offsets need CD = 0",
    ",0.,0.,1.\n,,,.1,0.,0.,.1,0.,0.": "PBARL: its elements are moved along themselves",
}

MATERIALS = {
    MAT1.replace("7800.", ""): r"MAT1: RHO is 0 or blank.*'material 1'",
    MAT1.replace(".3", ""): "MAT1: write two of E, G and NU",
    MAT1.replace(",.3", "0.,"): "MAT1: write two of E, G and NU",
    MAT1.replace(",,", ",2.1E11,"): r"G=2.1e\+11 is not E/",
    MAT1 + "\nMATT1,1,3": "MAT1: it depends on temperature by MATT1",
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
    with pytest.raises(ao.MeshError, match=rf"a\.inp', line \d+, .*{said}"):
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
    with pytest.raises(ao.MeshError, match=rf"a\.bdf'(, line \d+,)? .*{said}"):
        ao.read_sections(path)


def test_elements_of_one_property_agree(tmp_path: Path) -> None:
    """Fibres by the first edges of a sheet that is folded; offsets, and bars about a ring."""
    path = nastran(tmp_path / "a.bdf", SHEET, ["PSHELL,7,2,.001,2", MAT8])
    text = path.read_text()
    path.write_text(text.replace("\nCQUAD4,4", ",20.\nCQUAD4,4"))
    with pytest.raises(ao.MeshError, match="PSHELL: its elements have axes in several directions"):
        ao.read_sections(path)
    path.write_text(text.replace("\nCQUAD4,4", ",,.001\nCQUAD4,4"))
    with pytest.raises(ao.MeshError, match="PSHELL: ZOFFS of its elements differs"):
        ao.read_sections(path)
    path = nastran(tmp_path / "b.bdf", line(), ["PBARL,7,1,,BAR\n,.1,.2", MAT1], ",0.,0.,1.")
    path.write_text(path.read_text().replace("0.,0.,1.", "0.,1.,1.", 1))
    with pytest.raises(ao.MeshError, match="PBARL: its elements have axes in several directions"):
        ao.read_sections(path)


def test_what_is_no_deck_has_no_sections(tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n0\n$EndNodes\n$Elements\n0\n$EndElements\n"
    )
    with pytest.raises(ao.MeshError, match="is no deck of Abaqus, CalculiX or Nastran"):
        ao.read_sections(tmp_path / "a.msh")
    with pytest.raises(MissingFileError):
        ao.read_sections(tmp_path / "none.inp")
    with pytest.raises(ao.InputError, match="scale must be"):
        ao.read_sections(tmp_path / "a.msh", scale=0.0)
