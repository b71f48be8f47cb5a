"""Generated meshes have the shape they claim, and elements good enough to compute with."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from aoimpact.io import paper_sphere_mesh
from aoimpact.mesh import (
    KINDS,
    Mesh,
    box_mesh,
    cofactors,
    jacobians,
    reference_element,
    sphere_mesh,
)

FloatArray = npt.NDArray[np.float64]

POLES = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]


def volumes(mesh: Mesh) -> FloatArray:
    """Volume of each element by its mass rule, which is exact."""
    element = reference_element(mesh.kind)
    rule = element.mass_rule
    det, _ = cofactors(jacobians(mesh.nodes[mesh.cells], element.gradient(rule.points)))
    return det @ rule.weights


def scaled_jacobian(mesh: Mesh) -> float:
    """Worst ratio of smallest to largest det J at an element's own nodes: 1 if straight."""
    element = reference_element(mesh.kind)
    det, _ = cofactors(jacobians(mesh.nodes[mesh.cells], element.gradient(element.nodes)))
    return float((det.min(axis=1) / det.max(axis=1)).min())


def tetrahedron_quality(mesh: Mesh) -> float:
    """Worst 6√2 V / (root mean square edge)³ of the corners: 1 for a regular tetrahedron."""
    corners = mesh.nodes[mesh.cells[:, :4]]
    a, b = np.triu_indices(4, 1)
    edges = np.linalg.norm(corners[:, a] - corners[:, b], axis=2)
    six_volumes = np.linalg.det(corners[:, 1:] - corners[:, :1])
    return float((six_volumes * math.sqrt(2.0) / np.sqrt((edges**2).mean(axis=1)) ** 3).min())


@pytest.mark.parametrize("size", [1.0, 0.5, 0.25, 0.15])
def test_sphere_is_a_ball_with_corners_at_the_poles(size: float) -> None:
    mesh = sphere_mesh(2.0, 2.0 * size)
    corners = mesh.nodes[np.unique(mesh.cells[:, :4])]
    for pole in [*POLES, np.zeros(3)]:
        assert (np.abs(corners - 2.0 * pole).sum(axis=1) == 0.0).sum() == 1
    radii = np.linalg.norm(mesh.nodes, axis=1)
    assert radii.max() == pytest.approx(2.0, rel=1e-15)
    on_sphere = np.flatnonzero(np.abs(radii - 2.0) < 1e-12)
    assert np.array_equal(mesh.node_sets["surface"], on_sphere)
    assert scaled_jacobian(mesh) > 0.6
    assert tetrahedron_quality(mesh) > 0.5


def test_sphere_counts_are_eulers() -> None:
    # A ball of tetrahedra: V - E + F - T = 1; tetra10 has a node for each V and E, and T = 20 n³.
    mesh = sphere_mesh(1.0, 1.31 / 8)
    n_surface_corners = len(np.intersect1d(np.unique(mesh.cells[:, :4]), mesh.node_sets["surface"]))
    n_corners = len(np.unique(mesh.cells[:, :4]))
    assert n_surface_corners == 10 * 8**2 + 2
    assert mesh.n_cells == 20 * 8**3
    assert mesh.n_nodes == 2 * n_corners + mesh.n_cells + n_surface_corners - 3


def test_volume_of_the_sphere_converges_with_order_four() -> None:
    fineness = np.array([4, 6, 8])
    gaps = np.array(
        [4.0 / 3.0 * math.pi - math.fsum(volumes(sphere_mesh(1.0, 1.31 / n))) for n in fineness]
    )
    orders = np.diff(np.log(gaps)) / -np.diff(np.log(fineness))
    assert (orders > 3.7).all()
    assert gaps[-1] > 0.0


@pytest.mark.parametrize("size", [0.7, 0.33, 0.22, 0.15])
def test_sphere_is_as_fine_as_asked(size: float) -> None:
    mesh = sphere_mesh(1.0, size)
    on_surface = np.zeros(mesh.n_nodes, dtype=bool)
    on_surface[mesh.node_sets["surface"]] = True
    ends = np.concatenate([mesh.cells[:, [a, b]] for a in range(4) for b in range(a)])
    ends = ends[on_surface[ends].all(axis=1)]
    lengths = np.linalg.norm(mesh.nodes[ends[:, 0]] - mesh.nodes[ends[:, 1]], axis=1)
    assert 0.5 * size < lengths.max() <= size


@pytest.mark.parametrize("kind", KINDS)
def test_box_has_its_volume_and_its_faces(kind: str) -> None:
    mesh = box_mesh((3.0, 2.0, 1.0), (3, 4, 2), kind=kind)
    per_brick = {"tetra": 6, "wedge": 2, "pyramid": 6}.get(reference_element(kind).cell.linear, 1)
    assert mesh.n_cells == 24 * per_brick
    each = volumes(mesh)
    assert each == pytest.approx(6.0 / mesh.n_cells, rel=1e-13)
    for axis, (name, length) in enumerate(zip("xyz", (3.0, 2.0, 1.0), strict=True)):
        for side, place in (("min", 0.0), ("max", length)):
            on_face = np.flatnonzero(np.abs(mesh.nodes[:, axis] - place) < 1e-12)
            assert np.array_equal(mesh.node_sets[name + side], on_face)


@pytest.mark.parametrize(
    ("kind", "count"), [("hexahedron", 60), ("hexahedron20", 60 + 133), ("hexahedron27", 315)]
)
def test_box_counts_by_hand(kind: str, count: int) -> None:
    # 2 x 3 x 4 bricks: 3·4·5 corners; 2·4·5 + 3·3·5 + 3·4·4 edges; lattice of 5·7·9 in all.
    assert box_mesh((1, 1, 1), (2, 3, 4), kind=kind).n_nodes == count


def test_paper_sphere_has_the_paper_s_counts() -> None:
    # Section 3: 1053 nodes, 602 elements with ten nodes; radius 10 mm.
    mesh = paper_sphere_mesh()
    assert (mesh.n_nodes, mesh.n_cells, mesh.kind) == (1053, 602, "tetra10")


def test_paper_sphere_is_a_good_mesh_of_the_sphere() -> None:
    mesh = paper_sphere_mesh()
    radius = 0.01
    radii = np.linalg.norm(mesh.nodes, axis=1)
    surface = mesh.node_sets["surface"]
    assert radii[surface] == pytest.approx(radius, rel=1e-9)
    assert radii[np.setdiff1d(np.arange(mesh.n_nodes), surface)].max() < 0.99 * radius
    corners = mesh.nodes[np.unique(mesh.cells[:, :4])]
    for pole in (radius, -radius):
        assert np.abs(corners - [pole, 0.0, 0.0]).sum(axis=1).min() < 1e-12
    assert scaled_jacobian(mesh) > 0.2
    assert tetrahedron_quality(mesh) > 0.3
    # Inscribed: lighter than the ball, by well under a percent.
    share = math.fsum(volumes(mesh)) / (4.0 / 3.0 * math.pi * radius**3)
    assert 0.995 < share < 1.0
