"""Contact points: nodes, places on the surface, patches, dofs; what is near is said."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from rows import each

from aoimpact import (
    AOImpactWarning,
    ContactPoint,
    FEModel,
    InputError,
    InputTypeError,
    Material,
    box_mesh,
    paper_sphere_mesh,
)
from aoimpact.contact import centre_of, static_mode
from aoimpact.mesh import KINDS


def moment_of(tip: ContactPoint) -> np.ndarray:
    """Of the nodes' forces about the point, for a unit contact force, m."""
    return np.cross(tip.body.nodes - tip.point, tip.forces[0]).sum(axis=0)


STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
BLOCK = box_mesh((0.04, 0.02, 0.02), (4, 2, 2))  # nodes 10 mm apart
FREE = FEModel.from_mesh(BLOCK, STEEL)
BARE = FEModel(K=FREE.K, M=FREE.M, nodes=FREE.nodes)
BALL = FEModel.from_mesh(paper_sphere_mesh(), STEEL)
PLATE = FEModel.from_mesh(box_mesh((0.04, 0.04, 0.01), (8, 8, 2), kind="hexahedron20"), STEEL)
THICK = FEModel.from_mesh(box_mesh((0.04, 0.04, 0.02), (8, 8, 2), kind="hexahedron20"), STEEL)
DOWN = (0.0, 0.0, -1.0)
SLANTED = np.array([0.48, -0.6, 0.64])


# ------------------------------------------------------------------------- nodes


def test_of_a_body_without_a_mesh_the_nearest_node_is_taken_and_said() -> None:
    said = r"\(0\.023, 0\.01, 0\.02\) m is no node.* {} at \(0\.02, 0\.01, 0\.02\) m, 0\.003 m off"
    node = BARE.contact(point=(0.02, 0.01, 0.02), direction=DOWN, radius=0).node
    with pytest.warns(AOImpactWarning, match=said.format(node)) as caught:
        tip = BARE.contact(point=(0.023, 0.01, 0.02), direction=DOWN, radius=0)
    assert tip.node == node
    assert caught[0].filename == __file__


# ------------------------------------------------------------------------- points of faces


