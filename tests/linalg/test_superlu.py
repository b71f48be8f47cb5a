"""Factorisations: exact on what is definite, honest about what is not."""

import os
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

import aoimpact as ao
from aoimpact.linalg import factorize

from slender import beam

STATM = Path("/proc/self/statm")


def test_a_solution_leaves_no_residual():
    K, M = beam(500, fixed=[0, 1])
    b = np.random.default_rng(0).standard_normal(1000)
    A = K + 1e4 * M
    x = factorize(A).of_bytes(b.tobytes())
    backward_error = np.abs(A @ x - b) / (abs(A) @ np.abs(x) + np.abs(b))
    assert backward_error.max() < 1e-13


@pytest.mark.skipif(not STATM.exists(), reason="reads the process's memory from /proc")
def test_memory_of_factors_is_given_back():
    """SciPy gives it back only to the thread that took it."""

    def resident():
        return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    line = sp.diags_array([-1.0, 2.1, -1.0], offsets=[-1, 0, 1], shape=(16, 16))
    matrix = sp.kronsum(sp.kronsum(line, line), line)  # a cube of springs
    factorize(matrix)
    alike = sp.linalg.splu(sp.csc_array(matrix), permc_spec="MMD_AT_PLUS_A")
    size = 16 * (alike.L.nnz + alike.U.nnz)
    first = resident()
    for _ in range(12):
        factorize(matrix)
    assert resident() - first < 4 * size


def test_elements_of_very_different_size_are_not_called_singular():
    k = np.geomspace(1.0, 1e12, 60)
    K = sp.diags([k + np.append(k[1:], 0.0), -k[1:], -k[1:]], [0, 1, -1]).tocsr()
    ones = np.ones(60)
    np.testing.assert_allclose(factorize(K).solve(K @ ones), ones, rtol=1e-3)


def test_indefinite_matrices_are_refused_with_the_number_of_negative_eigenvalues():
    """As many pivots are negative as eigenvalues (Sylvester): three springs pushed, not pulled."""
    K = sp.diags([2.0, -1.0, -1.0], [0, 1, -1], shape=(1000, 1000)).tolil()
    for place in (100, 500, 900):
        K[place, place] = 0.5
    assert (np.linalg.eigvalsh(K.toarray()) < 0.0).sum() == 3
    with pytest.raises(ao.SingularError, match=r"^K"):
        factorize(K, what="K")
