"""Cross-sections by their dimensions: area, second moments, torsion and offset from a raster.

The raster takes what the figures in Abaqus' beam cross-section library and in Nastran's Quick
Reference Guide (PBARL) show, as inequalities in mm: h to the right, v upwards.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.ndimage
import scipy.sparse as sp
import scipy.sparse.linalg
from decks import deck
from rows import each
from thinmeshes import line

import aoimpact as ao

pytestmark = pytest.mark.filterwarnings("ignore:.*at the centroid")

CELL = 0.1  # mm; 0.05 as well for torsion


def hexagon(h: Any, v: Any) -> Any:
    """A ring 1 mm thick within a hexagon of 6 mm sides with a corner to the right."""
    apothem = np.maximum(abs(v - 6), 0.75**0.5 * abs(h - 6) + 0.5 * abs(v - 6))
    return (apothem < 6 * 0.75**0.5) & (apothem > 6 * 0.75**0.5 - 1)


def angle(h: Any, v: Any) -> Any:
    return (h < 0.8) | (v < 1)


def box(h: Any, v: Any) -> Any:
    return (h < 0.6) | (h > 9.2) | (v < 0.5) | (v > 7)


def tee(h: Any, v: Any) -> Any:
    return (v > 8) | (abs(h - 4) < 0.4)


def flanged(h: Any, v: Any) -> Any:
    return (v < 1.2) | (abs(h - 4.5) < 0.5) | (v > 9.2) & (abs(h - 4.5) < 3.5)


def hat(h: Any, v: Any) -> Any:
    webs = abs(abs(h - 8) - 3.5) < 0.5
    return (v < 1) & (abs(h - 8) > 3) | webs | (v > 6) & (abs(h - 8) < 4)


def based(h: Any, v: Any) -> Any:
    """A hat 0.5 mm thick on a base."""
    webs = abs(abs(h - 8) - 3.75) < 0.25
    return (v < 0.5) | (v < 1) & (abs(h - 8) > 3.5) | webs | (v > 7.5) & (abs(h - 8) < 4)


# Dimensions, sides of the figure, and what is within the section.
NASTRAN: dict[str, tuple[tuple[float, ...], tuple[float, float], Any]] = {
    "BOX": ((10, 8, 1, 0.8), (10, 8), lambda h, v: (abs(h - 5) > 4.2) | (abs(v - 4) > 3)),
    "BOX1": ((10, 8, 1, 0.5, 0.8, 0.6), (10, 8), box),
    "CHAN": ((6, 9, 0.8, 1), (6, 9), lambda h, v: (h < 0.8) | (abs(v - 4.5) > 3.5)),
    "CHAN1": ((5, 1, 7, 9), (6, 9), lambda h, v: (h < 1) | (abs(v - 4.5) > 3.5)),
    "CHAN2": ((1, 0.8, 6, 9), (9, 6), lambda h, v: (v < 0.8) | (abs(h - 4.5) > 3.5)),
    "CROSS": ((8, 1, 10, 0.8), (9, 10), lambda h, v: (abs(h - 4.5) < 0.5) | (abs(v - 5) < 0.4)),
    "H": ((6, 2, 10, 0.8), (8, 10), lambda h, v: (abs(h - 4) > 3) | (abs(v - 5) < 0.4)),
    "HAT": ((7, 1, 8, 4), (16, 7), hat),
    "HAT1": ((16, 8, 8, 0.5, 0.5), (16, 8), based),
    "HEXA": ((3, 12, 8), (12, 8), lambda h, v: abs(h - 6) < 6 - 3 * abs(v - 4) / 4),
    "I": ((10, 9, 7, 1, 1.2, 0.8), (9, 10), flanged),
    "I1": ((6, 1, 8, 10), (7, 10), lambda h, v: (abs(v - 5) > 4) | (abs(h - 3.5) < 0.5)),
    "L": ((7, 9, 1, 0.8), (7, 9), angle),
    "T": ((8, 9, 1, 0.8), (8, 9), tee),
    "T1": ((8, 7, 1, 0.8), (8, 8), lambda h, v: (h > 7) | (abs(v - 4) < 0.4)),
    "T2": ((8, 9, 1, 0.8), (8, 9), lambda h, v: tee(h, 9 - v)),
    "Z": (
        (4, 1, 8, 10),
        (9, 10),
        lambda h, v: (abs(h - 4.5) < 0.5) | (v < 1) & (h > 4) | (v > 9) & (h < 5),
    ),
}
# The first line, sides of the figure, where the nodes are in it, and what is within the section.
ABAQUS: dict[str, tuple[str, tuple[float, float], tuple[float, float], Any]] = {
    "BOX": (".010, .008, .0008, .001, .0006, .0005", (10, 8), (5, 4), box),
    "I": (".003, .010, .009, .007, .0012, .0008, .001", (9, 10), (4.5, 3), flanged),
    "I, TEMPERATURE=VALUES": ("0, .009, 0, .008, 0, .001, .0008", (8, 9), (4, 0), tee),
    "L": (".007, .009, .001, .0008", (7, 9), (0.4, 0.5), angle),
    "ARBITRARY": ("2, .0066, 0, 0, 0, .001\n0, .0085, .0008", (7, 9), (0.4, 0.5), angle),
    "HEX": (".006, .001", (12, 12), (6, 6), hexagon),
    "TRAPEZOID": (
        ".012, .008, .006, .002",
        (12, 8),
        (6, 2),
        lambda h, v: abs(h - 6) < 6 - 3 * v / 8,
    ),
}


def raster(sides: tuple[float, float], within: Any, cell: float = CELL) -> tuple[Any, Any]:
    """Places within, m, shape (2, n), and which cells these are the middles of."""
    h, v = np.meshgrid(*(np.arange(0.5 * cell, side, cell) for side in sides), indexing="ij")
    cells = within(h, v)
    return 1e-3 * np.array([h[cells], v[cells]]), cells


def moments(places: Any) -> tuple[float, Any, Any]:
    """Area, centroid, and ∫r rᵀ dA about it, in SI, by cells."""
    one = (1e-3 * CELL) ** 2
    centre = places.mean(axis=1)
    r = places - centre[:, None]
    return r[0].size * one, centre, one * (r @ r.T) + np.eye(2) * r[0].size * one**2 / 12


def membrane(cells: Any, filled: Any, cell: float) -> float:
    """Saint-Venant's torsion constant by differences: 2∫φ with ∇²φ = -2, and 0 on the rim.

    In a hole φ is one number, and ∮∂φ/∂n about it twice its area: a flat lid on the membrane.
    """
    number = np.where(cells, np.cumsum(cells).reshape(cells.shape), cells.sum() + 1)
    number = np.pad(np.where(filled, number, 0), 1)
    own = number[1:-1, 1:-1][filled]
    rows, columns, diagonal = [], [], np.zeros(len(own))
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        beside = np.roll(number, step, axis)[1:-1, 1:-1][filled]
        diagonal += np.where(beside > 0, 1.0, 2.0)
        rows.append(own[beside > 0])
        columns.append(beside[beside > 0])
    ij = np.concatenate([*rows, own]) - 1, np.concatenate([*columns, own]) - 1
    values = np.concatenate([np.full(len(ij[0]) - len(own), -1.0), diagonal])
    load = np.bincount(own - 1).astype(float)
    phi = scipy.sparse.linalg.spsolve(sp.coo_array((values, ij)).tocsc(), 2.0 * load)
    return 2.0 * float(load @ phi) * (1e-3 * cell) ** 4


@cache
def twisted(sides: Any, within: Any) -> float:
    """The torsion constant in the limit of small cells, of the first order about a lid."""
    found = []
    for cell in (CELL, 0.5 * CELL):
        _, cells = raster(sides, within, cell)
        filled = scipy.ndimage.binary_fill_holes(cells)
        found.append(membrane(cells, filled, cell))
    factor = 2.0 if (filled & ~cells).any() else 4.0
    return (factor * found[1] - found[0]) / (factor - 1.0)


def frame(beam: ao.Beam) -> Any:
    """The section's y and z in rows, in the body's axes, of a beam along x."""
    z = np.array(beam.orientation) * [0, 1, 1]
    z /= np.linalg.norm(z)
    return np.array([np.cross(z, [1, 0, 0]), z])


def compared(path: Path, axes: Any, sides: Any, within: Any, rel: float) -> tuple[Any, Any]:
    """Compare a beam with the raster; `axes` are those of the figure in rows."""
    (beam,) = ao.read_sections(path).values()
    area, centre, second = moments(raster(sides, within)[0])
    section, own = beam.section, frame(beam) @ np.transpose(axes)
    assert pytest.approx(area, rel=rel) == section.area
    found = own.T @ np.diag([section.Iz, section.Iy]) @ own
    assert found == pytest.approx(second, rel=rel, abs=rel * np.trace(second))
    body = ao.FEModel.from_mesh(
        path, {"property 7": beam} if path.suffix == ".bdf" else {"ALL": beam}
    )
    assert body.mass == pytest.approx(7800 * area, rel=rel)
    arbitrary = "ARBITRARY" in path.read_text()  # has thin walls: right to the order t/b
    assert pytest.approx(twisted(sides, within), rel=0.04 if arbitrary else 3e-3) == section.J
    return beam, (np.array(beam.offset) @ own, centre)


@each("entry, name", [*(("PBARL", name) for name in NASTRAN), ("PBEAML", "T"), ("PBEAML", "BOX")])
def test_bars_of_nastran_s_shapes(name: str, entry: str, tmp_path: Path) -> None:
    """Plane 1 holds v: its y is along (0, 3, 4), and z along x × y."""
    dims, sides, within = NASTRAN[name]
    card = f"{entry},7,1,,{name}\n," + ",".join(f"{float(of)}-3" for of in dims)
    path = deck(tmp_path, line(), card, after=",0.,3.,4.")
    if entry == "PBEAML":
        path.write_text(path.read_text().replace("CBAR", "CBEAM"))
    compared(path, [[0, -0.8, 0.6], [0, 0.6, 0.8]], sides, within, 1e-3 if name == "HEXA" else 1e-9)


@each("name", ABAQUS)
@each("keyword", ["BEAM SECTION", "BEAM GENERAL SECTION"])
def test_beams_of_abaqus_shapes(name: str, keyword: str, tmp_path: Path) -> None:
    """Axis 1, along (0, 0.6, 0.8), holds h; axis 2 is x × axis 1. Nodes are as in the figure."""
    numbers, sides, node, within = ABAQUS[name]
    card = f"*{keyword}, ELSET=ALL, MATERIAL=STEEL, SECTION={name}\n{numbers}\n0, .6, .8"
    path = deck(tmp_path, line(), card)
    rel = {"HEX": 0.02, "TRAPEZOID": 2e-3}.get(name, 1e-9)
    if name == "ARBITRARY":  # corners are cut off, and overlap
        rel = 0.01
    _, (offset, centre) = compared(path, [[0, 0.6, 0.8], [0, -0.8, 0.6]], sides, within, rel)
    assert offset == pytest.approx(centre - 1e-3 * np.array(node), abs=2e-5)


@each(
    "numbers, exact",
    [
        (".02, .0173205080757, 0., .002", 3**0.5 / 80 * 0.02**4),
        (".01, .01, .01, .002", 0.1405770 * 0.01**4),
        (".01, .05, .01, .002", 0.2913194 * 0.01**3 * 0.05),
        (".01, 1., .01, .002", 0.01**3 * 1 / 3 * (1 - 0.6302487 * 0.01)),
    ],
)
def test_the_torsion_of_triangles_and_rectangles(
    numbers: str, exact: float, tmp_path: Path
) -> None:
    """S. P. Timoshenko and J. N. Goodier, Theory of Elasticity, sections 105 and 109."""
    card = f"*BEAM SECTION, ELSET=ALL, MATERIAL=STEEL, SECTION=TRAPEZOID\n{numbers}"
    path = deck(tmp_path, line(), card)
    (beam,) = ao.read_sections(path).values()
    torsion = beam.section.J
    assert torsion == pytest.approx(exact, rel=1e-4)
