"""Bodies that can be computed with, but are probably not what their maker means, are warned of."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(210e9, 0.3, 7800)
BAR = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1))


def two_bars(apart: float) -> ao.Mesh:
    nodes = np.concatenate([BAR.nodes, BAR.nodes + np.array([0.0, 0.0, apart])])
    cells = np.concatenate([BAR.cells, BAR.cells[:4] + len(BAR.nodes)])
    used, cells = np.unique(cells, return_inverse=True)
    groups = {"whole": range(10), "short": range(10, 14)}
    return ao.Mesh(nodes[used], cells.reshape(-1, 8), BAR.kind, {}, groups)


@pytest.mark.parametrize("apart", [0.05, 0.01])
def test_separate_parts(apart: float) -> None:
    """Bodies that only touch, with nodes of their own, are not joined."""
    words = r"2 parts that share no nodes: 10 of 14 elements, .* \(0.005, .*merge nodes .*by part="
    with pytest.warns(ao.AOImpactWarning, match=words):
        ao.FEModel.from_mesh(two_bars(apart), STEEL)


def test_one_part_and_parts_that_a_mass_joins_are_as_meant() -> None:
    ends = ao.RigidMass(lambda x: x[:, 0] == 0.0, 0.1, inertia=(1e-4, 1e-4, 1e-4))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        body = ao.FEModel.from_mesh(two_bars(0.05), STEEL, part="short")
        ao.FEModel.from_mesh(two_bars(0.05), STEEL, masses=[ends])
    assert body.mass == pytest.approx(7800 * 0.04 * 1e-4)


@pytest.mark.parametrize("nu", [0.49, 0.4999])
def test_locking(nu: float) -> None:
    """Bending of a clamped bar: elements of first order are far too stiff, the cure serves."""
    rubber = ao.Material(E=1e7, nu=nu, rho=1100)
    closed = 1.8751**2 / (2 * np.pi) / 0.1**2 * np.sqrt(1e7 * 0.01**2 / 12 / 1100)
    with pytest.warns(ao.AOImpactWarning, match=f"nu={nu}"):
        stiff = ao.FEModel.from_mesh(BAR, rubber, fixed=[("xmin", "xyz")])
    assert stiff.frequencies(1)[0] > 1.3 * closed
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cured = ao.FEModel.from_mesh(BAR, rubber, fixed=[("xmin", "xyz")], order=2)
    assert cured.frequencies(1)[0] == pytest.approx(closed, rel=0.06)


@pytest.mark.parametrize("offset", [0.005, -0.005, 0.0005])
def test_offsets_of_curved_shells(offset: float) -> None:
    """An arc of the radius R and the angle φ: the middle surface has the area (R + d) φ b."""
    sheet, R = ao.sheet_mesh((2.0, 0.1), (80, 2)), 0.1
    angle, y = sheet.nodes[:, 0], sheet.nodes[:, 1]
    nodes = np.column_stack([R * np.sin(angle), y, R * np.cos(angle)])
    arc = ao.Mesh(nodes, sheet.cells, sheet.kind)
    flat = ao.Mesh(0.1 * sheet.nodes, sheet.cells, sheet.kind)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        for mesh in (arc, flat):
            ao.FEModel.from_mesh(mesh, ao.Shell(0.01, STEEL, offset))
    true = 7800 * 0.01 * 0.1 * 2.0 * (R + offset)
    found = [
        float(numbers[1])
        for of in said
        if (
            numbers := re.search(
                r"curved or folded surface.* middle surface ([\d.]+) kg", str(of.message)
            )
        )
    ]
    assert found == pytest.approx([true] if abs(offset) > 0.001 else [], rel=3e-3)
