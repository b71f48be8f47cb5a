"""Factors within the band of a slender body's matrix, against closed forms and other factors."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

import aoimpact as ao
from aoimpact.linalg import banded

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


def test_a_row_of_springs_in_any_order_sags_like_a_string() -> None:
    """Springs held at both ends under a force P at x: P x (n + 1 - x) / (n + 1) there."""
    n, at = 200, 60
    K, order = shuffled(row_of_springs(n, ends=1.0))
    force = np.zeros(n)
    force[at - 1] = 3.0
    found = np.empty(n)
    found[order] = banded.inverse(K, "K")(force[order])
    x = np.arange(1, n + 1)
    exact = 3.0 * np.where(x <= at, x * (n + 1 - at), at * (n + 1 - x)) / (n + 1)
    np.testing.assert_allclose(found, exact, rtol=1e-11)


def test_several_loads_at_once() -> None:
    K, _ = shuffled(row_of_springs(50, ends=1.0))
    loads = np.random.default_rng(2).standard_normal((50, 3))
    np.testing.assert_allclose(K @ banded.inverse(K, "K")(loads), loads, atol=1e-11)


@pytest.mark.parametrize("ends", [0.0, -0.5])
def test_what_is_not_held_or_gives_energy_is_named(ends: float) -> None:
    K, _ = shuffled(row_of_springs(50, ends=ends))
    with pytest.raises(ao.SingularError, match="the chain is singular"):
        banded.inverse(K, "the chain")


@pytest.mark.parametrize("kind", ["hexahedron", "hexahedron20", "tetra10"])
def test_a_slender_body_s_static_mode_beside_superlu(kind: str) -> None:
    """The stiffness of its contact is what SuperLU gives with K itself."""
    mesh = ao.box_mesh((0.5, 0.02, 0.02), (40, 2, 2), kind=kind)
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    tip = body.contact(point=(0.25, 0.01, 0.02), direction=(0, 0, -1))
    exact = sp.linalg.spsolve(body.K.tocsc(), tip.b)
    for n in (1, 6):
        star = ao.antioscillators(tip, n, method="krylov", contact_time=9e-5, solver="superlu")
        assert star.origin.solver == "superlu"
        assert star.n == n
        assert star.k0 == pytest.approx(1.0 / (tip.b @ exact), rel=1e-9)


def test_a_mechanism_is_named_there_too() -> None:
    """Two halves of a slender bar, joined along one edge, held at one end."""
    bar = ao.box_mesh((0.5, 0.02, 0.02), (40, 1, 1), kind="hexahedron")
    left = bar.nodes[bar.cells][:, :, 0].mean(axis=1) < 0.25
    at_joint = np.flatnonzero(np.isclose(bar.nodes[:, 0], 0.25) & (bar.nodes[:, 2] > 0.01))
    cells, nodes = bar.cells.copy(), bar.nodes
    copies = len(nodes) + np.arange(len(at_joint))
    for old, new in zip(at_joint, copies, strict=True):
        cells[~left] = np.where(cells[~left] == old, new, cells[~left])
    mesh = ao.Mesh(np.vstack([nodes, nodes[at_joint]]), cells, "hexahedron")
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=[(lambda x: x[:, 0] == 0.0, "xyz")])
    tip = body.contact(point=(0.5, 0.0, 0.0), direction=(0, 0, 1))
    with pytest.raises(ao.SingularError, match="mechanism"):
        ao.antioscillators(tip, 3, method="krylov", contact_time=9e-5, solver="superlu")
