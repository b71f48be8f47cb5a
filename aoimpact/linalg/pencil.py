"""The matrix K + s²M of a body, which is formed only if a solver needs it."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ..base import ArrayPair, FloatArray, IntArray, record
from .blocks import ENTRIES_AT_ONCE, product, rows_of
from .dissection import Fill, fill, nested_dissection


@record
class Pencil:
    """The matrix K + s²M of a body, and the coordinates of its rows for solvers that use them.

    Attributes
    ----------
    K, M : scipy.sparse.csr_array, shape (n, n)
    s2 : float
        s², (rad/s)².
    nodes : ndarray, shape (n_nodes, 3), optional
        Coordinates of the nodes, m.
    free : ndarray of int, shape (n,), optional
        Dof of each row: 3·node + component, and 3·n_nodes more for rotations.
    mesh : Mesh, optional
    origin : Pencil, optional
        Pencil of another shift from which this one was made; the origin computes and holds what
        does not depend on the shift.
    """

    K: Any
    M: Any
    s2: float = 0.0
    nodes: FloatArray | None = None
    free: IntArray | None = None
    mesh: Any = None
    origin: Pencil | None = None

    def at(self, s2: float) -> Pencil:
        """Return the pencil of another shift, which shares what does not depend on the shift."""
        return replace(self, s2=s2, origin=self.origin or self)

    @cached_property
    def fill(self) -> Fill:
        """Estimated size and cost of the factors."""
        return self.origin.fill if self.origin else fill(self.K, self.places)

    @cached_property
    def order(self) -> IntArray | None:
        """Rows in an order of elimination; None if their coordinates are not known."""
        if self.origin:
            return self.origin.order
        return None if self.places is None else nested_dissection(self.K, self.places)

    @property
    def places(self) -> FloatArray | None:
        """Coordinates of the rows, m, shape (n, 3); None if unknown."""
        if self.nodes is None or self.free is None:
            return None
        found: FloatArray = self.nodes[self.free // 3 % len(self.nodes)]
        return found

    @cached_property
    def diagonal(self) -> FloatArray:
        """Diagonal of K + s²M, shape (n,)."""
        return np.asarray(self.K.diagonal() + self.s2 * self.M.diagonal())

    @property
    def rotates(self) -> bool:
        """True if nodes have rotations besides displacements, as in shells and beams."""
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
        """Return K + s²M as one matrix; K itself if s is zero.

        The result shares the index arrays of K if M has no other entries, so that a solver's
        analysis of the pattern serves both.
        """
        for each in (self.K, self.M):
            each.sum_duplicates()  # also sorts the indices
        if not self.s2:
            return self.K
        K, data = self.K, np.empty_like(self.K.data)
        cuts = np.linspace(0, self.n, 2 + K.nnz // ENTRIES_AT_ONCE, dtype=int).tolist()
        for first, last in pairwise(cuts):
            rows = rows_of(K, first, last)
            # SciPy's sum drops entries that are zero, but not negligible ones.
            rows.data = np.where(rows.data == 0.0, np.finfo(float).tiny, rows.data)
            total = rows + self.s2 * rows_of(self.M, first, last)
            if total.nnz != rows.nnz:
                return K + self.s2 * self.M
            data[K.indptr[first] : K.indptr[last]] = total.data
        found = copy(K)  # a constructor might copy the index arrays
        found.data = data
        return found

    def products(self, x: FloatArray) -> ArrayPair:
        """Return K x and M x."""
        return product(self.K, x), product(self.M, x)

    @cached_property
    def scale(self) -> float:
        """Largest entry of the diagonal, a lower bound of the norm of the matrix."""
        return float(self.diagonal.max())
