"""Solution of an enriched system by that of the system which was enriched."""

from __future__ import annotations

import numpy as np

from ..base import FloatArray
from .iteration import conjugate_gradients
from .method import Inverse
from .pencil import Pencil
from .solvers import LinearSolver

# ‖f - A x‖ / ‖f‖ of a rough solution. On nine plates of all kinds of elements, peaks with 0.1, 0.03
# and 0.01 differ by a tenth of their distance from the meshed body's at most.
_ROUGH = 3e-2


def two_level(pencil: Pencil, first: LinearSolver) -> LinearSolver:
    """Return the solver of a matrix whose first block has one.

    Conjugate gradients are preconditioned by the inverse of the first block and those of the 3 x 3
    blocks of the other functions. These are local and zero at the nodes of the first, so that the
    number of iterations hardly depends on the size of the elements (H. Yserentant, Numer. Math. 49,
    379, 1986).

    Parameters
    ----------
    pencil : Pencil
        With `free`.
    first : LinearSolver
        Of the first block, at the same shift.
    """
    n, A, free = first.pencil.n, pencil.matrix(), pencil.free
    assert free is not None
    function, axis = np.unique(free[n:] // 3, return_inverse=True)[1], free[n:] % 3
    blocks = np.tile(np.eye(3), (int(function.max(initial=-1)) + 1, 1, 1))
    rest = A[n:, n:].tocoo()
    row, column = rest.coords
    own = function[row] == function[column]
    blocks[function[row[own]], axis[row[own]], axis[column[own]]] = rest.data[own]
    inverses = np.linalg.inv(blocks)
    by_first = first.inverse.solve or first.inverse.precondition
    assert by_first is not None

    def precondition(r: FloatArray) -> FloatArray:
        at_functions = np.zeros(blocks.shape[:2])
        at_functions[function, axis] = r[n:]
        others = np.einsum("kij,kj->ki", inverses, at_functions)[function, axis]
        return np.concatenate([by_first(r[:n]), others])

    name = f"{first.name} and conjugate gradients"

    def iterate(rhs: FloatArray, tolerance: float, most: float) -> tuple[FloatArray, int]:
        return conjugate_gradients(
            name, pencil.what, lambda x: A @ x, precondition, rhs, tolerance, most
        )

    return LinearSolver(name, pencil, Inverse(None, iterate, precondition), rough=_ROUGH)
