"""Bodies of shells and beams with elements half as long."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
SHEET, BAR = ao.Shell(3e-3, STEEL), ao.Beam(ao.RectangularSection(3e-3, 0.02), STEEL, (0, 0, 1))


def panel(n: int) -> ao.FEModel:
    """A sheet with a beam along its middle, held at one side, with a weight and springs."""
    mesh = ao.sheet_mesh((0.2, 0.1), (2 * n, 2 * n))
    (row,) = np.nonzero(np.isclose(mesh.nodes[:, 1], 0.05))
    row = row[np.argsort(mesh.nodes[row, 0])]
    blocks: Any = [("quad", mesh.cells), ("line", np.column_stack([row[:-1], row[1:]]))]
    groups = {"sheet": np.arange(4 * n * n), "bar": 4 * n * n + np.arange(2 * n)}
    both = ao.Mesh(mesh.nodes, blocks, "mixed", mesh.node_sets, groups)
    return ao.FEModel.from_mesh(
        both,
        {"sheet": SHEET, "bar": BAR},
        fixed=[("xmin", "xyz", "xyz"), ("xmax", "x")],
        masses=[(lambda x: np.isclose(x, (0.2, 0.05, 0.0)).all(axis=1), 0.2)],
        springs=[(lambda x: np.isclose(x, (0.1, 0.0, 0.0)).all(axis=1), "z", 1e5)],
        damping=ao.Rayleigh(alpha=10.0),
        name="panel",
    )


def test_it_is_the_body_of_twice_as_many_elements() -> None:
    coarse, fine = panel(2), panel(4)
    finer = coarse.finer
    assert finer.coarse is coarse
    assert (finer.name, finer.damping, finer.n_dofs) == ("panel", coarse.damping, fine.n_dofs)
    assert finer.mass == pytest.approx(fine.mass, rel=1e-12)
    assert np.array_equal(finer.nodes[: len(coarse.nodes)], coarse.nodes)
    for functional in np.eye(3):
        moved = finer.com_functional(functional).sum()
        assert moved == pytest.approx(fine.com_functional(functional).sum(), rel=1e-9)
    assert finer.frequencies(6) == pytest.approx(fine.frequencies(6), rel=1e-9)


def test_its_first_motions_are_those_of_the_nodes_of_the_body() -> None:
    mesh = ao.sheet_mesh((0.2, 0.1), (5, 3))
    coarse = ao.FEModel.from_mesh(mesh, SHEET, fixed=[("rim", "xyz")])
    finer = coarse.finer
    own = coarse.free[coarse.free < 3 * mesh.n_nodes]
    assert np.array_equal(finer.free[: len(own)], own)
    rim = np.isclose(np.abs(finer.nodes[:, :2] / (0.1, 0.05) - 1.0), 1.0).any(axis=1)
    held = np.setdiff1d(np.arange(3 * len(rim)), finer.free)
    assert set(np.unique(held // 3)) == set(np.flatnonzero(rim))


@pytest.mark.parametrize("at", [(0.1, 0.05), (0.11, 0.052)])
@pytest.mark.parametrize("radius", [0.0, 0.004])
def test_it_is_touched_in_the_same_place(at: tuple[float, float], radius: float) -> None:
    tip = panel(3).contact(point=(*at, 0.0), direction=(0, 0, -1), radius=radius)
    there = panel(6).contact(point=(*at, 0.0), direction=(0, 0, -1), radius=radius)
    finer = tip.finer
    assert tip.extraction is not None
    for name in ("direction", "point", "patch", "normal"):
        assert getattr(finer, name) is getattr(tip, name)
    known = [of.b @ of.body.inverse(1e8).solve(of.b) for of in (finer, there)]
    assert known[0] == pytest.approx(known[1], rel=1e-9)
    assert finer.resultant == pytest.approx(tip.resultant, abs=1e-9)
