"""Anyone's stiffness and mass matrices, put in the one form that is computed with, or refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg as la
import scipy.sparse as sp

from .errors import InputError, InputTypeError, SingularError
from .superlu import CHECKED_DOFS, Factorization, factorize

__all__ = [
    "check_entries",
    "check_mass",
    "check_stiffness",
    "core_rows",
    "motion_without_force",
    "symmetric_csr",
]

FloatArray = npt.NDArray[np.float64]

# Entries that the core's int32 offsets can count.
_MOST_ENTRIES = 2**31 - 1

# Asymmetry up to this fraction of the largest entry is rounding and is averaged away.
_ASYMMETRY = 1e-9

# Up to this many dofs definiteness is checked by LAPACK, up to CHECKED_DOFS by sparse factors.
_SMALL = 500

# A negative eigenvalue of K, relative to its diagonal, that passes for rounding: without supports
# the lowest ones are zero, and what prints K with ten digits makes them slightly negative.
_NEGATIVE = 1e-9

# Each takes what has stiffness down to that share of it, over its own.
_INVERSE_ITERATIONS = 2


def symmetric_csr(name: str, matrix: Any) -> sp.csr_array:
    """Return a symmetric matrix as float64 CSR, canonical, with int32 indices where they fit.

    Sparse matrices of any format and real type are converted, and dense ones; what is in the right
    form already is not copied, and the caller's arrays are never written to.

    Raises
    ------
    InputTypeError
        If it is not a matrix of real numbers.
    InputError
        If it is not square, finite and symmetric.
    """
    csr = _canonical(_real_csr(name, matrix))
    rows, columns = csr.shape
    if rows != columns or rows == 0:
        raise InputError(f"{name} must be square, got shape {csr.shape}")
    bad = np.flatnonzero(~np.isfinite(csr.data))
    if len(bad):
        row = int(np.searchsorted(csr.indptr, bad[0], side="right")) - 1
        raise InputError(
            f"{name} must be finite: {name}[{row}, {csr.indices[bad[0]]}] is {csr.data[bad[0]]}; "
            f"{len(bad)} entries are not finite"
        )
    return _symmetrised(name, csr)


def check_entries(matrix: Any) -> None:
    """Refuse a matrix of so many entries that the core cannot count them.

    Raises
    ------
    InputError
    """
    if matrix.nnz > _MOST_ENTRIES:
        raise InputError(
            f"a matrix of {matrix.shape[0]} dofs with {matrix.nnz} entries: at most {_MOST_ENTRIES}"
            " can be computed with; take a coarser mesh, or give the matrices sparse"
        )


def core_rows(matrix: Any) -> tuple[Any, ...]:
    """Return a sparse matrix's rows as the arrays of the core's ``aoi_sparse``.

    Raises
    ------
    InputError
        If it has too many entries.
    """
    check_entries(matrix)
    csr = matrix.tocsr()
    return (
        csr.indptr.astype(np.int32, copy=False),
        csr.indices.astype(np.int32, copy=False),
        csr.data,
    )


def check_stiffness(K: sp.csr_array) -> Factorization | None:
    """Refuse a K that is not positive semidefinite, as far as can be told at little cost.

    Returns
    -------
    Factorization or None
        Of K made regular, with a small share of its diagonal added, if that was needed.

    Raises
    ------
    InputError
        If a diagonal entry is negative, a principal minor of order 2 is, or (up to 10 000 dofs)
        an eigenvalue.
    """
    diagonal = K.diagonal()
    negative = np.flatnonzero(diagonal < 0.0)
    if len(negative):
        raise InputError(
            f"K has {len(negative)} negative entries on its diagonal, the first is "
            f"K[{negative[0]}, {negative[0]}] = {diagonal[negative[0]]:g} N/m; "
            "a stiffness matrix has none"
        )
    _check_minors("K", K, 1.0 + 1e-9)
    if len(diagonal) <= _SMALL:
        lowest = float(la.eigvalsh(K.toarray(), subset_by_index=[0, 0])[0])
        if lowest < -_NEGATIVE * float(diagonal.max()):
            raise InputError(
                f"K must be positive semidefinite: its lowest eigenvalue is {lowest:.4g} N/m"
            )
    elif len(diagonal) <= CHECKED_DOFS and not _dominated(K, 1.0 + _NEGATIVE):
        try:
            return factorize(_made_regular(K), what="K")
        except SingularError as error:
            raise InputError(
                f"K must be positive semidefinite, no motion may give energy back: {error}, with "
                f"{_NEGATIVE:g} of its diagonal added; look for signs lost or entries missing "
                "where K was exported, and give it with all its digits"
            ) from None
    return None


def _made_regular(K: sp.csr_array) -> sp.csr_array:
    """Hold each dof by a small share of its own stiffness, so that no scale of the dofs matters."""
    diagonal = K.diagonal()
    return K + sp.diags_array(np.where(diagonal > 0.0, _NEGATIVE * diagonal, 1.0))


def motion_without_force(K: sp.csr_array, factors: Factorization | None) -> FloatArray | None:
    """Return some motion that has a part of every one without elastic force, shape (n,).

    Where there is none it is a soft one, or nothing but rounding.

    Parameters
    ----------
    K : scipy.sparse.csr_array, shape (n, n)
    factors : Factorization or None
        From `check_stiffness`. Without them, K being of more than 500 dofs, the answer is None.
    """
    if factors is None:
        if K.shape[0] > _SMALL:
            return None
        factors = factorize(_made_regular(K), checked=False)
    weight = factors.matrix.diagonal()
    motion = np.random.default_rng(3).standard_normal(K.shape[0]) / np.sqrt(weight)
    for _ in range(_INVERSE_ITERATIONS):
        motion = factors.solve(weight * motion)
        motion /= np.sqrt(motion @ (weight * motion))
    return motion if np.isfinite(motion).all() else None


def check_mass(M: sp.csr_array) -> None:
    """Refuse an M that is not positive definite, as far as can be told at little cost.

    Raises
    ------
    InputError
        If a diagonal entry is not positive (a dof without mass), a principal minor of order 2 is
        not, or (up to 10 000 dofs) an eigenvalue is not.
    """
    diagonal = M.diagonal()
    bad = np.flatnonzero(diagonal <= 0.0)
    if len(bad):
        raise InputError(
            f"M must have mass on every dof: {len(bad)} of {len(diagonal)} diagonal entries are "
            f"zero or negative, the first is M[{bad[0]}, {bad[0]}] = {diagonal[bad[0]]:g} kg; "
            "condense such dofs out, or give them mass"
        )
    _check_minors("M", M, 1.0 - 1e-12)
    if len(diagonal) <= _SMALL:
        try:
            la.cholesky(M.toarray())
        except la.LinAlgError:
            lowest = float(la.eigvalsh(M.toarray(), subset_by_index=[0, 0])[0])
            raise InputError(
                f"M must be positive definite: its lowest eigenvalue is {lowest:.4g} kg"
            ) from None
    elif len(diagonal) <= CHECKED_DOFS and not _dominated(M, 1.0 - 1e-12):
        try:
            factorize(M, what="M")
        except SingularError as error:
            raise InputError(
                f"M must be positive definite, every motion must have kinetic energy: {error}; "
                "look for signs lost or entries missing where M was exported, or lump it"
            ) from None


def _dominated(matrix: sp.csr_array, factor: float) -> bool:
    """Whether factor · A_ii ≥ Σ |A_ij| in all rows: no eigenvalue is negative then (Gershgorin)."""
    diagonal = matrix.diagonal()
    others = abs(matrix).sum(axis=1) - np.abs(diagonal)
    return bool((factor * diagonal >= others).all())


def _check_minors(name: str, matrix: sp.csr_array, bound: float) -> None:
    """Refuse A_ij² > bound · A_ii A_jj: x with x_i = ±1, x_j = ±1 has negative energy then."""
    root = np.sqrt(matrix.diagonal())
    row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    limit = root[row] * root[matrix.indices] * bound**0.5
    wrong = (np.abs(matrix.data) > limit) & (row != matrix.indices)
    if wrong.any():
        first = int(np.flatnonzero(wrong)[0])
        i, j = int(row[first]), int(matrix.indices[first])
        needed = "positive definite" if bound < 1.0 else "positive semidefinite"
        raise InputError(
            f"{name} must be {needed}: {name}[{i}, {j}] = {matrix.data[first]:g} is too large "
            f"beside {name}[{i}, {i}] = {root[i] ** 2:g} and {name}[{j}, {j}] = {root[j] ** 2:g}"
        )


def _real_csr(name: str, matrix: Any) -> sp.csr_array:
    if not sp.issparse(matrix):
        if np.ma.is_masked(matrix):
            raise InputTypeError(f"{name} has masked entries; fill or remove them first")
        matrix = np.asarray(matrix)
        if matrix.ndim != 2:
            raise InputError(f"{name} must be a square matrix, got shape {matrix.shape}")
    if matrix.dtype.kind not in "iuf":
        raise InputTypeError(f"{name} must be a matrix of real numbers, got dtype {matrix.dtype}")
    if matrix.ndim != 2:
        raise InputError(f"{name} must be a square matrix, got shape {matrix.shape}")
    # astype also turns big-endian numbers into the machine's own.
    csr = sp.csr_array(matrix.astype(np.float64, copy=False))
    try:
        csr.check_format(full_check=True)
    except ValueError as error:
        raise InputError(f"{name} is not a valid sparse matrix: {error}") from None
    return csr


def _canonical(csr: sp.csr_array) -> sp.csr_array:
    if not csr.has_canonical_format:
        csr = csr.copy()
        csr.sum_duplicates()
    if csr.indices.dtype != np.int32 and csr.nnz < 2**31:
        parts = (csr.data, csr.indices.astype(np.int32), csr.indptr.astype(np.int32))
        csr = sp.csr_array(parts, shape=csr.shape)
        csr.has_canonical_format = True
    return csr


def _symmetrised(name: str, csr: sp.csr_array) -> sp.csr_array:
    transposed = csr.T.tocsr()
    if np.array_equal(csr.indices, transposed.indices) and np.array_equal(
        csr.data, transposed.data
    ):
        return csr
    difference = (csr - transposed).tocoo()
    largest = float(np.abs(csr.data).max())
    worst = int(np.argmax(np.abs(difference.data)))
    gap = float(np.abs(difference.data[worst]))
    if gap > _ASYMMETRY * largest:
        i, j = int(difference.row[worst]), int(difference.col[worst])
        raise InputError(
            f"{name} must be symmetric: {name}[{i}, {j}] = {csr[i, j]:.10g}, but "
            f"{name}[{j}, {i}] = {csr[j, i]:.10g}; only up to {_ASYMMETRY:g} of the largest entry "
            "passes for rounding"
        )
    return _canonical(((csr + transposed) * 0.5).tocsr())
