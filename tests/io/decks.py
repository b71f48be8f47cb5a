"""Decks of this project's own: strips of shells and beams, and their cards."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

import aoimpact as ao

ELASTIC = "*MATERIAL, NAME=STEEL\n*ELASTIC\n{E}, 0.3\n*DENSITY\n{rho}\n".format
STEEL = ELASTIC(E=2.1e11, rho=7800.0)
PLY = (
    "*MATERIAL, NAME=PLY\n*ELASTIC, TYPE=LAMINA\n135E9, 9E9, .3, 5E9, 5E9, 3.2E9\n*DENSITY\n1550.\n"
)
MAT1 = "MAT1,1,2.1E11,,.3,7800."
MAT8 = "MAT8,2,135.E9,9.E9,.3,5.E9,5.E9,3.2E9,1550."

# The same as `PLY` and `MAT8`: isotropic across the fibres.
CARBON = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 9 / 6.4 - 1), rho=1550)


def abaqus(
    path: Path,
    mesh: Any,
    cards: Iterable[str],
    kind: str = "S4",
    scale: float = 1.0,
    turn: Any = None,
) -> Path:
    """Write a mesh as the ELSET ALL, its nodes as sets, and cards."""
    nodes = mesh.nodes / scale if turn is None else mesh.nodes @ np.transpose(turn)
    lines = [
        "*NODE",
        *(f"{i + 1}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(nodes)),
    ]
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=ALL")
    lines += [", ".join(map(str, [i + 1, *(cell + 1)])) for i, cell in enumerate(mesh.cells)]
    for name, members in mesh.node_sets.items():
        lines += [f"*NSET, NSET={name}", *(str(node + 1) for node in members)]
    path.write_text("\n".join([*lines, *cards]))
    return path


def nastran(path: Path, mesh: Any, cards: Iterable[str], after: str = "") -> Path:
    """Write a mesh with property 7, `after` the nodes of each element, and cards."""
    name = {2: "CBAR", 3: "CTRIA3", 4: "CQUAD4", 8: "CHEXA"}[mesh.cells.shape[1]]
    lines = ["BEGIN BULK"]
    lines += [f"GRID,{i + 1},,{x:.9g},{y:.9g},{z:.9g}" for i, (x, y, z) in enumerate(mesh.nodes)]
    for i, cell in enumerate(mesh.cells):
        numbers = [str(node + 1) for node in cell]
        numbers[6:7] = ["\n", *numbers[6:7]] if len(cell) > 6 else []
        lines.append(",".join([name, str(i + 1), "7", *numbers]) + after)
    path.write_text("\n".join([*lines, *cards, "ENDDATA", ""]))
    return path


def deck(folder: Path, mesh: Any, *cards: str, after: str = "", kind: str = "") -> Path:
    """Write a mesh for the program whose cards these are, with `STEEL` and `PLY` as it has them."""
    text = "\n".join(cards)
    if text.startswith("*"):
        known = [one for one in (STEEL, PLY) if one.split("\n")[0] not in text]
        kind = kind or {"quad": "S4", "line": "B31", "hexahedron": "C3D8"}[mesh.kind]
        return abaqus(folder / "a.inp", mesh, [*cards, *known], kind)
    known = [one for one in (MAT1, MAT8) if not re.search(rf"MAT\d+,{one[5]},", text)]
    return nastran(folder / "a.bdf", mesh, [*cards, *known], after)


def strip(n: int, m: int, place: Any) -> tuple[Any, Any]:
    """Nodes and cells of n x m elements S8R on the unit square, put into space."""
    i, j = np.meshgrid(np.arange(2 * n + 1), np.arange(2 * m + 1), indexing="ij")
    kept = (i % 2 == 0) | (j % 2 == 0)
    number = np.where(kept, np.cumsum(kept).reshape(kept.shape) - 1, -1)
    a, b = (of[:-1:2, :-1:2].ravel() for of in (i, j))
    around = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    cells = np.stack([number[a + di, b + dj] for di, dj in around], axis=1)
    return np.stack(place(i[kept] / (2 * n), j[kept] / (2 * m)), axis=1), cells


def ccx(path: Path, lines: Iterable[str]) -> Path:
    """Write a deck, and let CalculiX run it."""
    path.write_text("\n".join(lines))
    command = ["ccx", path.stem]
    subprocess.run(command, cwd=path.parent, check=True, capture_output=True, timeout=300)
    return path


def frequencies(path: Path) -> list[float]:
    """The frequencies that CalculiX has printed, Hz."""
    printed = [line.split() for line in path.with_suffix(".dat").read_text().splitlines()]
    return [float(words[3]) for words in printed if len(words) == 5 and words[0].isdigit()]
