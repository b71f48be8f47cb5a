"""What a direct factorisation will cost, estimated from the matrix before it is begun."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

__all__ = ["direct_seconds", "factor_entries", "graph_width"]

Order = npt.NDArray[np.int32]

# Estimated times, s, are compared with each other and mean nothing else: of a solution per entry of
# the factors, and of an ordering with its checks in solutions.
_SOLUTION, _ORDERING = 1e-9, 20.0


def factor_entries(n: int, width: float, per_root_width: float) -> float:
    """Estimate how many entries the factors of a symmetric matrix have, to a factor of about 2.

    A body of n dofs and w dofs to a cross-section is a row of cubes of w^(3/2) dofs, whose factors
    have some c w² entries each by nested dissection: c n √w in all.

    Parameters
    ----------
    n : int
        Dofs.
    width : float
        See `graph_width`.
    per_root_width : float
        c of the solver.
    """
    return per_root_width * n * math.sqrt(width)


def direct_seconds(
    n: int, width: float, entries: float, solutions: int, *, per_operation: float
) -> float:
    """Estimate the time of a sparse factorisation and so many solutions with it, s.

    The row of cubes of `factor_entries` takes some w³ operations for each: n w^(3/2) in all.

    Parameters
    ----------
    n : int
        Dofs.
    width : float
        See `graph_width`.
    entries : float
        Of the factors.
    solutions : int
    per_operation : float
        Seconds per n w^(3/2) of the solver.
    """
    return _SOLUTION * entries * (_ORDERING + solutions) + per_operation * n * math.pow(width, 1.5)


def graph_width(matrix: Any) -> float:
    """Return how many dofs a cut through the graph of a matrix passes, on average over the dofs.

    The cuts are the levels of a breadth-first search from a dof at one of the body's ends.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array or bsr_array, shape (n, n)
    """
    if matrix.format == "bsr":
        blocks = (np.ones(len(matrix.indices), dtype=bool), matrix.indices, matrix.indptr)
        return float(matrix.blocksize[0] * graph_width(sp.csr_array(blocks)))
    order, _ = sp.csgraph.breadth_first_order(matrix, 0)  # its last dof is at an end
    sizes = _level_sizes(*sp.csgraph.breadth_first_order(matrix, int(order[-1])))
    return float((sizes.astype(float) ** 2).sum() / sizes.sum())


def _level_sizes(order: Order, before: Order) -> npt.NDArray[np.int64]:
    """Sizes of the levels of a search; `before` is where each dof was reached from."""
    place = np.empty(len(before), dtype=np.int64)
    place[order] = np.arange(len(order))
    reached_from = place[before[order[1:]]]  # ascending
    ends = [0, 1]
    while ends[-1] < len(order):
        ends.append(1 + int(np.searchsorted(reached_from, ends[-1])))
    return np.diff(ends)
