"""Chebyshev smoothing of one level of multigrid, in the core and in single precision."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from .. import _core
from ..base import FloatArray, SingularError
from .blocks import Blocks, diagonal_places, in_stages

Single = npt.NDArray[np.float32]

# Chebyshev steps before and after each coarse-grid correction. With one step fewer, iterations rise
# by half; one step more saves no more than it costs.
_STEPS = 3

# `_LANCZOS_STEPS`: number of Lanczos steps, which underestimate λ_max of D⁻¹A by some percent.
# `_MARGIN`: factor on the result, to make up for this.
_LANCZOS_STEPS = 12
_MARGIN = 1.1


class Smoother:
    """Chebyshev smoother of the upper eigenvalues of D⁻¹A, with D the diagonal blocks of A.

    Parameters
    ----------
    blocks : Blocks
        A in the form that the core takes.
    A : scipy.sparse.bsr_array
        Symmetric positive definite.
    scale : float
        Divisor of the matrix, which brings it into the range of single precision.
    band : float
        The damped eigenvalues are λ_max / band … λ_max.
    what : str
        Name of the matrix in messages.

    Attributes
    ----------
    highest : float
        λ_max of D⁻¹A, with a margin.
    """

    def __init__(self, blocks: Blocks, A: Any, *, scale: float, band: float, what: str) -> None:
        diagonal = A.data[diagonal_places(A)]
        try:
            inverse = np.linalg.inv(diagonal / scale).astype(np.float64, copy=False)
        except np.linalg.LinAlgError:
            raise SingularError(f"{what} is singular: some dofs have no stiffness") from None
        single = np.empty(len(blocks.values), dtype=np.float32)
        np.divide(blocks.values, scale, out=single, casting="same_kind")
        self._matrix = blocks.pattern, single, inverse.astype(np.float32).reshape(-1)
        self._n, self._parts = diagonal.shape[0] * diagonal.shape[1], blocks.parts
        self._work = np.empty(blocks.work_length, dtype=np.float32)
        self.highest = _MARGIN * self._largest_eigenvalue(inverse, what)
        self._lowest = self.highest / band

    def subtract(self, x: Single, r: Single) -> None:
        """Subtract A x from `r` in place."""
        in_stages(2, self._parts, _core.blocks_subtract, self._matrix, x, r, self._work)

    def smooth(self, x: Single, r: Single, *, finish: bool) -> None:
        """Improve `x` in place, given r = f - A x; with `finish`, update `r` for the new `x`."""
        band = self._lowest, self.highest
        others = _STEPS, *band, finish, x, r, self._work
        in_stages(_STEPS + 1, self._parts, _core.blocks_smooth, self._matrix, *others)

    def _largest_eigenvalue(self, inverse: FloatArray, what: str) -> float:
        """Return λ_max of D⁻¹A by Lanczos' method in the inner product of D."""
        n, size = self._n, inverse.shape[1]
        w, before = np.random.default_rng(3).standard_normal(n), np.zeros(n)
        diagonal: list[float] = []
        off: list[float] = []
        for _ in range(min(_LANCZOS_STEPS, n)):
            z = np.matmul(inverse, w.reshape(-1, size, 1)).reshape(-1)  # D⁻¹ w
            square = inner(w, z)
            if square == 0.0:
                break  # the Krylov space is exhausted, and λ_max exact
            length = math.sqrt(max(square, 0.0)) or math.nan
            v, momentum = z / length, w / length
            product = np.zeros(n, dtype=np.float32)
            self.subtract(v.astype(np.float32), product)
            diagonal.append(-inner(v, product.astype(np.float64)))
            if not diagonal[-1] > 0.0:
                raise SingularError(f"{what} is singular or not positive definite")
            w = -product - diagonal[-1] * momentum - length * before
            off.append(length)
            before = momentum
        return float(scipy.linalg.eigvalsh_tridiagonal(diagonal, off[1:])[-1])


def inner(a: FloatArray, b: FloatArray) -> float:
    """Return aᵀb without BLAS, whose threads stay busy afterwards and change the last bits."""
    return float(np.einsum("i,i->", a, b))
