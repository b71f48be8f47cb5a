"""CalculiX itself and we read the same deck: its sections as solids, and frequencies."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from decks import STEEL, ccx, frequencies, strip

import aoimpact as ao

pytestmark = [
    pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed"),
    pytest.mark.filterwarnings("ignore:.*surface elements have normals"),
]

WOOD = """*MATERIAL, NAME=WOOD
*ELASTIC, TYPE=ENGINEERING CONSTANTS
12E9, 1E9, .6E9, .4, .5, .3, .8E9, .7E9,
.05E9
*DENSITY
500.
"""


def deck(path: Path, nodes: Any, blocks: dict[str, Any], fixed: Any, cards: str, step: str) -> Path:
    """Write and run a deck of elements of second order, by "type, ELSET=name"."""
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{i + 1}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(nodes)]
    count = 0
    for head, cells in blocks.items():
        lines.append(f"*ELEMENT, TYPE={head}")
        for cell in cells:
            count += 1
            lines.append(", ".join(map(str, [count, *(np.array(cell) + 1)])))
    lines += ["*BOUNDARY", *(f"{i + 1}, 1, 6" for i in fixed), cards.strip(), step, "*END STEP", ""]
    return ccx(path, lines)


def extent(path: Path, of: slice) -> Any:
    """The least and largest coordinates of the solids that CalculiX makes of sections."""
    found = []
    for row in path.with_suffix(".frd").read_text().split("\n -3")[0].split("\n"):
        if row.startswith(" -1"):
            found.append([float(row[13 + 12 * k : 25 + 12 * k]) for k in range(3)])
    places = np.array(found)
    own = places[(places[:, 0] >= of.start) & (places[:, 0] <= of.stop)]
    return own.min(axis=0), own.max(axis=0)


@pytest.mark.parametrize("offset", ["0.", "0.5", "-0.5", "0.3", "-0.2"])
def test_faces_and_sides_are_where_calculix_has_them(offset: str, tmp_path: Path) -> None:
    """Of a shell with an offset, and of a beam of 20 mm along its axis 1."""
    nodes, cells = strip(1, 1, lambda x, y: (x, y, 0 * x))
    nodes = np.vstack([nodes, [(x, 0, 0) for x in (5, 5.5, 6)]])
    cards = f"{STEEL}*SHELL SECTION, ELSET=A, MATERIAL=STEEL, OFFSET={offset}\n.1\n"
    cards += "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=RECT\n.02, .04\n0, .6, .8\n"
    blocks = {"S8R, ELSET=A": cells, "B32R, ELSET=B": [[8, 9, 10]]}
    step = "*STEP\n*STATIC\n*CLOAD\n3, 3, 1.\n11, 3, 1.\n*NODE FILE, OUTPUT=3D\nU"
    path = deck(tmp_path / "a.inp", nodes, blocks, [0, 1, 8], cards, step)
    sections: Any = ao.read_sections(path)
    low, high = extent(path, slice(0, 2))
    assert sections["A"].interfaces == pytest.approx([low[2], high[2]], abs=1e-6)
    low, high = extent(path, slice(4.9, 7))
    z = np.array(sections["B"].orientation)
    y = np.cross(z, [1.0, 0.0, 0.0])
    corners = [a * y + b * z for a, b in sections["B"].numbers.points]
    assert np.max(corners, axis=0)[1:] == pytest.approx(high[1:], rel=1e-4)


STEP = "*STEP\n*FREQUENCY\n8"


def compared(path: Path, fixed: Any, n: int = 8) -> tuple[Any, Any]:
    sections = ao.read_sections(path)
    mesh = ao.read_mesh(path, part=list(sections))
    body = ao.FEModel.from_mesh(mesh, sections, fixed=[(fixed + 1, "xyz", "xyz")])
    return body.frequencies(n), frequencies(path)[:n]


PLIES = "*SHELL SECTION, ELSET=A, COMPOSITE\n.001,, WOOD, O30\n.002,, STEEL,\n.001,, WOOD, O90\n"
PLIES += "*ORIENTATION, NAME=O30\n.8660254, .5, 0, -.5, .8660254, 0\n"
PLIES += "*ORIENTATION, NAME=O90\n0, 1, 0, -1, 0, 0\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    "cards",
    [
        "*SHELL SECTION, ELSET=A, MATERIAL=STEEL\n.004",
        "*SHELL SECTION, ELSET=A, MATERIAL=WOOD, ORIENTATION=O\n.004\n"
        "*ORIENTATION, NAME=O\n.8660254, .5, 0, -.5, .8660254, 0",
        PLIES,
    ],
)
def test_a_plate_has_calculix_s_frequencies(cards: str, tmp_path: Path) -> None:
    """Clamped at one edge; the fibres are turned, so that bending and twist are coupled."""
    nodes, cells = strip(18, 12, lambda x, y: (0.3 * x, 0.2 * y, 0 * x))
    fixed = np.flatnonzero(nodes[:, 0] == 0)
    path = deck(
        tmp_path / "a.inp", nodes, {"S8R, ELSET=A": cells}, fixed, STEEL + WOOD + cards, STEP
    )
    ours, theirs = compared(path, fixed)
    assert ours == pytest.approx(theirs, rel=0.01)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:the shells. offset is on a curved or folded")
def test_the_sides_of_an_angle_s_offsets_are_calculix_s(tmp_path: Path) -> None:
    """An angle of two strips; with material outside of the nodes it is stiffer than inside."""
    found = {}
    for offset in ("0.5", "-0.5"):
        nodes, cells = strip(
            16,
            4,
            lambda x, s: (
                0.4 * x,
                0.04 * np.maximum(2 * s - 1, 0),
                0.04 * np.maximum(1 - 2 * s, 0),
            ),
        )
        fixed = np.flatnonzero(nodes[:, 0] == 0)
        cards = f"{STEEL}*SHELL SECTION, ELSET=A, MATERIAL=STEEL, OFFSET={offset}\n.003\n"
        path = deck(tmp_path / f"a{offset}.inp", nodes, {"S8R, ELSET=A": cells}, fixed, cards, STEP)
        found[offset] = compared(path, fixed, 2)
    ours, theirs = (np.divide(found["0.5"][i], found["-0.5"][i]) for i in (0, 1))
    assert ours == pytest.approx(theirs, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("card", "within"),
    [
        ("RECT\n.01, .025", 0.006),
        ("CIRC\n.01, .01", 0.012),
        ("CIRC\n.01", 0.012),
        ("PIPE\n.015, .002", 0.022),
    ],
)
def test_a_beam_has_calculix_s_frequencies(card: str, within: float, tmp_path: Path) -> None:
    """A cantilever along a skew line: six frequencies of bending about both axes.

    CalculiX' own frequencies in the two planes of a pipe are up to 2.5 % apart.
    """
    n = 40
    nodes = np.outer(np.linspace(0, 0.6, 2 * n + 1), [0.6, -0.64, 0.48])
    cells = [[i, i + 1, i + 2] for i in range(0, 2 * n, 2)]
    cards = f"{STEEL}*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION={card}\n0, .6, .8\n"
    path = deck(tmp_path / "a.inp", nodes, {"B32R, ELSET=B": cells}, [0], cards, STEP)
    ours, theirs = compared(path, np.array([0]), 6)
    assert ours == pytest.approx(theirs, rel=within)
