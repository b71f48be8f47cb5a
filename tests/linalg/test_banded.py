"""Factors within the band of a slender body's matrix, against closed forms and other factors."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

import aoimpact as ao
from aoimpact.linalg.pencil import Pencil
from aoimpact.linalg.solvers import LinearSolver, linear_solver

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)


def row_of_springs(n: int, *, ends: float) -> sp.csr_array:
    """Unit springs between n masses, and one of stiffness `ends` to the ground at either end."""
    K = sp.diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1])
    K = K.tolil()
    K[0, 0] = K[n - 1, n - 1] = 1.0 + ends
    return K.tocsr()


def shuffled(matrix: sp.csr_array) -> tuple[sp.csr_array, np.ndarray]:
    order = np.random.default_rng(1).permutation(matrix.shape[0])
    return matrix[order][:, order].tocsr(), order


def within_band(K: sp.csr_array) -> LinearSolver:
    return linear_solver(Pencil(K, sp.eye_array(K.shape[0], format="csr")), "banded")


def test_a_row_of_springs_in_any_order_deflects_like_a_string() -> None:
    """Springs held at both ends under a force P at x: P x (n + 1 - x) / (n + 1) there."""
    n, at = 200, 60
    K, order = shuffled(row_of_springs(n, ends=1.0))
    force = np.zeros(n)
    force[at - 1] = 3.0
    found = np.empty(n)
    found[order] = within_band(K).solve(force[order])
    x = np.arange(1, n + 1)
    exact = 3.0 * np.where(x <= at, x * (n + 1 - at), at * (n + 1 - x)) / (n + 1)
    np.testing.assert_allclose(found, exact, rtol=1e-11)


def test_several_loads_at_once() -> None:
    K, _ = shuffled(row_of_springs(50, ends=1.0))
    loads = np.random.default_rng(2).standard_normal((50, 3))
    np.testing.assert_allclose(K @ within_band(K).solve(loads), loads, atol=1e-11)


@pytest.mark.parametrize("ends", [0.0, -0.5])
def test_what_is_not_constrained_or_gives_energy_is_named(ends: float) -> None:
    K, _ = shuffled(row_of_springs(50, ends=ends))
    with pytest.raises(ao.SingularError, match="the stiffness matrix is singular"):
        within_band(K)


def test_a_mechanism_is_named_there_too() -> None:
    """Two halves of a slender bar, joined along one edge, clamped at one end."""
    bar = ao.box_mesh((0.5, 0.02, 0.02), (40, 1, 1), kind="hexahedron")
    left = bar.nodes[bar.cells][:, :, 0].mean(axis=1) < 0.25
    at_joint = np.flatnonzero(np.isclose(bar.nodes[:, 0], 0.25) & (bar.nodes[:, 2] > 0.01))
    cells, nodes = bar.cells.copy(), bar.nodes
    copies = len(nodes) + np.arange(len(at_joint))
    for old, new in zip(at_joint, copies, strict=True):
        cells[~left] = np.where(cells[~left] == old, new, cells[~left])
    mesh = ao.Mesh(np.vstack([nodes, nodes[at_joint]]), cells, "hexahedron")
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=[(lambda x: x[:, 0] == 0.0, "xyz")])
    tip = body.contact(point=(0.5, 0.0, 0.0), direction=(0, 0, 1), radius=0)
    with pytest.raises(ao.SingularError, match="mechanism"):
        ao.antioscillators(tip, 3, method="krylov", contact_time=9e-5, solver="banded")
