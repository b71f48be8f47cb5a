"""Bodies of shells, beams and solids: supports, frequencies, joints, refusals."""

from __future__ import annotations

import math
from typing import Any

import meshio
import numpy as np
import pytest

import aoimpact as ao
from aoimpact import InputError

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
SHEET = ao.Shell(thickness=2e-3, material=STEEL)


@pytest.mark.parametrize(
    ("letters", "factor"), [(("xyz",), 19.739), (("xyz", "xyz"), 35.985), ((), 13.468)]
)
def test_supports_hold_displacements_and_rotations(letters: Any, factor: float) -> None:
    """ω a² √(m/D) of simply supported, clamped and free square plates (A. W. Leissa, 1973)."""
    mesh = ao.sheet_mesh((0.3, 0.3), (24, 24))
    body = ao.FEModel.from_mesh(mesh, SHEET, fixed=[("rim", *letters)] if letters else None)
    found = body.frequencies(7)
    if not letters:
        assert (found[:6] == 0.0).all()
        found = found[6:]
    unit = math.sqrt(210e9 * 8e-9 / (12 * 0.91) / 15.6) / 0.09 / (2 * np.pi)
    assert found[0] / unit == pytest.approx(factor, rel=0.012)


def test_supports_may_hold_rotations_alone() -> None:
    """A strip between guides slides and bends freely: ω = π² √(EI/ρA)/L² (ν = 0)."""
    metal = ao.Material(E=210e9, nu=0.0, rho=7800)
    ends = [(place, "", "xyz") for place in ("xmin", "xmax")]
    strip = ao.FEModel.from_mesh(
        ao.sheet_mesh((1.0, 0.1), (40, 4)), ao.Shell(1e-3, metal), fixed=ends
    )
    assert strip.rigid_modes.shape[1] == 3
    exact = 0.5 * np.pi * np.sqrt(210e9 * 1e-6 / 12 / 7800)
    assert strip.frequencies(4) == pytest.approx([0, 0, 0, exact], rel=2e-3, abs=1e-6)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_free_body_in_any_plane_has_six_rigid_motions(angle: float) -> None:
    mesh = ao.sheet_mesh((0.3, 0.2), (6, 4))
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    body = ao.FEModel.from_mesh(ao.Mesh(mesh.nodes @ turn, mesh.cells, "quad"), SHEET)
    assert body.rigid_modes.shape == (210, 6)
    found = body.frequencies(9)
    assert (found[:6] == 0.0).all()
    assert found[6:] == pytest.approx(ao.FEModel.from_mesh(mesh, SHEET).frequencies(9)[6:])
    one = ao.FEModel.from_mesh(mesh, SHEET, fixed=[(0, "xyz")])
    assert one.rigid_modes.shape[1] == 3


def test_a_shell_continued_on_a_solid_is_clamped_there() -> None:
    """A sheet that sticks out of a block: P L³/(3 E I) beyond the block, which hardly yields."""
    block = ao.box_mesh((0.1, 0.04, 0.04), (4, 2, 2))
    top = np.flatnonzero((block.nodes[:, 2] == 0.04) & (block.nodes[:, 0] >= 0.05 - 1e-9))
    along, across = 12, np.array([0.0, 0.02, 0.04])
    out = np.array([(0.1 + 0.2 * i / along, y, 0.04) for i in range(1, along + 1) for y in across])
    nodes = np.vstack([block.nodes, out])
    rows = [top[np.isclose(block.nodes[top, 0], x)] for x in (0.05, 0.075, 0.1)]
    rows = [row[np.argsort(block.nodes[row, 1])] for row in rows]
    rows += list(len(block.nodes) + np.arange(len(out)).reshape(along, 3))

    def mesh(first: int) -> ao.Mesh:
        cells = [
            (a[j], b[j], b[j + 1], a[j + 1])
            for a, b in zip(rows[first:-1], rows[first + 1 :], strict=True)
            for j in (0, 1)
        ]
        blocks: Any = [("hexahedron", block.cells), ("quad", np.array(cells))]
        groups = {"block": np.arange(16), "sheet": 16 + np.arange(len(cells))}
        return ao.Mesh(nodes, blocks, "mixed", block.node_sets, groups)

    parts = {"block": STEEL, "sheet": ao.Shell(1e-3, STEEL)}
    body = ao.FEModel.from_mesh(mesh(0), parts, fixed=[("xmin", "xyz")])
    tip = body.contact(point=(0.3, 0.02, 0.04), direction=(0, 0, -1), radius=0)
    found = tip.b @ body.inverse().solve(tip.b)
    strip = 0.2**3 / (3 * 210e9 * 0.04 * 1e-9 / 12)
    assert found == pytest.approx(strip, rel=0.05)
    with pytest.raises(InputError, match=r"^mesh"):
        ao.FEModel.from_mesh(mesh(2), parts)


def test_springs_and_masses_act_on_displacements() -> None:
    mesh = ao.sheet_mesh((0.3, 0.3), (8, 8))
    body = ao.FEModel.from_mesh(mesh, SHEET, masses=[(40, 2.0)], springs=[("rim", "xyz", 1e4)])
    assert body.mass == pytest.approx(2.0 + 0.09 * 15.6)
    total = body.translation((0, 0, 1)) @ body.K @ body.translation((0, 0, 1))
    assert total == pytest.approx(1e4)
    assert body.rigid_modes.shape[1] == 0


@pytest.mark.parametrize("turned", [[3], [0, 5, 6]])
def test_neighbours_are_turned_to_one_side(turned: list[int]) -> None:
    mesh = ao.sheet_mesh((0.3, 0.2), (4, 3))
    cells = mesh.cells.copy()
    cells[turned] = cells[turned][:, ::-1]
    raw = meshio.Mesh(mesh.nodes, [("quad", cells)])
    with pytest.warns(ao.AOImpactWarning, match=f"^{len(turned)} "):
        read = ao.read_mesh(raw)
    corners = read.nodes[read.cells]
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0).all()
