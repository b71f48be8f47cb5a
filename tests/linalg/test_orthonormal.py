"""M-orthonormal bases of what vectors add to a space."""

import numpy as np
import pytest

from aoimpact.linalg import m_orthonormal

from slender import beam


@pytest.mark.parametrize("apart", [1.0, 1e-4, 1e-7])
def test_a_basis_of_what_is_new_is_orthonormal_however_little_that_is(apart: float) -> None:
    M = beam(40, fixed=[0, 1])[1]
    vectors = np.random.default_rng(0).standard_normal((80, 10))
    space = m_orthonormal(None, vectors[:, :6], M)
    new = m_orthonormal(space, space[:, :4] + apart * vectors[:, 6:], M)
    whole = np.hstack([space, new])
    np.testing.assert_allclose(whole.T @ (M @ whole), np.eye(10), atol=1e-13)
    left = vectors - whole @ (whole.T @ (M @ vectors))
    assert np.abs(left).max() < 1e-13 / apart


def test_vectors_that_bring_nothing_new_or_no_mass_have_no_column() -> None:
    M = np.diag([1.0, 2.0, 3.0, 0.0])
    x, massless, whole = np.eye(4)[0], np.eye(4)[3], np.ones(4)
    basis = m_orthonormal(x[:, None], np.stack([x, whole, massless, x - whole], axis=1), M)
    np.testing.assert_allclose(basis[:, 0], np.array([0.0, 1.0, 1.0, 1.0]) / np.sqrt(5.0))
    assert basis.shape == (4, 1)
