"""Cholesky factors of a narrow matrix within its band, by LAPACK: those of slender bodies.

Numbered from one end of the body to the other (reverse Cuthill-McKee) its dofs couple with their
neighbours in number only. The full blocks of such a band are factorised three to four times as
fast as sparse rows by SuperLU, though they hold more.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy
import scipy.sparse as sp

from ..base import FloatArray, SingularError
from .superlu import check_condition

__all__ = ["NARROW", "inverse"]


# Dofs in a cut (`mean_width`) up to which this takes half of SuperLU's time or less: measured on
# beams of 8- and 20-node hexahedra, .3 of it at 150 to 170, and on a plate, as long at 760.
NARROW = 250.0


def inverse(matrix: Any, what: str) -> Callable[[FloatArray], FloatArray]:
    """Factorise a sparse symmetric positive definite matrix; return f ↦ A⁻¹ f.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array, shape (n, n)
    what : str
        Its name in messages.

    Raises
    ------
    SingularError
        If the matrix is singular to rounding or not positive definite.
    """
    order = sp.csgraph.reverse_cuthill_mckee(matrix, symmetric_mode=True)
    try:
        band = scipy.linalg.cholesky_banded(
            _lower_band(matrix, order), overwrite_ab=True, lower=True, check_finite=False
        )
    except np.linalg.LinAlgError as error:
        raise SingularError(f"{what} is singular or not positive definite ({error})") from None

    def solve(rhs: FloatArray) -> FloatArray:
        solution = np.empty_like(rhs)
        solution[order] = scipy.linalg.cho_solve_banded(
            (band, True), rhs[order], check_finite=False
        )
        return solution

    check_condition(matrix, solve, what)
    return solve


def _lower_band(matrix: Any, order: npt.NDArray[np.int32]) -> FloatArray:
    """A_ij of the rows in order at [i - j, j], i ≥ j, column after column as LAPACK has it."""
    n = matrix.shape[0]
    place = np.empty_like(order)
    place[order] = np.arange(n, dtype=order.dtype)
    columns = place[matrix.indices]
    below = np.repeat(place, np.diff(matrix.indptr)) - columns
    lower = below >= 0
    band = np.zeros((n, 1 + int(below.max(initial=0))))
    band[columns[lower], below[lower]] = matrix.data[lower]
    return band.T
