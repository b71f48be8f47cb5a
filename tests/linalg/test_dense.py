"""Eigenpairs by LAPACK called by its address."""

import numpy as np
import pytest
import scipy.linalg as la

import aoimpact as ao
from aoimpact.linalg import dense_modes


@pytest.mark.parametrize("count", [None, 5, 200])
def test_they_are_scipy_s_bit_for_bit(count: int | None) -> None:
    rng = np.random.default_rng(1)
    first, second = rng.standard_normal((2, 200, 200))
    stiffness, mass = first @ first.T, second @ second.T + 200.0 * np.eye(200)
    which = None if count is None else [0, count - 1]
    omega2, modes = la.eigh(stiffness, mass, subset_by_index=which)
    found = dense_modes(stiffness.copy(), mass.copy(), count)
    assert np.array_equal(found[0], omega2)
    assert np.array_equal(found[1], modes)


@pytest.mark.parametrize("count", [None, 5])
@pytest.mark.parametrize("dofs", [10, 200])
def test_a_mass_that_is_not_positive_is_refused(count: int | None, dofs: int) -> None:
    with pytest.raises(ao.SingularError, match="give both with all their digits"):
        dense_modes(np.eye(dofs), -np.eye(dofs), count)
