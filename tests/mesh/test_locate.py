"""Points of a body are found again, whatever its elements look like."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import distorted_box, mixed_box
from rows import each

import aoimpact as ao
from aoimpact.mesh import KINDS, weights_at

MIXED = [mixed_box((2.0, 1.5, 1.0), (2, 2, 3), order=order) for order in (1, 2)]


@each("mesh", [*map(distorted_box, KINDS), *MIXED])
def test_coordinates_interpolated_at_a_point_are_the_point(mesh: ao.Mesh) -> None:
    for point in np.random.default_rng(0).uniform(0.0, 1.0, (15, 3)) * [2.0, 1.5, 1.0]:
        nodes, weights = weights_at(mesh, point)
        np.testing.assert_allclose(weights @ mesh.nodes[nodes], point, atol=1e-12)
        assert weights.sum() == pytest.approx(1.0, abs=1e-12)


@each("kind", KINDS)
def test_a_node_is_itself(kind: str) -> None:
    mesh = distorted_box(kind)
    for node in (0, mesh.n_nodes // 2, mesh.n_nodes - 1):
        nodes, weights = weights_at(mesh, mesh.nodes[node])
        np.testing.assert_allclose(weights, nodes == node, atol=1e-9)


def test_points_of_a_sphere_are_on_its_faceted_surface() -> None:
    mesh = ao.sphere_mesh(0.01, 0.005)
    directions = np.random.default_rng(1).standard_normal((20, 3))
    for point in 0.01 * directions / np.linalg.norm(directions, axis=1, keepdims=True):
        nodes, weights = weights_at(mesh, point)
        assert np.linalg.norm(weights @ mesh.nodes[nodes] - point) < 2e-3 * 0.01


@each("point", [(2.1, 0.5, 0.5), (-1e3, 0.0, 0.0), (1.0, 0.7, 1.05)])
@each("kind", ["tetra10", "hexahedron", "wedge"])
def test_a_point_off_the_body_is_refused(kind: str, point: tuple[float, ...]) -> None:
    with pytest.raises(ao.InputError, match=r"^point"):
        weights_at(distorted_box(kind), np.array(point))
