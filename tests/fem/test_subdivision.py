"""Quadrature that is refined towards a point keeps volumes, areas and moments of bodies."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from bodies import distorted_box

import aoimpact as ao
from aoimpact.fem.subdivision import Points, cells_towards, sides_towards
from aoimpact.mesh import KINDS, boundary

FloatArray = npt.NDArray[np.float64]
A = 0.05


def in_cells(mesh: ao.Mesh, point: FloatArray) -> list[Points]:
    return [
        at
        for block in mesh.blocks
        for at in cells_towards(mesh.nodes, block, np.arange(len(block.cells)), point, A)
    ]


def on_sides(mesh: ao.Mesh, point: FloatArray) -> list[Points]:
    surface, found = boundary(mesh), []
    for side, (number, face) in enumerate(surface.sides):
        block = mesh.blocks[number]
        rows = surface.cell[surface.side == side] - block.first
        corners = block.element.nodes[face.nodes[: face.n_corners]]
        found += list(sides_towards(mesh.nodes, block, rows, corners, point, A))
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_moments_of_a_box(kind: str) -> None:
    """Volume and first to third moments; exact, as straight cells are to the third degree."""
    mesh = ao.box_mesh((2.0, 1.5, 1.0), (2, 2, 2), kind=kind)
    size = np.array([2.0, 1.5, 1.0])
    cells = in_cells(mesh, size * [0.4, 0.6, 1.0])
    for power in range(4):
        found = sum(np.einsum("nq,nqi->i", at.weight, at.x**power) for at in cells)
        exact = size.prod() * size**power / (power + 1)
        np.testing.assert_allclose(found, exact, rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_moments_of_distorted_elements_by_their_sides(kind: str) -> None:
    """By Gauss's theorem; sides are exact to the fifth degree."""
    mesh = distorted_box(kind)
    size = mesh.nodes.max(axis=0)
    sides = on_sides(mesh, size * [0.4, 0.6, 1.0])
    flux = sum(np.einsum("nqi,nqi->", at.area, at.x) for at in sides)
    assert flux == pytest.approx(3.0 * size.prod(), rel=1e-9)
    closed = sum(at.area.sum(axis=(0, 1)) for at in sides)
    np.testing.assert_allclose(closed, 0.0, atol=1e-12 * size.prod())
    second = sum(np.einsum("nqi,nqi,nqi->i", at.area, at.x, at.x) for at in sides)
    np.testing.assert_allclose(second, size * size.prod(), rtol=1e-9)  # div x² e = 2 x


@pytest.mark.parametrize("kind", KINDS)
def test_shape_functions_and_their_slopes_are_those_of_the_points(kind: str) -> None:
    mesh = distorted_box(kind)
    (cells,) = [block.cells for block in mesh.blocks]
    for at in in_cells(mesh, mesh.nodes[0]):
        corners = mesh.nodes[cells[at.rows]]
        np.testing.assert_allclose(at.shape.sum(axis=2), 1.0, rtol=1e-12)
        np.testing.assert_allclose(at.x, at.shape @ corners, rtol=1e-12, atol=1e-12)
        gradient = np.einsum("nqai,naj->nqij", at.slopes, corners)
        np.testing.assert_allclose(gradient - np.eye(3), 0.0, atol=1e-9)


def test_curved_sides_are_those_of_the_ball() -> None:
    mesh = ao.sphere_mesh(1.0, 0.4)
    sides = on_sides(mesh, np.array([1.0, 0.0, 0.0]))
    area = sum(np.linalg.norm(at.area, axis=2).sum() for at in sides)
    assert area == pytest.approx(4.0 * math.pi, rel=2e-3)  # of quadratic faces
    volume = sum(at.weight.sum() for at in in_cells(mesh, np.array([1.0, 0.0, 0.0])))
    flux = sum(np.einsum("nqi,nqi->", at.area, at.x) for at in sides)
    assert flux == pytest.approx(3.0 * volume, rel=1e-4)


@pytest.mark.parametrize("kind", ["hexahedron20", "tetra10"])
def test_it_sees_a_pressure_on_a_disc_far_smaller_than_the_elements(kind: str) -> None:
    """∫ 1.5 √(1 - r²/a²)/(π a²) dA = 1 on the side of a box with elements ten times as large."""
    mesh = ao.box_mesh((1.0, 1.0, 0.5), (2, 2, 1), kind=kind)
    point = np.array([0.43, 0.61, 0.5])
    total = 0.0
    for at in on_sides(mesh, point):
        r2 = ((at.x - point) ** 2).sum(axis=2) / A**2
        pressure = 1.5 * np.sqrt(np.maximum(1.0 - r2, 0.0)) / (math.pi * A * A)
        total += float((pressure * at.area[..., 2]).sum())
    assert total == pytest.approx(1.0, rel=2e-3)
