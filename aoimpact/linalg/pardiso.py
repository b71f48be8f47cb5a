"""MKL PARDISO: factors of large sparse matrices, where the package py-mkl-pardiso is installed."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, MemoryLimitError, SingularError
from .fill import mean_width
from .superlu import check_condition

__all__ = ["Factors", "inverse", "is_installed"]


# Dofs in a cut above which nested dissection halves the work and the memory of the factors. Below,
# minimum degree gives as few entries, and looks for them a third as long.
_WIDE = 200.0

# PARDISO's iparm, counted from 0: the ordering, and the factorisation by two-level scheduling, up
# to 1.4 times as fast on wide fronts on one core, too.
_NARROW_OPTIONS = {1: 0}
_WIDE_OPTIONS = {1: 2, 23: 1}


def is_installed() -> bool:
    """Whether the package py-mkl-pardiso is there."""
    return importlib.util.find_spec("pymklpardiso") is not None


class Factors:
    """Factors of one sparse symmetric positive definite matrix after another.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array, shape (n, n)
    what : str
        Its name in messages.
    width : float, optional
    diagonal : ndarray, shape (n,), optional
        Its `mean_width` and its diagonal, if they are known.

    Raises
    ------
    InputError
        If the package is not installed.
    SingularError
        If the matrix is singular to rounding or not positive definite.
    """

    def __init__(
        self,
        matrix: Any,
        what: str,
        *,
        width: float | None = None,
        diagonal: FloatArray | None = None,
    ) -> None:
        self._solver = _pardiso(what)
        wide = (mean_width(matrix) if width is None else width) > _WIDE
        for place, value in (_WIDE_OPTIONS if wide else _NARROW_OPTIONS).items():
            self._solver.set_iparm(place, value)
        self._analyse(matrix, what, diagonal)

    def replace(self, matrix: Any, what: str, *, diagonal: FloatArray | None = None) -> None:
        """Factorise another matrix in place of the last one, for half the work or less.

        What was found out of the pattern is used again, if it is the same.
        """
        if not _same_pattern(matrix, self._pattern):
            self._analyse(matrix, what, diagonal)
            return
        self._factorise(self._solver.refactor_values, matrix, what, diagonal)

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return A⁻¹ `rhs`; `rhs` of shape (n,) or (n, m)."""
        solution: FloatArray = self._solver.solve(rhs)
        return solution

    def _analyse(self, matrix: Any, what: str, diagonal: FloatArray | None) -> None:
        matrix.sort_indices()
        self._pattern = (matrix.indptr, matrix.indices)
        n = matrix.shape[0]
        row = np.repeat(np.arange(n, dtype=matrix.indices.dtype), np.diff(matrix.indptr))
        self._upper = matrix.indices >= row
        starts = np.zeros(n + 1, dtype=np.int64)
        np.cumsum(np.bincount(row[self._upper], minlength=n), out=starts[1:])
        self._solver.set_pattern(ia=starts, ja=matrix.indices[self._upper].astype(np.int64), n=n)
        self._factorise(self._solver.factor, matrix, what, diagonal)

    def _factorise(
        self,
        by: Callable[[FloatArray], None],
        matrix: Any,
        what: str,
        diagonal: FloatArray | None,
    ) -> None:
        try:
            by(matrix.data[self._upper])
        except RuntimeError as error:  # PARDISO: "zero pivot / numerical factorization failure"
            if "memory" in str(error):
                raise MemoryLimitError(f"solver 'pardiso' of {what}: {error}") from None
            raise SingularError(f"{what} is singular or not positive definite ({error})") from None
        check_condition(matrix, self.solve, what, diagonal=diagonal)


def inverse(matrix: Any, what: str) -> Callable[[FloatArray], FloatArray]:
    """Factorise a sparse symmetric positive definite matrix; return f ↦ A⁻¹ f. See `Factors`."""
    return Factors(matrix, what).solve


def _pardiso(what: str) -> Any:
    """The package's compiled class.

    Its Python one looks at each row by itself, which takes as long as the rest on slender bodies.
    """
    try:
        from pymklpardiso import MTYPE_REAL_SYM_POSDEF
        from pymklpardiso._mkl_pardiso import PardisoSolver
    except ImportError as error:
        raise InputError(
            "solver='pardiso' needs the package py-mkl-pardiso (Linux and Windows on x86-64): "
            f"pip install 'aoimpact[direct]' ({error})"
        ) from None
    return PardisoSolver(MTYPE_REAL_SYM_POSDEF, 0)


def _same_pattern(matrix: Any, pattern: tuple[Any, Any]) -> bool:
    starts, indices = pattern
    return np.array_equal(matrix.indptr, starts) and np.array_equal(matrix.indices, indices)
