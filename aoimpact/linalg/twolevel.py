"""Solver of an enriched system, preconditioned by the solver of the system before enrichment."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from ..base import FloatArray
from .iteration import conjugate_gradients
from .method import Inverse
from .pencil import Pencil
from .solvers import LinearSolver

# Default ‖f - A x‖ / ‖f‖ of `solve_roughly`. In 99 impacts on 15 bodies, results with
# tolerances of 0.1 and 0.03 differ by at most 0.4 % on tetrahedra of first order, whose median
# errors are 0.7 to 1.2 %, and by at most 0.05 % on elements of second order.
_ROUGH = 0.1

# Number of columns solved together, limited because each needs a few vectors in memory. Solving 16
# columns with factors takes a fifth of the time, per column, of solving one.
_AT_ONCE = 16


def two_level(pencil: Pencil, first: LinearSolver) -> LinearSolver:
    """Return the solver of an enriched matrix, given that of its first block.

    The preconditioner of conjugate gradients is the inverse of the first block, and of the 3 x 3
    blocks of the added functions. These functions are local and zero at the nodes of the first
    block, so that the number of iterations hardly depends on the size of the elements (H.
    Yserentant, Numer. Math. 49, 379, 1986).

    Parameters
    ----------
    pencil : Pencil
        K + s²M of the enriched system. Its `free` has 3·function + component of the added dofs.
    first : LinearSolver
        The solver of the first block, at the same shift.

    Returns
    -------
    LinearSolver
        It solves for right-hand sides of shape (n,) or (n, m), several columns at a time.
    """
    n = first.pencil.n
    A = pencil.matrix()
    free = pencil.free
    assert free is not None
    functions, function = np.unique(free[n:] // 3, return_inverse=True)
    axis = free[n:] % 3
    blocks = np.tile(np.eye(3), (len(functions), 1, 1))
    rest = A[n:, n:].tocoo()
    row, column = rest.coords
    own = function[row] == function[column]
    blocks[function[row[own]], axis[row[own]], axis[column[own]]] = rest.data[own]
    inverses = np.linalg.inv(blocks)
    by_first: Any = first.inverse.solve or first.inverse.precondition

    def precondition(r: FloatArray) -> FloatArray:
        at_functions = np.zeros((*blocks.shape[:2], r.shape[1]))
        at_functions[function, axis] = r[n:]
        return np.concatenate([by_first(r[:n]), (inverses @ at_functions)[function, axis]])

    name = f"{first.name} and conjugate gradients"

    def iterate(rhs: FloatArray, tolerance: float, most: float) -> tuple[FloatArray, int]:
        given = name, pencil.what, lambda x: A @ x, precondition
        return conjugate_gradients(*given, rhs, tolerance, most, _AT_ONCE)

    # A finite `most`: a factorisation replaces iterations that do not converge (flat elements).
    return LinearSolver(name, pencil, Inverse(None, iterate, precondition), sys.maxsize, _ROUGH)
