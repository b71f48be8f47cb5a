"""Matrices by parts of their rows: the same numbers, and no copies."""

import numpy as np
import pytest
import scipy.sparse as sp
from bodies import sparse_random

from aoimpact.linalg import rows as rows_module
from aoimpact.linalg.rows import Rows, congruent, rows_of


def some_matrix(form):
    return form(sparse_random(60, seed=2) + np.eye(60))


@pytest.fixture
def in_parts(monkeypatch):
    monkeypatch.setattr(rows_module, "_LEAST", 50)


def test_products_by_parts_have_the_same_bits(in_parts):
    A = some_matrix(sp.csr_array)
    for x in np.random.default_rng(3).random(60), np.random.default_rng(3).random((60, 5)):
        parts = Rows(A)
        assert len(parts._parts) == 4
        assert np.array_equal(parts @ x, A @ x)


def test_rows_of_a_matrix_share_its_arrays():
    for A in some_matrix(sp.csr_array), some_matrix(sp.bsr_array).tobsr((3, 3)):
        height = 3 if A.format == "bsr" else 1
        some = rows_of(A, 2, 7)
        assert np.array_equal(some.toarray(), A.toarray()[2 * height : 7 * height])
        assert np.shares_memory(some.data, A.data)
        assert np.shares_memory(some.indices, A.indices)


def test_a_congruent_matrix_is_that_of_dense_arrays(in_parts):
    A, P = some_matrix(sp.csr_array).tobsr((3, 3)), some_matrix(sp.csr_array)[:, :12].tobsr((3, 2))
    dense = P.toarray().T @ A.toarray() @ P.toarray()
    np.testing.assert_allclose(congruent(A, P).toarray(), dense, rtol=1e-12, atol=1e-14)
