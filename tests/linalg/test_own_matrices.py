"""Matrices of more entries than the core can count, and those that do not hold together."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from rows import each

import aoimpact as ao
from aoimpact.linalg import core_rows


def test_rows_for_the_core_are_the_matrix() -> None:
    """Also where SciPy counts in int64."""
    random = np.random.default_rng(0)
    K = sp.csr_array(random.standard_normal((9, 9)) * (random.uniform(size=(9, 9)) < 0.4))
    wide = sp.csr_array((K.data, K.indices.astype(np.int64), K.indptr.astype(np.int64)), K.shape)
    starts, columns, values = core_rows(wide)
    assert starts.dtype == columns.dtype == np.int32
    same = sp.csr_array((values, columns, starts), shape=K.shape)
    np.testing.assert_array_equal(same.toarray(), K.toarray())


# ------------------------------------------------------------- structures that do not hold together

N = 12
CHAIN = sp.diags_array([-1e6, 2e6, -1e6], offsets=[-1, 0, 1], shape=(N, N)).tocsr()
FORMATS = ("csr", "csc", "coo", "bsr", "dia", "lil", "dok")


def with_number(matrix: Any, name: str, at: int, number: int) -> Any:
    """The same with one number of an index array replaced, as a program that errs leaves it."""
    array = np.array(getattr(matrix, name))
    array.reshape(-1)[at] = number
    setattr(matrix, name, array)
    return matrix


def unordered_with_starts(starts: int) -> Any:
    """Single precision and columns out of order, which SciPy puts in order while it converts."""
    matrix = CHAIN.astype(np.float32)
    matrix.indices[:2] = matrix.indices[:2][::-1].copy()
    matrix.has_sorted_indices = matrix.has_canonical_format = False
    return with_number(matrix, "indptr", 7, starts)


def empty_with_starts_inside() -> Any:
    matrix = sp.csr_array((N, N))
    matrix.indptr[3:5] = 2**30
    return matrix


def longer_list() -> Any:
    matrix = CHAIN.tolil()
    matrix.data[2] = [*matrix.data[2], 1.0]
    return matrix


def shape_of_a_milliard() -> Any:
    matrix = CHAIN.tocoo()
    matrix._shape = (10**9, 10**9)
    return matrix


# A format, the array of its structure, and where that has what number; or a matrix as a whole.
BROKEN: list[Any] = [
    *(("csr", "indices", 5, 2**31 - 1), ("csr", "indices", 5, -3), ("csr", "indptr", 0, 1)),
    *(("csc", "indices", 5, 2**31 - 1), ("csc", "indptr", 3, 999), ("dia", "offsets", 0, 2**30)),
    *(("bsr", "indices", 1, 99), ("bsr", "indptr", 2, 999)),
    *(lambda starts=starts: unordered_with_starts(starts) for starts in (2**31 - 1, 1)),
    *(empty_with_starts_inside, longer_list, shape_of_a_milliard),
]


@each("name", ["K", "M"])
@each("what", BROKEN)
def test_broken_structures_are_refused_by_name(what: Any, name: str) -> None:
    made = what() if callable(what) else with_number(CHAIN.asformat(what[0], copy=True), *what[1:])
    matrices = {"K": CHAIN, "M": sp.eye_array(N, format="csr")} | {name: made}
    with pytest.raises(ao.InputError, match=rf"\b{name}\b"):
        ao.FEModel(**matrices)


def test_the_real_part_of_a_complex_matrix_is_a_matrix() -> None:
    """SciPy gives a view of every other number, which the core does not take."""
    K, M = CHAIN.astype(complex).real, sp.eye_array(N, format="csr", dtype=complex).real
    assert not K.data.flags.c_contiguous
    found = [
        ao.antioscillators(ao.FEModel(K=k, M=m).contact(dof=1), 1, method="krylov").frequencies
        for k, m in ((K, M), (CHAIN, np.eye(N)))
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-12)


@each("kind", ["array", "matrix"])
@each("format", FORMATS)
def test_every_format_is_the_same_matrix(format: str, kind: str) -> None:
    """Whatever its flags say, and in whatever order its entries are."""
    K = getattr(sp, f"{format}_{kind}")(CHAIN)
    if hasattr(K, "has_sorted_indices"):
        K.has_sorted_indices = K.has_canonical_format = False
    body = ao.FEModel(K=K, M=getattr(sp, f"{format}_{kind}")(np.eye(N, dtype=np.float32)))
    assert np.array_equal(body.K.toarray(), CHAIN.toarray())
    assert np.array_equal(body.M.toarray(), np.eye(N))


def test_the_callers_arrays_are_not_put_in_order() -> None:
    K = CHAIN.astype(np.float32)
    K.indices[:2], K.data[:2] = K.indices[:2][::-1].copy(), K.data[:2][::-1].copy()
    K.has_sorted_indices = K.has_canonical_format = False
    before = K.indices.copy(), K.data.copy()
    body = ao.FEModel(K=K, M=np.eye(N))
    assert np.array_equal(body.K.toarray(), CHAIN.toarray())
    assert np.array_equal(K.indices, before[0])
    assert np.array_equal(K.data, before[1])


def test_equal_eigenvalues_by_the_hundred_take_no_call_of_arpack_each() -> None:
    """600 dofs on equal springs; to find every member of the lowest eigenvalue took 600 calls."""
    body = ao.FEModel(K=sp.eye_array(600), M=sp.eye_array(600))
    start = time.process_time()
    assert body.frequencies(3) == pytest.approx([0.5 / np.pi] * 3)
    assert time.process_time() - start < 5.0
