"""SuperLU: factors of a sparse symmetric positive definite matrix, which come with SciPy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from .. import _core
from ..base import FloatArray, MemoryLimitError, SingularError
from .fill import direct_seconds, factor_entries, graph_width
from .method import Inverse, Method
from .pencil import Pencil

__all__ = [
    "CHECKED_DOFS",
    "SUPERLU",
    "Factorization",
    "check_condition",
    "estimated_entries",
    "factorize",
]


# 1/condition below which a factorised matrix is taken for singular: the rounding of its entries
# alone could have made it so.
_SINGULAR = 2e-15

# By how much one inverse iteration may fall short of 1/condition, over √n: far more than a random
# start is at right angles to the softest motion.
_UNLUCKY = 100.0

# Dofs up to which the signs of the pivots are checked: SciPy copies all factors to show them.
CHECKED_DOFS = 10_000

# Entries of L and U together over n √w (`factor_entries`): 13 … 39 on balls, boxes, plates and bars
# of tetra10, hexahedra 8, 20 and 27 of 3 700 … 45 000 dofs, growing slowly.
_PER_ROOT_WIDTH = 40.0

# Seconds of the elimination over n w^(3/2): this gives .35 … 2.2 times the time of factorisations
# measured, of balls, boxes, plates and bars of tetra10, hexahedra 8 and 20 of 3 700 … 218 000 dofs
# (a bar of 51 000 dofs 2.8 s for 7.9 s, a plate of one layer 19.6 s for 8.9 s).
_PER_OPERATION = 2.5e-9

# Bytes per entry of L and U, each stored with an index.
_BYTES = 16.0


@dataclass(frozen=True)
class Factorization:
    """Factors of a sparse symmetric positive definite matrix.

    SciPy returns SuperLU's memory only where the thread that factorised drops the factors.

    Attributes
    ----------
    matrix : scipy.sparse.csc_matrix, shape (n, n)
        The matrix that was factorised.
    """

    matrix: Any
    _lu: Any

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return A⁻¹ `rhs`; `rhs` of shape (n,) or (n, m)."""
        solution: FloatArray = self._lu.solve(rhs)
        return solution

    def negative_pivots(self) -> int:
        """Return how many eigenvalues are negative: as many as pivots are (Sylvester's law)."""
        return int(np.count_nonzero(self._lu.U.diagonal() <= 0.0))

    def for_core(self) -> tuple[Any, ...]:
        """Return P A Pᵀ = L D Lᵀ as the arrays of the core's ``aoi_factors``."""
        place = self._lu.perm_r.astype(np.int32)
        if not np.array_equal(self._lu.perm_r, self._lu.perm_c):
            raise SingularError("the matrix needed pivoting, so it is not positive definite")
        lower = sp.tril(self._lu.L, k=-1, format="csc")
        lower.sort_indices()
        pivots = np.ascontiguousarray(self._lu.U.diagonal())
        start, rows = lower.indptr.astype(np.int32), lower.indices.astype(np.int32)
        panel = np.empty(len(start), dtype=np.int32)
        count = _core.factors_find_panels(start, rows, panel)
        return start, rows, np.ascontiguousarray(lower.data), pivots, place, panel[: count + 1]


def factorize(matrix: Any, *, what: str = "the matrix", checked: bool = True) -> Factorization:
    """Factorise a sparse symmetric positive definite matrix with SuperLU.

    Without pivoting and ordered by minimum degree of A + Aᵀ, SuperLU computes L D Lᵀ (as L U).

    Parameters
    ----------
    matrix : scipy.sparse matrix, shape (n, n)
    what : str
        Its name in error messages.
    checked : bool, optional
        Whether to check the factors, which costs some solutions; not needed for a preconditioner.

    Raises
    ------
    SingularError
        If the matrix is singular; if `checked`, also if it is so to rounding or (up to 10 000 dofs)
        has negative eigenvalues.
    """
    csc = sp.csc_matrix(matrix)
    try:
        lu = sp.linalg.splu(
            csc,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except MemoryError as error:
        raise MemoryLimitError(
            f"solver 'superlu' of {what} ({csc.shape[0]} dofs) ran out of memory: "
            "solver='multigrid' takes less"
        ) from error
    except RuntimeError as error:  # SuperLU: "Factor is exactly singular"
        raise SingularError(f"{what} is singular ({error})") from None
    factors = Factorization(csc, lu)
    if not checked:
        return factors
    check_condition(csc, factors.solve, what)
    if csc.shape[0] <= CHECKED_DOFS and (negative := factors.negative_pivots()):
        raise SingularError(f"{what} is not positive definite ({negative} negative pivots)")
    return factors


def check_condition(
    matrix: Any,
    solve: Callable[[FloatArray], FloatArray],
    what: str = "the matrix",
    *,
    diagonal: FloatArray | None = None,
) -> None:
    """Refuse a matrix whose factors are those of a singular one but for rounding.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array or csc_array, shape (n, n)
        Symmetric, with no entry beyond the diagonal's: A_ij² ≤ A_ii A_jj.
    solve : callable
        f ↦ A⁻¹ f by the factors.
    what : str, optional
        Its name in messages.
    diagonal : ndarray, shape (n,), optional
        Its diagonal, if that is known.

    Raises
    ------
    SingularError
        If λ_min / λ_max, by inverse iterations (three, or one where that leaves no doubt) and the
        largest row sum, is below 2e-15.
    """
    scale = np.sqrt(np.abs(matrix.diagonal() if diagonal is None else diagonal))
    if not (scale > 0.0).all() or not _is_regular(matrix, solve, scale):
        raise SingularError(f"{what} is singular to rounding")


def _is_regular(matrix: Any, solve: Callable[[FloatArray], FloatArray], scale: FloatArray) -> bool:
    # Scaled by its diagonal, so that elements of very different size do not count as singular.
    x = np.random.default_rng(0).standard_normal(len(scale))
    inverse = 0.0
    for iteration in range(3):
        x /= np.linalg.norm(x)
        x = scale * solve(scale * x)
        inverse = float(np.linalg.norm(x))
        if not np.isfinite(inverse):
            return False
        if iteration == 0:
            most = 1.0 / (_SINGULAR * _UNLUCKY * np.sqrt(len(x)) * inverse)
            if float(np.diff(matrix.indptr).max()) < most:  # a row sum of entries up to 1
                return True
            largest = _largest_sum(matrix, scale)
            if largest < most:
                return True
    return inverse * largest < 1.0 / _SINGULAR


def _largest_sum(matrix: Any, scale: FloatArray) -> float:
    sizes = type(matrix)((np.abs(matrix.data), matrix.indices, matrix.indptr), shape=matrix.shape)
    return float((sizes @ (1.0 / scale) / scale).max())


def estimated_entries(matrix: Any) -> float:
    """Estimate how many entries the factors of a matrix have together, to a factor of about 2."""
    return factor_entries(int(matrix.shape[0]), graph_width(matrix), _PER_ROOT_WIDTH)


def _set_up(pencil: Pencil) -> Inverse:
    return Inverse(factorize(pencil.matrix(), what=pencil.what).solve)


def _entries(pencil: Pencil) -> float:
    return factor_entries(pencil.n, pencil.width, _PER_ROOT_WIDTH)


def _memory(pencil: Pencil) -> float:
    return _BYTES * _entries(pencil)


def _seconds(pencil: Pencil, solutions: int) -> float:
    return direct_seconds(
        pencil.n,
        pencil.width,
        _entries(pencil),
        solutions,
        per_operation=_PER_OPERATION,
    )


SUPERLU = Method("superlu", _set_up, _memory, _seconds)