def test_a_point_of_a_face_has_the_shares_of_its_shape_functions() -> None:
    tip = FREE.contact(point=(0.023, 0.014, 0.02), direction=DOWN, radius=0)
    assert tip.node is None
    assert FREE.nodes is not None
    forces = np.zeros(3 * len(FREE.nodes))
    forces[FREE.free] = tip.b
    share = {tuple(FREE.nodes[dof // 3].round(12)): -forces[dof] for dof in np.flatnonzero(forces)}
    # Bilinear: 3/10 along x and 4/10 along y of a square of 10 mm.
    assert share == {
        (0.02, 0.01, 0.02): pytest.approx(0.7 * 0.6),
        (0.03, 0.01, 0.02): pytest.approx(0.3 * 0.6),
        (0.02, 0.02, 0.02): pytest.approx(0.7 * 0.4),
        (0.03, 0.02, 0.02): pytest.approx(0.3 * 0.4),
    }


@cache
def fine_block(kind: str) -> FEModel:
    return FEModel.from_mesh(box_mesh((0.04, 0.02, 0.02), (12, 8, 1), kind=kind), STEEL)


@each("kind", KINDS)
@each("radius", [0.0, 0.009])
def test_a_contact_sees_rigid_motions_as_its_point_does(kind: str, radius: float) -> None:
    # u = bᵀX of a translation t and rotation w is d·(t + w × point): resultant and moment in one.
    body = fine_block(kind)
    tip = body.contact(point=(0.0211, 0.0104, 0.02), direction=DOWN, radius=radius)
    assert body.nodes is not None
    assert tip.direction is not None
    assert tip.point is not None
    t, w = np.array([0.3, -0.7, 0.2]), np.array([-0.4, 0.1, 0.9])
    motion = (t + np.cross(w, body.nodes)).reshape(-1)
    assert tip.b @ motion == pytest.approx(tip.direction @ (t + np.cross(w, tip.point)), rel=1e-12)
    np.testing.assert_allclose(tip.resultant, DOWN, atol=1e-13)
    np.testing.assert_allclose(moment_of(tip), 0.0, atol=1e-15)


def test_a_point_at_a_node_is_that_node_along_the_surface_s_own_normal() -> None:
    tip = FREE.contact(point=(0.02, 0.01, 0.02), radius=0)
    assert tip.node == FREE.contact(point=(0.02, 0.01, 0.02), direction=DOWN, radius=0).node
    np.testing.assert_array_equal(tip.direction, DOWN)


@each("radius", [0.0, 0.004])
def test_the_direction_is_the_inward_normal_by_default(radius: float) -> None:
    tip = BALL.contact(point=0.01 * SLANTED, radius=radius)
    np.testing.assert_allclose(tip.direction, -SLANTED, atol=2e-3)
    np.testing.assert_allclose(tip.resultant, tip.direction, atol=1e-13)
    np.testing.assert_allclose(moment_of(tip), 0.0, atol=1e-15)


def test_an_oblique_force_on_a_ball_turns_it_by_the_patch_s_depth_only() -> None:
    tip = BALL.contact(point=(0.01, 0, 0), direction=(-1, 1, 0), radius=0.004)
    # The mean sagitta of a ball under Hertz's pressure: to first order r²/5R.
    np.testing.assert_allclose(tip.resultant, np.array([-1, 1, 0]) / np.sqrt(2.0), atol=1e-13)
    np.testing.assert_allclose(np.abs(moment_of(tip)[2]), 0.004**2 / 0.05 / np.sqrt(2.0), rtol=0.05)


def test_a_point_a_little_off_a_coarse_surface_is_put_on_it_and_said() -> None:
    body = FEModel.from_mesh(box_mesh((0.04, 0.02, 0.02), (4, 2, 2)), STEEL)
    with pytest.warns(AOImpactWarning, match=r"^point"):
        tip = body.contact(point=(0.023, 0.014, 0.0205), direction=DOWN, radius=0)
    np.testing.assert_allclose(tip.point, (0.023, 0.014, 0.02), rtol=1e-12)


# ------------------------------------------------------------------------- patches


def test_automatic_radius_is_a_little_more_than_the_contact_s() -> None:
    """1.4 times it: at 1.2 times it two like bodies leave nothing of Hertz's law."""
    tip = THICK.contact(point=(0.021, 0.019, 0.02), radius="auto", expected=0.004)
    assert tip.patch is not None
    assert tip.patch.radius == pytest.approx(1.4 * 0.004)
    assert tip.contact_radius == 0.004
    assert tip.automatic


def test_automatic_radius_is_an_element_s_where_the_contact_is_not_known() -> None:
    """And a quarter of the depth at most: a wider patch does not see the body's shorter waves."""
    for count, radius in ((6, 0.005), (12, 0.04 / 12)):
        mesh = box_mesh((0.04, 0.04, 0.02), (count, count, 1), kind="hexahedron20")
        tip = FEModel.from_mesh(mesh, STEEL).contact(point=(0.02, 0.02, 0.02))
        assert tip.patch is not None
        assert tip.patch.radius == pytest.approx(radius)
        assert tip.contact_radius is None


# ------------------------------------------------------------------------- bad input


@each("x", [0.02, 0.023])  # a node, and none
def test_an_edge_is_struck_in_any_direction_but_along_it(x: float) -> None:
    place = (x, 0.0, 0.02)
    words = r"^direction"
    with pytest.raises(InputError, match=words):
        FREE.contact(point=place, direction=(1, 0, 0), radius=0)
    for direction in (DOWN, (0, 1, 0), (0, 1, -1), (2, 1, 0)):
        tip = FREE.contact(point=place, direction=direction, radius=0)
        np.testing.assert_allclose(tip.resultant, direction / np.linalg.norm(direction), atol=1e-13)


def test_a_patch_may_lie_on_a_support_but_not_on_nothing_else() -> None:
    """The half-space's field is lifted there, so that its compliance is known."""
    body = FEModel.from_mesh(PLATE.mesh, STEEL, fixed=[("xmin", "xyz")])
    near = body.contact(point=(0.007, 0.02, 0.01), radius=0.006)
    assert near.extraction is not None
    assert near.extraction.removed > 0.0
    held = FEModel.from_mesh(PLATE.mesh, STEEL, fixed=[("zmax", "xyz")])
    for radius in (0.006, "auto"):
        with pytest.raises(InputError, match=r"^point"):
            held.contact(point=(0.021, 0.02, 0.01), radius=radius)


def test_a_body_without_a_mesh_has_neither_patches_nor_normals() -> None:
    with pytest.raises(InputError, match=r"^radius"):
        BARE.contact(point=(0.02, 0.01, 0.02), direction=DOWN, radius=0.004)
    with pytest.raises(InputTypeError, match=r"^contact"):
        BARE.contact(point=(0.02, 0.01, 0.02), radius=0)
    with pytest.raises(InputError, match="nodes"):
        FEModel(K=FREE.K, M=FREE.M).contact(dof=3).resultant  # noqa: B018


def test_a_radius_left_out_is_as_large_as_there_is_room() -> None:
    """1 mm from the edge of a side with elements of 5 mm."""
    near = THICK.contact(point=(0.001, 0.02, 0.02))
    assert near.patch is not None
    assert 0.0005 < near.patch.radius < 0.001


# ------------------------------------------------------------- functionals and labels


def shares(body: FEModel, weights: dict[int, float], component: int = 2) -> Any:
    b = np.zeros(body.n_dofs)
    for node, share in weights.items():
        b[3 * node + component] = share
    return b


def test_a_functional_of_one_s_own_is_the_one_that_is_named() -> None:
    point = BALL.contact(point=(0.0, 0.0, 0.01), direction=DOWN, radius=0.003)
    own = BALL.contact(b=point.b)
    np.testing.assert_array_equal(own.b, point.b)
    assert (own.patch, own.node) == (None, None)
    np.testing.assert_allclose(own.point, point.point, atol=1e-6)
    assert own.direction is not None
    np.testing.assert_allclose(own.direction, DOWN, atol=1e-12)
    assert repr(own).startswith(f"ContactPoint(functional of {np.count_nonzero(point.b)} dofs at")
    with pytest.raises(InputError, match=r"^radius"):
        BALL.contact(b=point.b, radius=0.003)


def test_the_mean_of_two_nodes_deflects_by_the_mean_of_their_compliances() -> None:
    body = FEModel.from_mesh(BLOCK, STEEL, fixed=[("xmin", "xyz")])
    inverse = np.linalg.inv(body.K.toarray())
    b = np.zeros(body.n_dofs)
    b[[-1, -4]] = 0.5
    tip = body.contact(b=b)
    expected = 0.25 * inverse[np.ix_([-1, -4], [-1, -4])].sum()
    assert static_mode(tip).k0 == pytest.approx(1.0 / expected, rel=1e-9)
    assert tip.direction is not None
    np.testing.assert_allclose(tip.direction, (0, 0, 1))


def test_a_functional_with_a_couple_is_said() -> None:
    """A force on one node along z, and two across it that turn the body about z."""
    other = int(np.argmin(np.linalg.norm(BLOCK.nodes - BLOCK.nodes[0] - [0.04, 0.0, 0.0], axis=1)))
    b = shares(FREE, {0: 1.0})
    b[1], b[3 * other + 1] = 0.5, -0.5
    with pytest.warns(AOImpactWarning, match=r"^b"):
        FREE.contact(b=b)


@pytest.mark.filterwarnings("ignore:b is no mean displacement")
def test_a_functional_that_is_no_mean_has_no_direction() -> None:
    tip = FREE.contact(b=shares(FREE, {0: 1.0, 5: -1.0}))
    assert tip.direction is None
    with pytest.raises(InputError, match=r"^radius"):
        FREE.contact(b=shares(FREE, {0: 1.0, 5: -1.0}), radius=1e-3)


def labelled(**more: Any) -> FEModel:
    """The free block, its rows mixed and its nodes called 101, 103, …"""
    order = np.random.default_rng(1).permutation(FREE.n_dofs)
    labels = np.stack([101 + 2 * (order // 3), order % 3 + 1], axis=1)
    return FEModel(K=FREE.K[order][:, order], M=FREE.M[order][:, order], labels=labels, **more)


def test_a_label_names_its_node_in_any_order_of_the_rows() -> None:
    body = labelled()
    assert body.mass == pytest.approx(FREE.mass, rel=1e-12)
    tip = body.contact(node=109, direction=SLANTED)
    same = BARE.contact(node=4, direction=SLANTED)
    mode, expected = static_mode(tip), static_mode(same)
    assert mode.mass == pytest.approx(expected.mass, rel=1e-9)
    assert centre_of(tip, mode.phi)[1] == pytest.approx(FREE.mass, rel=1e-12)
    assert repr(tip).startswith("ContactPoint(node 109, functional of 3 dofs of a body of")
