"""Factors of a sparse symmetric positive definite matrix by SuperLU, which is part of SciPy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import FloatArray, IntArray, MemoryLimitError, SingularError, sp
from .method import Inverse, Method, of_factors
from .pencil import Pencil

# Reciprocal condition number below which a factorised matrix counts as singular; rounding of the
# entries of a singular matrix leaves values of this size.
_SINGULAR = 2e-15

# Factor, to be multiplied by √n, of safety on the condition number that one inverse iteration from
# a random vector estimates.
_UNLUCKY = 100.0

# Dofs up to which the signs of the pivots are checked: SciPy copies all factors for access to them.
CHECKED_DOFS = 10_000

# Times, s, and bytes for `of_factors`: the times include four solutions that check the factors, the
# bytes both L and U with their indices. Estimates are 0.8 to 1.4 times the time and memory measured
# on 18 balls, blocks, plates, sheets and bars of 10 000 to 213 000 dofs (benchmarks/linear.py
# --direct).
_COST = of_factors((9.5e-11, 3.5e-8, 1.5e-9), 30.0, 0.0)


@dataclass(frozen=True)
class Factorization:
    """Factors of a sparse symmetric positive definite matrix.

    SciPy frees SuperLU's memory only if the thread that factorised releases the factors.

    Attributes
    ----------
    matrix : scipy.sparse.csc_matrix, shape (n, n)
        The matrix that was factorised.
    order : ndarray of int, shape (n,), or None
        Order of the rows and columns of `matrix` in the factors; None: unchanged.
    """

    matrix: Any
    _lu: Any
    order: IntArray | None = None

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return A⁻¹ `rhs`; `rhs` of shape (n,) or (n, m)."""
        solution, order = np.empty(rhs.shape), slice(None) if self.order is None else self.order
        solution[order] = self._lu.solve(rhs[order])
        return solution

    def of_bytes(self, rhs: bytes) -> FloatArray:
        """Return A⁻¹ `rhs` for the core, which passes `rhs` as the bytes of its doubles."""
        return self.solve(np.frombuffer(rhs))


def factorize(
    matrix: Any,
    *,
    what: str = "the matrix",
    order: IntArray | None = None,
) -> Factorization:
    """Factorise a sparse symmetric positive definite matrix with SuperLU.

    Without pivoting SuperLU's L U is L D Lᵀ.

    Parameters
    ----------
    matrix : scipy.sparse matrix, shape (n, n)
    what : str
        Name of the matrix in error messages.
    order : ndarray of int, shape (n,), optional
        Rows in the order of elimination; by minimum degree of A + Aᵀ if left out.

    Raises
    ------
    SingularError
        If the matrix is singular, exactly or to rounding, or (up to 10 000 dofs) has negative
        eigenvalues.
    """
    csc = sp.csc_matrix(matrix)
    try:
        lu = sp.linalg.splu(
            csc if order is None else sp.csc_matrix(csc[order][:, order]),
            permc_spec="MMD_AT_PLUS_A" if order is None else "NATURAL",
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
    factors = Factorization(csc, lu, order)
    check_condition(csc, factors.solve, what)
    # As many eigenvalues are negative as pivots are (Sylvester's law).
    if csc.shape[0] <= CHECKED_DOFS and (negative := np.count_nonzero(lu.U.diagonal() <= 0.0)):
        raise SingularError(f"{what} is not positive definite ({negative} negative pivots)")
    return factors


def check_condition(
    matrix: Any,
    solve: Callable[[FloatArray], FloatArray],
    what: str = "the matrix",
    *,
    diagonal: FloatArray | None = None,
) -> None:
    """Refuse a factorised matrix that is singular to rounding.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array or csc_array, shape (n, n)
        Symmetric, with A_ij² ≤ A_ii A_jj.
    solve : callable
        f ↦ A⁻¹ f by the factors.
    what : str, optional
        Name of the matrix in messages.
    diagonal : ndarray, shape (n,), optional
        Diagonal of the matrix, if that is known.

    Raises
    ------
    SingularError
        If λ_min / λ_max is below 2e-15. λ_min is found by inverse iterations (three, or one if
        that leaves no doubt); for λ_max its bound, the largest row sum, is taken.
    """
    # Scale to a unit diagonal, so that elements of very different size do not count as singular.
    scale = np.sqrt(np.abs(matrix.diagonal() if diagonal is None else diagonal))
    if (scale > 0.0).all():
        parts = np.abs(matrix.data), matrix.indices, matrix.indptr
        sizes = type(matrix)(parts, shape=matrix.shape)
        largest = float((sizes @ (1.0 / scale) / scale).max())
        x = np.random.default_rng(0).standard_normal(len(scale))
        # Inverse iteration estimates 1/λ_min from below. The first estimate accepts the matrix only
        # with a safety factor, the second never; the third is accurate enough without a factor.
        for short in (_UNLUCKY * len(scale) ** 0.5, np.inf, 1.0):
            with np.errstate(invalid="ignore"):  # an infinite x is refused
                x /= np.linalg.norm(x)
            x = scale * solve(scale * x)
            if short * float(np.linalg.norm(x)) * largest < 1.0 / _SINGULAR:
                return
    raise SingularError(f"{what} is singular to rounding")


def _set_up(pencil: Pencil) -> Inverse:
    # Without coordinates pencil.order is None, and SuperLU orders by minimum degree.
    return Inverse(factorize(pencil.matrix(), what=pencil.what, order=pencil.order).solve)


SUPERLU = Method("superlu", _set_up, _COST)
