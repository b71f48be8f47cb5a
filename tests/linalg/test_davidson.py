"""The lowest modes by V-cycles: those of a dense solution, multiple ones and all."""

from functools import partial

import numpy as np
import pytest
import scipy.linalg as la
from bodies import ball_of_octants

import aoimpact as ao
from aoimpact.linalg import lowest

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)


def by_multigrid(body, n):
    invert = partial(body.inverse, solver="multigrid")
    return lowest(body.K, body.M, n, known=body.rigid_modes, invert=invert)


def check_orthonormal(body, modes):
    gram = modes.T @ (body.M @ modes)
    np.testing.assert_allclose(gram, np.eye(len(gram)), atol=1e-10)


@pytest.fixture(scope="module")
def ball():
    return ao.FEModel.from_mesh(ball_of_octants(0.01, 4), STEEL)


@pytest.mark.parametrize("n", [8, pytest.param(16, marks=pytest.mark.slow)])
def test_modes_of_a_free_ball_come_in_fives_and_threes(ball, n):
    """A ball's lowest modes: five of one frequency, then five of another."""
    omega2, modes = by_multigrid(ball, n)
    by_factors = lowest(ball.K, ball.M, n, known=ball.rigid_modes)[0]
    np.testing.assert_allclose(omega2, by_factors, rtol=1e-8)
    check_orthonormal(ball, modes)
    np.testing.assert_array_equal(omega2[:6], 0.0)


def test_modes_of_a_slender_bar_are_all_found() -> None:
    """V-cycles turn random vectors towards the lowest of 40 modes, 6 decades apart in ω²."""
    mesh = ao.box_mesh((1.0, 0.02, 0.02), (24, 2, 2), kind="hexahedron")
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])
    found = ao.modal(body.contact(point=(0.5, 0.01, 0.02)), 40, solver="multigrid").frequencies
    omega2 = la.eigh(body.K.toarray(), body.M.toarray(), eigvals_only=True)[:40]
    assert found == pytest.approx(np.sqrt(omega2) / (2.0 * np.pi), rel=1e-6)
