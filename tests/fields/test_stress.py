"""Stress of given displacements: exact where it is constant, of its order where it is not."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import scipy.sparse
from bodies import distorted_box, rigid_motions
from hypothesis import given
from hypothesis import strategies as st
from rows import each
from scipy.spatial.transform import Rotation

import aoimpact as ao
from aoimpact.fem import Stress, body_stress_rows, gauss_stress, nodal_stress
from aoimpact.linalg import factorize
from aoimpact.mesh import KINDS

FloatArray = npt.NDArray[np.float64]

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
EVALUATE = [gauss_stress, nodal_stress]


def hooke(gradient: FloatArray, material: ao.Material = STEEL) -> FloatArray:
    """σ = E/(1+ν) (ε + ν/(1-2ν) tr ε I), as a tensor."""
    strain = 0.5 * (gradient + gradient.T)
    nu = material.nu
    bulk = nu / (1.0 - 2.0 * nu) * np.trace(strain) * np.eye(3)
    return material.E / (1.0 + nu) * (strain + bulk)


@each("evaluate", EVALUATE)
@each("kind", KINDS)
def test_linear_displacements_have_their_constant_stress_in_any_element(
    kind: str, evaluate: Any
) -> None:
    mesh = distorted_box(kind)
    gradients = 1e-3 * np.random.default_rng(0).standard_normal((3, 3, 3))
    displacement = mesh.nodes @ gradients.transpose(0, 2, 1)
    stress = evaluate(mesh, STEEL, displacement).tensor
    for found, gradient in zip(stress, gradients, strict=True):
        exact = hooke(gradient)
        assert np.abs(found - exact).max() < 1e-12 * np.abs(exact).max()


@each("evaluate", EVALUATE)
@each("kind", KINDS)
def test_rigid_motions_are_free_of_stress(kind: str, evaluate: Any) -> None:
    mesh = distorted_box(kind)
    motions = rigid_motions(mesh.nodes).T.reshape(6, -1, 3)
    stress = evaluate(mesh, STEEL, motions).components
    assert np.abs(stress).max() < 1e-12 * STEEL.E * np.abs(motions).max()


def bent_cantilever(kind: str, fineness: int, evaluate: Any) -> float:
    """Largest error of the stress in the middle half, over the largest stress.

    Timoshenko's cantilever under a load P at its end, exact for ν = 0: σxx = P (L - x) z / I as in
    beam theory, and σxz = -P (c² - z²) / 2I. The ends are moved as it says, and the finite elements
    find what lies between.
    """
    length, half, load = 4.0, 0.5, 1e6
    material = ao.Material(E=200e9, nu=0.0, rho=1e3)
    inertia = 2.0 * half**3 / 3.0
    mesh = ao.box_mesh((length, 0.5, 2.0 * half), (4 * fineness, 1, 2 * fineness), kind=kind)
    x, z = mesh.nodes[:, 0], mesh.nodes[:, 2] - half
    exact = np.zeros((mesh.n_nodes, 3))
    bending = load / (material.E * inertia)
    exact[:, 0] = bending * ((length * x - 0.5 * x**2) * z + z**3 / 3.0 - half**2 * z)
    exact[:, 2] = -bending * (0.5 * length * x**2 - x**3 / 6.0)
    K = ao.FEModel.from_mesh(mesh, material).K
    ends = np.union1d(mesh.node_sets["xmin"], mesh.node_sets["xmax"])
    held = (3 * ends[:, None] + np.arange(3)).ravel()
    free = np.setdiff1d(np.arange(3 * mesh.n_nodes), held)
    found = exact.reshape(-1).copy()
    found[free] = factorize(K[free][:, free]).solve(-(K[free][:, held] @ found[held]))
    stress = evaluate(mesh, material, found.reshape(-1, 3))
    place = stress.points.reshape(-1, 3)
    xx, xz = stress["xx"].reshape(-1), stress["xz"].reshape(-1)
    arm, height = length - place[:, 0], place[:, 2] - half
    middle = np.abs(place[:, 0] - 0.5 * length) < 0.25 * length
    error = np.hypot(
        xx - load * arm * height / inertia, xz + 0.5 * load * (half**2 - height**2) / inertia
    )
    return float(error[middle].max() / (load * length * half / inertia))


# Strains of elements of order p are of order p. At the nodes of equal bricks, where errors of both
# sides cancel, those of first order gain one.
@each(
    "kind, evaluate, order",
    [
        ("hexahedron", gauss_stress, 1),
        ("tetra", gauss_stress, 1),
        ("wedge", gauss_stress, 1),
        ("hexahedron20", gauss_stress, 2),
        ("hexahedron27", gauss_stress, 2),
        ("tetra10", gauss_stress, 2),
        ("hexahedron", nodal_stress, 2),
        ("hexahedron20", nodal_stress, 2),
        ("hexahedron27", nodal_stress, 2),
        ("tetra10", nodal_stress, 2),
    ],
)
def test_stress_of_a_bent_beam_converges_to_beam_theory(
    kind: str, evaluate: Any, order: int
) -> None:
    coarse, fine = (bent_cantilever(kind, fineness, evaluate) for fineness in (1, 2))
    assert np.log2(coarse / fine) > order - 0.25


@each("kind", KINDS)
def test_rows_give_the_stress_at_their_nodes(kind: str) -> None:
    mesh = distorted_box(kind)
    displacement = np.random.default_rng(1).standard_normal((mesh.n_nodes, 3))
    places = scipy.sparse.csr_array(np.eye(mesh.n_nodes)[[0, 7, -1]])
    rows = body_stress_rows(mesh, STEEL, places).rows @ displacement.reshape(-1)
    there = nodal_stress(mesh, STEEL, displacement).components[[0, 7, -1]]
    np.testing.assert_allclose(rows.reshape(-1, 6), there, atol=1e-12 * np.abs(there).max())


def one(**components: float) -> Stress:
    values = np.array([components.get(name, 0.0) for name in ("xx", "yy", "zz", "xy", "yz", "xz")])
    return Stress(values, np.zeros(3))


def test_invariants_of_simple_states() -> None:
    assert one(yy=-3.0).von_mises == pytest.approx(3.0)
    assert one(xz=2.0).von_mises == pytest.approx(2.0 * np.sqrt(3.0))
    assert one(xx=5.0, yy=5.0, zz=5.0).von_mises == 0.0
    np.testing.assert_allclose(one(xy=2.0).principal, [2.0, 0.0, -2.0], atol=1e-15)
    np.testing.assert_allclose(one(xx=1.0, yy=4.0, zz=-2.0).principal, [4.0, 1.0, -2.0])
    assert one(yz=7.0)["yz"] == 7.0


@given(
    st.lists(st.floats(-1e9, 1e9), min_size=6, max_size=6),
    st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3),
)
def test_invariants_do_not_turn_with_the_axes(values: list[float], angles: list[float]) -> None:
    stress = Stress(np.array(values), np.zeros(3))
    turn = Rotation.from_rotvec(angles).as_matrix()
    turned = turn @ stress.tensor @ turn.T
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    other = Stress(np.array([turned[place] for place in places]), np.zeros(3))
    size = max(map(abs, values)) + 1.0
    np.testing.assert_allclose(other.principal, stress.principal, atol=1e-12 * size)
    np.testing.assert_allclose(other.von_mises, stress.von_mises, atol=1e-7 * size)
