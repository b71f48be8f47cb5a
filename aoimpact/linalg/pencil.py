"""The matrix K + s²M of a body, which is never put together unless a solver needs it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..base import ArrayPair, FloatArray, IntArray, sp
from .blocks import Rows
from .dissection import Fill, fill, nested_dissection

# Negligible, but non-zero so that the sparse entry is kept.
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
        For each row its dof: 3·node + component, and 3·n_nodes more of rotations.
    mesh : Mesh, optional
    origin : Pencil, optional
        The pencil of another shift from which this one was taken; what depends on no shift is
        computed once, there.
    """

    K: Any
    M: Any
    s2: float = 0.0
    nodes: FloatArray | None = None
    free: IntArray | None = None
    mesh: Any = None
    origin: Pencil | None = None

    def at(self, s2: float) -> Pencil:
        """Return that of another shift, with what is known of this one's parts."""
        return replace(self, s2=s2, origin=self.origin or self)

    @cached_property
    def fill(self) -> Fill:
        """Estimate of the factors."""
        return self.origin.fill if self.origin else fill(self.K, self.places)

    @cached_property
    def order(self) -> IntArray | None:
        """Rows in an order of elimination; None if their coordinates are not known."""
        if self.origin:
            return self.origin.order
        return None if self.places is None else nested_dissection(self.K, self.places)

    @property
    def places(self) -> FloatArray | None:
        """Coordinates of the rows, shape (n, 3), if they are known."""
        if self.nodes is None or self.free is None:
            return None
        found: FloatArray = self.nodes[self.free // 3 % len(self.nodes)]
        return found

    @cached_property
    def diagonal(self) -> FloatArray:
        """Diagonal of K + s²M, shape (n,)."""
        found: FloatArray = self.K.diagonal() + self.s2 * self.M.diagonal()
        return found

    @property
    def rotates(self) -> bool:
        """True of shells and beams, which have rotations of nodes beside displacements."""
        if self.nodes is None or self.free is None:
            return False
        return bool(self.free.max() >= 3 * len(self.nodes))

    @property
    def n(self) -> int:
        return int(self.K.shape[0])

    @property
    def what(self) -> str:
        """Name of the matrix in messages."""
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

    def products(self, x: FloatArray) -> ArrayPair:
        """Return K x and M x."""
        K, M = self._rows
        return K @ x, M @ x

    def momentum(self, x: FloatArray) -> FloatArray:
        """Return M x."""
        return self._rows[1] @ x

    @cached_property
    def _rows(self) -> tuple[Rows, Rows]:
        return Rows(self.K), Rows(self.M)

    @cached_property
    def scale(self) -> float:
        """The largest entry of the diagonal: the norm of the matrix is at least that."""
        return float(self.diagonal.max())
