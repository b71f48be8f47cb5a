"""What a direct factorisation will cost, told from the matrix before it is begun."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

__all__ = ["entries_by_width", "factor_entries", "mean_width"]

# Entries of the factors over n √w, with w the width of the graph. Measured on balls, boxes, plates
# and bars of tetra10, hexahedra 8, 20 and 27 of 3 700 … 45 000 dofs: 9 … 21 with PARDISO (nested
# dissection if wide), 13 … 39 with SuperLU (minimum degree, L and U together), growing slowly.
_PER_ROOT_WIDTH = {"pardiso": 22.0, "superlu": 40.0}


def factor_entries(matrix: Any, solver: str) -> float:
    """Estimate how many entries the factors of a symmetric matrix have, to a factor of about 2.

    A body of n dofs and w dofs to a cross-section is a row of cubes of w^(3/2) dofs, whose factors
    have some c w² entries each by nested dissection: c n √w in all.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array or bsr_array, shape (n, n)
    solver : {"pardiso", "superlu"}
    """
    if matrix.format == "bsr":
        graph = (np.ones(len(matrix.indices), dtype=bool), matrix.indices, matrix.indptr)
        width = matrix.blocksize[0] * mean_width(sp.csr_array(graph))
    else:
        width = mean_width(matrix)
    return entries_by_width(int(matrix.shape[0]), width, solver)


def entries_by_width(n: int, width: float, solver: str) -> float:
    """Estimate what `factor_entries` does where the `mean_width` is known."""
    return _PER_ROOT_WIDTH[solver] * n * math.sqrt(width)


def mean_width(matrix: Any) -> float:
    """Return how many dofs a cut through the graph of a matrix passes, on average over the dofs.

    The cuts are the levels of a breadth-first search from a dof at one of the body's ends.
    """
    order, _ = sp.csgraph.breadth_first_order(matrix, 0)  # its last dof is at an end
    sizes = _level_sizes(*sp.csgraph.breadth_first_order(matrix, int(order[-1])))
    return float((sizes.astype(float) ** 2).sum() / sizes.sum())


def _level_sizes(
    order: npt.NDArray[np.int32], before: npt.NDArray[np.int32]
) -> npt.NDArray[np.int64]:
    """Sizes of the levels of a search; `before` is where each dof was reached from."""
    place = np.empty(len(before), dtype=np.int64)
    place[order] = np.arange(len(order))
    reached_from = place[before[order[1:]]]  # ascending
    ends = [0, 1]
    while ends[-1] < len(order):
        ends.append(1 + int(np.searchsorted(reached_from, ends[-1])))
    return np.diff(ends)
