"""Meshes of several kinds of elements: matrices, surface, groups, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from bodies import mixed_box, rigid_motions

import aoimpact as ao
from aoimpact.base import MeshError
from aoimpact.fem import gauss_stress, nodal_stress, stiffness_mass
from aoimpact.mesh import boundary

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
LENGTHS = (2.0, 1.5, 1.0)
both_orders = pytest.mark.parametrize("order", [1, 2])


def distorted(order: int) -> ao.Mesh:
    """The mixed box with its inner nodes pushed about: those of second order become curved."""
    mesh = mixed_box(LENGTHS, (2, 2, 3), order=order)
    inside = np.setdiff1d(np.arange(mesh.n_nodes), np.concatenate(list(mesh.node_sets.values())))
    nodes = mesh.nodes.copy()
    nodes[inside] += 0.02 * np.random.default_rng(2).uniform(-1, 1, (len(inside), 3))
    cells = [(block.kind, block.cells) for block in mesh.blocks]
    return ao.Mesh(nodes, cells, "mixed", mesh.node_sets, mesh.cell_sets)


@both_orders
def test_patch_constant_strain_and_rigid_motions(order: int) -> None:
    mesh = distorted(order)
    K, M = stiffness_mass(mesh, STEEL)
    gradient = np.random.default_rng(1).standard_normal((3, 3))
    u = (mesh.nodes @ gradient.T).reshape(-1)
    on_surface = np.zeros(mesh.n_nodes, dtype=bool)
    on_surface[boundary(mesh).nodes] = True
    rounding = (abs(K) @ np.abs(u)).max()
    assert np.abs((K @ u).reshape(-1, 3)[~on_surface]).max() < 1e-14 * rounding
    motions = rigid_motions(mesh.nodes)
    assert np.abs(K @ motions).max() < 1e-14 * (abs(K) @ np.abs(motions)).max()
    lowest = la.eigvalsh(K.toarray())
    assert lowest[6] > 1e-5 * lowest[-1] > 1e5 * abs(lowest[5])
    assert motions[:, 0] @ (M @ motions[:, 0]) == pytest.approx(STEEL.rho * 3.0, rel=1e-12)
    assert (K != K.T).nnz == 0


@both_orders
def test_stress_of_a_constant_strain(order: int) -> None:
    mesh = distorted(order)
    gradient = 1e-4 * np.random.default_rng(1).standard_normal((3, 3))
    moved = mesh.nodes @ gradient.T
    strain = 0.5 * (gradient + gradient.T)
    lam, mu = STEEL.lame
    exact = lam * np.trace(strain) * np.eye(3) + 2.0 * mu * strain
    at_nodes = nodal_stress(mesh, STEEL, moved).tensor
    assert at_nodes == pytest.approx(np.tile(exact, (mesh.n_nodes, 1, 1)), rel=1e-8, abs=1.0)
    inside = gauss_stress(mesh, STEEL, moved)["xx"]
    known = np.isfinite(inside)
    assert inside[known] == pytest.approx(exact[0, 0])
    for block in mesh.blocks:
        count = len(block.element.stiffness_rule.weights)
        assert known[block.numbers].sum(axis=1) == pytest.approx(count)


@pytest.mark.parametrize(("order", "rate"), [(1, 2.0), (2, 4.0)])
def test_frequencies_converge_with_twice_the_order(order: int, rate: float) -> None:
    """A bar that moves along z alone, through bricks, pyramids and tetrahedra: ω = π/2 c/L."""
    material = ao.Material(E=70e9, nu=0.0, rho=2700)
    exact = np.sqrt(70e9 / 2700) / 4.0
    errors = []
    for n in (4, 8):
        mesh = mixed_box((0.2, 0.2, 1.0), (2, 2, n), order=order)
        fixed = [(np.arange(mesh.n_nodes), "xy"), ("zmin", "z")]
        errors.append(ao.FEModel.from_mesh(mesh, material, fixed).frequencies(1)[0] / exact - 1.0)
    assert errors[1] > 0.0
    assert np.log2(errors[0] / errors[1]) == pytest.approx(rate, abs=0.3)


def joined(lower: ao.Mesh, upper: ao.Mesh, height: float) -> list[tuple[str, np.ndarray]]:
    nodes = np.vstack([lower.nodes, upper.nodes + np.array([0, 0, height])]).round(9)
    unique, number = np.unique(nodes, axis=0, return_inverse=True)
    number = number.ravel()
    cells = [(lower.kind, number[lower.cells]), (upper.kind, number[upper.cells + lower.n_nodes])]
    return [("nodes", unique), *cells]


@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        (("hexahedron", "tetra"), r"^mesh"),
        (("hexahedron20", "wedge"), None),
        (("tetra10", "tetra"), None),
    ],
)
def test_kinds_that_do_not_fit_are_refused(kinds: tuple[str, str], said: str | None) -> None:
    lower, upper = (ao.box_mesh((1, 1, 1), (2, 2, 2), kind=kind) for kind in kinds)
    (_, nodes), *cells = joined(lower, upper, 1.0)
    if kinds == ("hexahedron20", "wedge"):  # quadrilaterals on quadrilaterals: beside each other
        (_, nodes), *cells = joined(
            ao.Mesh(lower.nodes[:, [1, 2, 0]], lower.cells, lower.kind),
            ao.Mesh(upper.nodes[:, [1, 2, 0]], upper.cells, upper.kind),
            1.0,
        )
    mesh = ao.Mesh(nodes, cells)
    with pytest.raises(MeshError, match=said or r"^mesh"):
        ao.FEModel.from_mesh(mesh, STEEL)
