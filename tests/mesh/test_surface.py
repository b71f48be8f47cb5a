"""The surface of a mesh is closed, and places on it are found where they are."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from bodies import distorted_box, mixed_box, no_solid
from rows import each
from skfem.quadrature import get_quadrature
from skfem.refdom import RefQuad, RefTri

from aoimpact.base import MeshError
from aoimpact.fem import FEModel
from aoimpact.mesh import KINDS, Mesh, Surface, boundary, box_mesh, reference_element, sphere_mesh

FloatArray = npt.NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])


def integrals(surface: Surface) -> tuple[float, FloatArray, float]:
    """Area, ∮ n dA, and ∮ x·n dA/3, which is the volume."""
    area, normal, volume = 0.0, np.zeros(3), 0.0
    for face in range(len(surface.cell)):
        triangle = np.allclose(surface.middle(np.array([face])), 1 / 3)
        points, weights = get_quadrature(RefTri if triangle else RefQuad, 12)
        x, tangents = surface.at(np.full(len(weights), face), points.T)
        vector = np.cross(tangents[:, 0], tangents[:, 1]) * weights[:, None]
        area += np.linalg.norm(vector, axis=1).sum()
        normal += vector.sum(axis=0)
        volume += np.einsum("ni,ni->", x, vector) / 3.0
    return area, normal, volume


MIXED = [mixed_box((2.0, 1.5, 1.0), (3, 2, 4), order=order) for order in (1, 2)]


@each("mesh", [*map(distorted_box, KINDS), *MIXED])
def test_the_surface_of_a_box_is_closed_and_one_part(mesh: Mesh) -> None:
    surface = boundary(mesh)
    area, normal, volume = integrals(surface)
    assert area == pytest.approx(2 * (2.0 * 1.5 + 2.0 * 1.0 + 1.5 * 1.0), rel=1e-12)
    assert volume == pytest.approx(2.0 * 1.5 * 1.0, rel=1e-12)
    np.testing.assert_allclose(normal, 0.0, atol=1e-13)
    assert (surface.part == 0).all()


def test_surface_of_a_ball() -> None:
    mesh = sphere_mesh(1.0, 0.33)
    area, normal, volume = integrals(boundary(mesh))
    assert area == pytest.approx(4 * math.pi, rel=1e-4)
    # Gauss's theorem against the mass of the elements.
    mass = FEModel.from_mesh(mesh, no_solid()).mass
    assert volume == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(normal, 0.0, atol=1e-13)


@each("kind", KINDS)
def test_a_point_of_the_surface_is_found_where_it_is(kind: str) -> None:
    surface = boundary(distorted_box(kind))
    for point in ([1.3, 0.7, 1.0], [2.0, 0.11, 0.2], [0.4, 0.0, 0.63]):
        place = surface.nearest(np.array(point))
        assert place.distance[0] < 1e-12
        np.testing.assert_allclose(surface.at(place.face, place.uv)[0][0], point, atol=1e-12)


def test_a_corner_belongs_to_all_of_its_faces() -> None:
    surface = boundary(box_mesh((1, 1, 1), (2, 2, 2)))
    for point, count in (([0.0, 0.0, 0.0], 3), ([0.5, 0.5, 1.0], 4), ([0.25, 0.25, 1.0], 1)):
        assert len(surface.nearest(np.array(point)).face) == count


def test_the_nearest_place_to_a_point_off_a_ball_lies_on_its_radius() -> None:
    surface = boundary(sphere_mesh(1.0, 0.33))
    toward = np.array([0.48, -0.6, 0.64])
    for distance in (0.9, 1.3):
        place = surface.nearest(distance * toward)
        np.testing.assert_allclose(place.x[0], toward, atol=2e-3)
        assert place.distance[0] == pytest.approx(abs(distance - 1.0), abs=1e-3)


@each("kind", KINDS)
def test_lines_pierce_the_side_that_is_asked_for(kind: str) -> None:
    surface = boundary(distorted_box(kind))
    points = np.random.default_rng(1).uniform([0, 0, 0.9], [2.0, 1.5, 1.1], (200, 3))
    top = surface.pierced(points, UP, reach=0.2)
    bottom = surface.pierced(points, UP, reach=2.0, outward=False)
    for place, height in ((top, 1.0), (bottom, 0.0)):
        wanted = np.column_stack([points[:, :2], np.full(200, height)])
        np.testing.assert_allclose(place.x, wanted, atol=1e-12)
        np.testing.assert_allclose(place.distance, np.abs(points[:, 2] - height), atol=1e-12)
        np.testing.assert_allclose(surface.at(place.face, place.uv)[0], wanted, atol=1e-12)


@each("kind", KINDS)
def test_faces_lie_within_their_bounds(kind: str) -> None:
    """Curved ones too, and along any axes; those of a box are its planes."""
    frame = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    uv = np.random.default_rng(3).dirichlet([0.3, 0.3, 0.3], 50)[:, :2]  # many near the edges
    for mesh, axes in (
        (distorted_box(kind), frame),
        (box_mesh((2, 1, 1), (2, 2, 2), kind=kind), np.eye(3)),
    ):
        surface = boundary(mesh)
        face = np.arange(len(surface.cell))
        low, high = surface.bounds(face, axes)
        corners = axes @ mesh.nodes[surface.corners(face)].swapaxes(1, 2)
        x = np.stack([axes @ surface.at(face, np.tile(place, (len(face), 1)))[0].T for place in uv])
        assert (x >= low - 1e-12).all()
        assert (x <= high + 1e-12).all()
    np.testing.assert_allclose(low, corners.min(axis=2).T, atol=1e-12)
    np.testing.assert_allclose(high, corners.max(axis=2).T, atol=1e-12)


def test_lines_beside_the_body_and_beyond_reach_pierce_nothing() -> None:
    surface = boundary(box_mesh((1, 1, 1), (2, 2, 2)))
    points = np.array([[1.1, 0.5, 1.0], [0.5, 0.5, 2.0], [0.5, 0.5, 1.05]])
    assert (surface.pierced(points, UP, reach=0.1).face >= 0).tolist() == [False, False, True]


@each("kind", ["pyramid", "pyramid13"])
def test_a_flat_side_of_a_pyramid_goes_straight_on_beyond_the_apex(kind: str) -> None:
    """Newton's steps lead there, where the functions of the element have no value."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.4, 0.7, 0.8]])
    element = reference_element(kind)
    nodes = element.linear.shape(element.nodes) @ corners
    surface = boundary(Mesh(nodes, [np.arange(len(nodes))], kind))
    uv = np.random.default_rng(1).uniform(-0.6, 1.6, (200, 2))
    for face in range(5):
        if surface.middle(np.array([face]))[0, 0] > 0.4:
            continue  # the base, a square
        at = np.full(3, face)
        (first, *others), _ = surface.at(at, np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]]))
        along = 2.0 * (np.array(others) - first)
        x, tangents = surface.at(np.full(len(uv), face), uv)
        assert x == pytest.approx(first + uv @ along, abs=1e-8)
        assert tangents == pytest.approx(np.tile(along, (len(uv), 1, 1)), abs=1e-8)


