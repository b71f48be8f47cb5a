"""Chebyshev smoothing of one level of multigrid, in the core and in single precision."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from .. import _core
from ..base import FloatArray, SingularError

__all__ = ["Smoother", "diagonal_blocks", "upper_blocks", "work_length"]

Single = npt.NDArray[np.float32]

# Steps before and after each correction: one fewer takes half as many iterations again, one more
# saves what it costs.
_STEPS = 3

# AOI_BLOCKS_WORK of csrc/linear/multigrid.h; the core refuses work space of any other length.
_WORK = 3

# Lanczos steps for λ_max of D⁻¹A, which they find to some percent from below; hence the margin.
_LANCZOS_STEPS = 12
_MARGIN = 1.1


class Smoother:
    """Damps the upper eigenvalues of D⁻¹A, with D the diagonal blocks of A.

    Parameters
    ----------
    A : scipy.sparse.bsr_array
        Symmetric positive definite, blocks b x b, with every diagonal block stored.
    scale : float
        What the matrix is divided by, so that single precision holds it.
    band : float
        The eigenvalues damped are λ_max / band … λ_max.
    what : str
        The matrix in messages.

    Attributes
    ----------
    highest : float
        λ_max of D⁻¹A, with a margin.
    """

    def __init__(self, A: Any, *, scale: float, band: float, what: str) -> None:
        try:
            inverse = np.linalg.inv(diagonal_blocks(A) / scale).astype(np.float64, copy=False)
        except np.linalg.LinAlgError:
            raise SingularError(f"{what} is singular: some dofs have no stiffness") from None
        indptr, indices, values = upper_blocks(A)
        single = np.empty(len(values), dtype=np.float32)
        np.divide(values, scale, out=single, casting="same_kind")
        self._matrix = indptr, indices, single, inverse.astype(np.float32).reshape(-1)
        self._n = A.shape[0]
        self._work = np.empty(work_length(A), dtype=np.float32)
        self.highest = _MARGIN * self._largest_eigenvalue(inverse, what)
        self._lowest = self.highest / band

    def subtract(self, x: Single, r: Single) -> None:
        """Do r -= A x."""
        _core.blocks_subtract(self._matrix, x, r, self._work)

    def smooth(self, x: Single, r: Single, *, finish: bool) -> None:
        """Improve `x` in place, r = f - A x; with `finish` that holds for `r` afterwards too."""
        _core.blocks_smooth(
            self._matrix, _STEPS, self._lowest, self.highest, finish, x, r, self._work
        )

    def _largest_eigenvalue(self, inverse: FloatArray, what: str) -> float:
        """λ_max of D⁻¹A by Lanczos' method, written as conjugate gradients."""
        n, size = self._n, inverse.shape[1]
        r = np.random.default_rng(3).standard_normal(n)
        p, rz_before = np.zeros(n), 1.0
        diagonal, off = [], []
        ratio = step = 0.0
        for k in range(min(_LANCZOS_STEPS, n)):
            z = np.matmul(inverse, r.reshape(-1, size, 1)).reshape(-1)
            rz = float(r @ z)
            if rz == 0.0:
                break  # the space is used up: what was found is exact
            ratio = rz / rz_before if k else 0.0
            p = z + ratio * p
            product = np.zeros(n, dtype=np.float32)
            self.subtract(p.astype(np.float32), product)
            curvature = -float(p @ product)
            if rz < 0.0 or not curvature > 0.0:
                raise SingularError(f"{what} is singular or not positive definite")
            if k:
                off.append(np.sqrt(ratio) / step)
            previous = ratio / step if k else 0.0
            step = rz / curvature
            diagonal.append(1.0 / step + previous)
            r = r + step * product
            rz_before = rz
        return float(scipy.linalg.eigvalsh_tridiagonal(diagonal, off)[-1])


def upper_blocks(A: Any) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32], FloatArray]:
    """Return row starts, columns and entries of a symmetric BSR matrix without its lower blocks.

    The core reads each pair of blocks from memory once. Blocks of a row must be in order.
    """
    row = np.repeat(np.arange(len(A.indptr) - 1), np.diff(A.indptr))
    kept = A.indices >= row
    indptr = np.zeros(len(A.indptr), dtype=np.int32)
    np.cumsum(np.bincount(row[kept], minlength=len(indptr) - 1), out=indptr[1:])
    return indptr, A.indices[kept].astype(np.int32, copy=False), A.data[kept].reshape(-1)


def work_length(A: Any) -> int:
    """How many numbers the core wants as work space for products and smoothing of a BSR matrix."""
    n, size = int(A.shape[0]), int(A.blocksize[0])
    return _WORK * (n // size) * (size + 1)


def diagonal_blocks(A: Any) -> FloatArray:
    """Return the diagonal blocks of a BSR matrix that stores them all, shape (n, b, b)."""
    row = np.repeat(np.arange(len(A.indptr) - 1), np.diff(A.indptr))
    found: FloatArray = A.data[A.indices == row]
    return found
