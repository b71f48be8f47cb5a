"""The matrix K + s²M of a body, which is never put together unless a solver needs it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

__all__ = ["Pencil"]

FloatArray = npt.NDArray[np.float64]

# Beside any stiffness nothing, and yet stored.
_ALMOST_ZERO = 1e-300


@dataclass(frozen=True, eq=False)
class Pencil:
    """The matrix K + s²M of a body, and where its rows are, for solvers that make use of it.

    Attributes
    ----------
    K, M : scipy.sparse.csr_array, shape (n, n)
    s2 : float
        s², (rad/s)².
    nodes : ndarray, shape (n_nodes, 3), optional
    free : ndarray of int, shape (n,), optional
        For each row its dof 3·node + component.
    mesh : Mesh, optional
    """

    K: Any
    M: Any
    s2: float = 0.0
    nodes: FloatArray | None = None
    free: npt.NDArray[np.int64] | None = None
    mesh: Any = None

    @property
    def n(self) -> int:
        return int(self.K.shape[0])

    @property
    def what(self) -> str:
        """What to call it in messages."""
        return "K + s²M" if self.s2 else "the stiffness matrix"

    def matrix(self) -> Any:
        """Return K + s²M as one matrix; K itself where s is zero.

        It has the pattern of K if M couples no more: what is found out of one serves the other.
        """
        if not self.s2:
            return self.K
        K = self.K
        if not K.data.all():  # SciPy leaves sums out that are zero
            data = np.where(K.data == 0.0, _ALMOST_ZERO, K.data)
            K = sp.csr_array((data, K.indices, K.indptr), shape=K.shape)
        return K + self.s2 * self.M

    def product(self, x: FloatArray) -> FloatArray:
        """Return (K + s²M) x without that matrix."""
        y: FloatArray = self.K @ x
        return y + self.s2 * (self.M @ x) if self.s2 else y

    @cached_property
    def scale(self) -> float:
        """The largest entry of the diagonal: the norm of the matrix is at least that."""
        return float((self.K.diagonal() + self.s2 * self.M.diagonal()).max())
