"""Check of a caller's stiffness and mass matrices, and their conversion to CSR of float64."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import PRINTED, FloatArray, InputError, InputTypeError, SingularError, finite_array, sp
from .superlu import CHECKED_DOFS, factorize

# Maximum number of entries: the core's offsets are int32.
_MOST_ENTRIES = np.iinfo(np.int32).max

# Upper limit of the largest entry of K, N/m, and of M, kg, and of its reciprocal. Products and
# ratios of entries are then far from overflow and underflow.
LARGEST = 1e60

# Largest ratio of masses on the diagonal of M. The smaller mass is lost in the rounding of the
# larger one from 1e16 on; the limit is far above that.
_APART = 1e20

# Number of inverse iterations to find a rigid motion. Each multiplies the component along φ, K φ =
# λ diag(K) φ, by PRINTED / (PRINTED + λ).
_INVERSE_ITERATIONS = 2


def symmetric_pair(K: Any, M: Any) -> tuple[sp.csr_array, sp.csr_array]:
    """Return stiffness and mass as float64 CSR, canonical, with int32 indices where they fit.

    Dense matrices, and sparse ones of any format and real type, are converted. A matrix already in
    the right form is not copied, and the caller's arrays are never written to.

    Raises
    ------
    InputTypeError
        If K or M is not a matrix of real numbers.
    InputError
        If K or M is not square, finite and symmetric, the shapes differ, or both have fewer entries
        than rows.
    """
    with np.errstate(over="ignore"):  # what overflows is reported as not finite
        stiffness, mass = sound_matrix("K", K), sound_matrix("M", M)
    if stiffness.shape != mass.shape:
        raise InputError(
            f"K and M must be of the same shape, got {stiffness.shape} and {mass.shape}"
        )
    # Check sizes first: CSR of a few entries in a shape of 10⁹ rows would store 10⁹ row pointers.
    if sp.issparse(stiffness) and sp.issparse(mass):
        entries, rows = stiffness.nnz + mass.nnz, mass.shape[0]
        if entries < rows:
            raise InputError(
                f"every dof must have stiffness or mass: K and M have {entries} entries in {rows} "
                "rows; leave out dofs that have neither"
            )
    pair = _symmetric_csr("K", stiffness), _symmetric_csr("M", mass)
    for name, matrix, unit in (("K", pair[0], "N/m"), ("M", pair[1], "kg")):
        largest = float(np.abs(matrix.data).max(initial=0.0))
        if largest > LARGEST or 0.0 < largest < 1.0 / LARGEST:
            raise InputError(
                f"{name} has entries up to {largest:.3g} {unit}, whose products cannot be "
                f"computed; give it in {unit}"
            )
    return pair


def _symmetric_csr(name: str, checked: Any) -> sp.csr_array:
    csr = _canonical(sp.csr_array(checked))
    bad = np.flatnonzero(~np.isfinite(csr.data))
    if len(bad):
        row = int(np.searchsorted(csr.indptr, bad[0], side="right")) - 1
        raise InputError(
            f"{name} must be finite: {name}[{row}, {csr.indices[bad[0]]}] is {csr.data[bad[0]]}; "
            f"{len(bad)} entries are not finite"
        )
    return _symmetrised(name, csr)


def core_rows(matrix: Any) -> tuple[Any, ...]:
    """Return a sparse matrix's rows as the arrays of the core's ``aoi_sparse``.

    Raises
    ------
    InputError
        If the matrix has too many entries.
    """
    if matrix.nnz > _MOST_ENTRIES:
        raise InputError(
            f"a matrix of {matrix.shape[0]} dofs must have at most {_MOST_ENTRIES} entries, got "
            f"{matrix.nnz}; take a coarser mesh, or give the matrices sparse"
        )
    csr = matrix.tocsr()
    return (
        csr.indptr.astype(np.int32, copy=False),
        csr.indices.astype(np.int32, copy=False),
        csr.data,
    )


def check_stiffness(K: sp.csr_array) -> FloatArray | None:
    """Refuse a K that is not positive semidefinite, as far as cheap checks find out.

    Returns
    -------
    ndarray, shape (n,), or None
        A random combination of all motions without elastic force; if there are none, of soft
        motions, or noise. None beyond 10 000 dofs.

    Raises
    ------
    InputError
        If a diagonal entry, a principal minor of order 2 or (up to 10 000 dofs) an eigenvalue is
        negative.
    """
    diagonal = K.diagonal()
    # The zero eigenvalues of a K without supports become slightly negative if it was printed with
    # ten digits.
    _check_minors("K", K)
    if len(diagonal) > CHECKED_DOFS:
        return None
    # Each dof gets a spring of a small share of its own stiffness: the units of dofs do not matter.
    regular = K + sp.diags_array(np.where(diagonal > 0.0, PRINTED * diagonal, 1.0))
    try:
        factors = factorize(regular, what="K")
    except SingularError as error:
        raise InputError(
            f"K must be positive semidefinite, no motion may give energy back: {error}, with "
            f"{PRINTED:g} of its diagonal added; look for signs lost or entries missing "
            "where K was exported, and give it with all its digits"
        ) from None
    weight = regular.diagonal()
    motion = np.random.default_rng(3).standard_normal(K.shape[0]) / np.sqrt(weight)
    for _ in range(_INVERSE_ITERATIONS):
        motion = factors.solve(weight * motion)
        motion /= np.sqrt(motion @ (weight * motion))
    return motion if np.isfinite(motion).all() else None


def check_mass(M: sp.csr_array, K: sp.csr_array) -> None:
    """Refuse an M that is not positive semidefinite, and motions with neither mass nor stiffness.

    Motions with stiffness but no mass are accepted: rotations of lumped matrices, and motions of
    elements whose mass is integrated at few points (CalculiX' C3D10, C3D4, C3D8R). Such
    motions follow the forces without delay, as compliance and not as vibration.

    Raises
    ------
    InputError
        If a diagonal entry, a principal minor of order 2 or (up to 10 000 dofs) an eigenvalue is
        negative, the ratio of two masses is too large, or K + s²M is not positive definite.
    """
    diagonal = M.diagonal()
    _check_minors("M", M)
    most = int(np.argmax(diagonal))
    if diagonal[most] == 0.0:
        raise InputError("M must have mass on some dof: its diagonal is zero")
    least = int(np.argmin(np.where(diagonal > 0.0, diagonal, np.inf)))
    if diagonal[most] > _APART * diagonal[least]:
        raise InputError(
            f"M must have masses within a factor of {_APART:g}, got M[{least}, {least}] = "
            f"{diagonal[least]:g} kg and M[{most}, {most}] = {diagonal[most]:g} kg; constrain dofs "
            "that are too heavy to move, and give no mass to dofs with hardly any"
        )
    massless = np.flatnonzero(diagonal == 0.0)  # their rows are zero, by _check_minors
    bare = massless[K.diagonal()[massless] == 0.0]
    if len(bare):
        raise InputError(
            f"every dof must have stiffness or mass: {len(bare)} have neither, the first is row "
            f"{bare[0]}; leave them out of K and M"
        )
    if M.shape[0] > CHECKED_DOFS:
        return
    heavy = M + sp.diags_array(np.where(diagonal == 0.0, 1.0, 0.0), format="csr")
    definite = _is_definite(heavy)
    if definite and not len(massless):
        return
    if not (definite or _is_definite(heavy + PRINTED * sp.diags_array(diagonal, format="csr"))):
        raise InputError(
            "M must be positive semidefinite, no motion may have negative kinetic energy; look for "
            "signs lost or entries missing where M was exported, and give it with all its digits"
        )
    if not _is_definite(K + float(K.diagonal().sum() / diagonal.sum()) * M):
        which = f" ({len(massless)} dofs have no mass)" if len(massless) else ""
        raise InputError(
            f"some motion has neither mass nor stiffness{which}; condense it out, or take elements "
            "that integrate their mass in full"
        )


def _is_definite(matrix: sp.csr_array) -> bool:
    """Return whether all eigenvalues are positive beyond rounding."""
    try:
        factorize(matrix)
    except SingularError:
        return False
    return True


def _check_minors(name: str, matrix: sp.csr_array) -> None:
    """Refuse A_ii < 0 and A_ij² > A_ii A_jj: then xᵀA x < 0 for an x with entries i and j only."""
    diagonal = matrix.diagonal()
    if (diagonal < 0.0).any():
        worst = int(np.argmin(diagonal))
        raise InputError(
            f"{name} must have no negative entry on its diagonal, got {name}[{worst}, {worst}] = "
            f"{diagonal[worst]:g}"
        )
    root = np.sqrt(diagonal)
    row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    limit = root[row] * root[matrix.indices] * (1.0 + PRINTED) ** 0.5
    wrong = (np.abs(matrix.data) > limit) & (row != matrix.indices)
    if wrong.any():
        first = int(np.flatnonzero(wrong)[0])
        i, j = int(row[first]), int(matrix.indices[first])
        raise InputError(
            f"{name} must be positive semidefinite: {name}[{i}, {j}] = {matrix.data[first]:g} is "
            f"too large beside {name}[{i}, {i}] = {root[i] ** 2:g} and {name}[{j}, {j}] = "
            f"{root[j] ** 2:g}"
        )


def sound_matrix(name: str, matrix: Any) -> Any:
    """Return `matrix`, sparse or dense, as float64; refuse an invalid structure or shape."""
    if not sp.issparse(matrix):
        matrix = finite_array(name, matrix)
    elif (dtype := getattr(matrix, "dtype", np.dtype(object))).kind not in "iuf":
        raise InputTypeError(f"{name} must be a matrix of real numbers, got dtype {dtype}")
    else:
        try:
            matrix = _anew(matrix)
        except (ValueError, TypeError, AttributeError, IndexError, OverflowError) as error:
            raise InputError(
                f"{name} is not a valid sparse matrix: {error}; its arrays do not fit together, "
                "make it anew from rows, columns and values (scipy.sparse.coo_array)"
            ) from None
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or matrix.shape[0] == 0:
        raise InputError(f"{name} must be a square matrix, got shape {matrix.shape}")
    return matrix


def _anew(matrix: Any) -> Any:
    """Return a sparse matrix rebuilt from its checked arrays, without trusting its flags.

    SciPy's conversions trust the arrays: wrong indices write outside the allocated memory. Its
    astype would sort the caller's arrays in place.
    """
    if matrix.ndim == 2 and matrix.format in ("csr", "csc", "bsr"):
        # Contiguous, as the core needs them: A.real of a complex A is a strided view.
        indices, starts = map(_integers, (matrix.indices, matrix.indptr))
        if (starts[1:] < starts[:-1]).any():  # SciPy checks this only if there are entries
            raise ValueError("indptr must not descend")
        arrays = np.ascontiguousarray(matrix.data, np.float64), indices, starts
        anew = getattr(sp, f"{matrix.format}_array")(arrays, shape=matrix.shape)
        anew.check_format(full_check=True)
        return anew
    if matrix.format == "dia":  # SciPy writes out of bounds for offsets outside the shape
        (rows, columns), offsets = matrix.shape, _integers(matrix.offsets)
        if not all(-rows < offset < columns for offset in offsets):
            raise ValueError("offsets must be of diagonals that lie within the shape")
        return sp.dia_array((np.asarray(matrix.data, np.float64), offsets), shape=matrix.shape)
    if matrix.format == "lil" and list(map(len, matrix.rows)) != list(map(len, matrix.data)):
        raise ValueError("rows and data must have lists of the same lengths")
    coo = matrix.tocoo()
    coords = tuple(map(_integers, coo.coords))
    return sp.coo_array((np.asarray(coo.data, np.float64), coords), shape=coo.shape)


def _integers(value: Any) -> Any:
    array = np.ascontiguousarray(value)
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise ValueError(f"indices must be integers along one axis, got {array.dtype}")
    return array


def _canonical(csr: sp.csr_array) -> sp.csr_array:
    if not csr.has_canonical_format:
        csr = csr.copy()
        csr.sum_duplicates()
    return with_int32(csr)


def with_int32(matrix: Any) -> sp.csr_array:
    """Return a sorted CSR matrix without duplicates, with int32 indices if they fit."""
    if matrix.nnz <= _MOST_ENTRIES:
        matrix.indices = matrix.indices.astype(np.int32, copy=False)
        matrix.indptr = matrix.indptr.astype(np.int32, copy=False)
    matrix.has_canonical_format = True
    return matrix


def _symmetrised(name: str, csr: sp.csr_array) -> sp.csr_array:
    transposed = csr.T.tocsr()
    if np.array_equal(csr.indices, transposed.indices) and np.array_equal(
        csr.data, transposed.data
    ):
        return csr
    difference = (csr - transposed).tocoo()
    largest = float(np.abs(csr.data).max())
    gap = float(np.abs(difference.data).max(initial=0.0))  # no entries if only stored zeros differ
    if gap > PRINTED * largest:
        worst = int(np.argmax(np.abs(difference.data)))
        i, j = int(difference.row[worst]), int(difference.col[worst])
        raise InputError(
            f"{name} must be symmetric: {name}[{i}, {j}] = {csr[i, j]:.10g}, but "
            f"{name}[{j}, {i}] = {csr[j, i]:.10g}; only differences up to {PRINTED:g} of the "
            "largest entry count as rounding"
        )
    return _canonical(((csr + transposed) * 0.5).tocsr())