def test_the_top_of_a_hexahedron_is_flat_beside_a_pyramid() -> None:
    """A pyramid's apex is where its third coordinate is 1; a hexahedron's top is there, too."""
    cube = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
    nodes = np.vstack([cube, [0.5, 0.5, -1.0]])
    cells = [("hexahedron", [np.arange(8)]), ("pyramid", [[0, 3, 2, 1, 8]])]
    surface = boundary(Mesh(nodes, cells, "mixed"))
    face = np.arange(len(surface.cell))
    assert len(face) == 9
    normal = surface.normal(face, surface.middle(face))
    assert normal[surface.cell == 0].sum(axis=0) == pytest.approx([0.0, 0.0, 1.0])
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)


def test_a_side_without_area_is_named() -> None:
    """The corners of a side on a line."""
    left = [[0, 0, 0], [0, 0, 1], [0, 1e-300, 0], [0, 1e-300, 0]]
    right = [[1, 0, 0], [1, 0, 1], [1, 1, 0], [1, 1, 1]]
    surface = boundary(
        Mesh(np.array(left + right, float), [[0, 4, 6, 2, 1, 5, 7, 3]], "hexahedron")
    )
    face = np.arange(len(surface.cell))
    with pytest.raises(MeshError, match=r"^mesh"):
        surface.normal(face, surface.middle(face))
