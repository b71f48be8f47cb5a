"""Multigrid: conjugate gradients preconditioned by a V-cycle, for bodies too large for factors.

For a mesh of second order, the first coarse level has the linear elements on its corners. All other
coarse levels are made by smoothed aggregation, with rigid motions as near-null-space vectors. The
preconditioner works in single precision, the iteration in double.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import ROUNDING, ConvergenceError, FloatArray, bar, record, sp
from ..mesh import Mesh
from .blocks import Blocks, congruent
from .coarsening import (
    add_to_diagonal,
    aggregated,
    corners_of,
    finest_level,
    in_order,
)
from .dissection import fill
from .iteration import by_columns, conjugate_gradients
from .method import Cost, Inverse, Method
from .pencil import Pencil
from .smoother import Smoother
from .superlu import factorize

Single = npt.NDArray[np.float32]

# Ratio λ_max/λ_min of the band of eigenvalues that the smoother damps. Isotropic elements need 8;
# this ratio is for elements three times as long as wide.
_BAND = 20.0

# Maximum entries of the coarsest level's factor L: the larger of _FEWEST_ENTRIES and
# _COARSEST_SHARE of the entries of K. Aggregates represent bending poorly: for slender bodies the
# maximum is _SHARE_OF_FEW of the entries of K, but at most _FEW_ENTRIES. A body is slender if the
# factor L of K has fewer than _SLENDER n^(4/3) entries: balls, cubes and plates of 6:6:1 have 26 to
# 56 n^(4/3), sheets and bars 11 to 15 n^(4/3).
_FEWEST_ENTRIES, _COARSEST_SHARE = 3e5, 0.03
_FEW_ENTRIES, _SHARE_OF_FEW, _SLENDER = 4e6, 0.7, 20.0

# `_SET_UP`, `_ITERATION`: time of the set-up and of an iteration per entry of K, s.
_SET_UP, _ITERATION = 4e-8, 1.5e-9

# Peak memory of the set-up besides K, M and the coarsest level's factors, bytes per entry of K:
# `_BYTES_QUADRATIC` with a mesh of second order, `_BYTES` without (linear tetrahedra took 42).
# `_BYTES_COARSEST`: bytes per entry of the factors.
_BYTES_QUADRATIC, _BYTES, _BYTES_COARSEST = 20.0, 44.0, 30.0

# Iterations of a solution: _ITERATIONS + _PER_ASPECT times the square of the elements' aspect
# ratio, since the smoother treats all directions alike. Measured: 13 with cubic elements, 43 with
# 2.5:2.5:1, 88 with 3:3:1, 189 with 5:5:1. Without coordinates of the nodes, aggregates lack
# rotations and a solution takes _WITHOUT_NODES iterations.
_ITERATIONS, _PER_ASPECT, _WITHOUT_NODES = 5.0, 8.0, 200.0


def _most_in_coarsest(pencil: Pencil) -> float:
    """Return the maximum number of entries of the coarsest level's factor L."""
    stored, slender = float(pencil.K.nnz), pencil.fill.entries < _SLENDER * pencil.n ** (4 / 3)
    few = min(_FEW_ENTRIES, _SHARE_OF_FEW * stored) if slender else 0.0
    return max(_FEWEST_ENTRIES, _COARSEST_SHARE * stored, few)


@record
class _Level:
    smoother: Smoother
    prolongation: Any
    restriction: Any
    width: int  # 3 if all components of a node have the same weights, else 1

    def moved(self, x: Single, by: Any) -> Single:
        """Return `by` x: x restricted to the next coarser level, or prolonged from there."""
        result: Single = by @ (x.reshape(-1, 3) if self.width == 3 else x)
        return result.reshape(-1)


class Multigrid:
    """(K + s²M)⁻¹ by conjugate gradients, preconditioned by a V-cycle.

    Threads that share the object take turns, since it has a single work space.

    Parameters
    ----------
    pencil : Pencil

    Raises
    ------
    SingularError
        If the matrix turns out to be singular or not positive definite.
    ConvergenceError
        If the dofs are hardly coupled, so that there is no coarser level.
    """

    def __init__(self, pencil: Pencil) -> None:
        self.pencil = pencil
        self._levels: list[_Level] = []
        self._in_use = threading.RLock()
        with bar(f"multigrid, {pencil.n} dofs", unit="level") as progress:
            A, motions, places, self._place = finest_level(pencil)
            self._scale, self._length = pencil.scale, A.shape[0]
            # A product with K + s²M takes a sixth of the time of products with K and M.
            self._blocks = Blocks(A, places)
            self._work = np.empty(self._blocks.work_length)
            self._coarsen(A, motions, places, progress)

    @property
    def inverse(self) -> Inverse:
        """(K + s²M)⁻¹ as the `Inverse` that `LinearSolver` takes."""
        return Inverse(None, self.iterate, by_columns(self.precondition))

    def _coarsen(self, A: Any, motions: FloatArray, places: Any, progress: Any) -> None:
        """Build the levels, from the level of the matrix A to the coarsest."""
        pencil, affordable = self.pencil, _most_in_coarsest(self.pencil)
        while True:
            first = not self._levels
            corners = corners_of(pencil) if first else None
            if corners is None and 0.5 * A.nnz <= affordable and fill(A).entries <= affordable:
                break
            blocks = self._blocks if first else Blocks(A, places)
            smoother = Smoother(blocks, A, scale=self._scale, band=_BAND, what=pencil.what)
            if corners is None:
                P, motions = aggregated(A, motions, smoother.highest)
                weights, places, width = P, None, 1
            else:
                weights, motions, places = corners
                P, width = sp.kron(weights, np.eye(3)).tobsr((3, 3)), 3
            if P.shape[1] >= P.shape[0]:
                raise ConvergenceError(
                    f"solver 'multigrid' finds no coarser level below {A.shape[0]} dofs of "
                    f"{pencil.what} ({pencil.n} dofs): too few of them are coupled; take another "
                    "one by solver="
                )
            single = weights.astype(np.float32)
            restriction = single.T.tocsr() if single.format == "csr" else single.T
            self._levels.append(_Level(smoother, single, restriction, width))
            A = in_order(congruent(A, P).tobsr((motions.shape[1],) * 2))
            empty = A.diagonal() == 0.0  # due to linearly dependent motions
            if empty.any():
                add_to_diagonal(A, np.where(empty, self._scale, 0.0))
            progress.update()
        self._coarsest = factorize(A / self._scale, what=pencil.what)

    def iterate(self, rhs: FloatArray, tolerance: float, most: float) -> tuple[FloatArray, int]:
        """Return (K + s²M)⁻¹ `rhs`, each column bit for bit as if solved alone; see `Inverse`."""
        operators = by_columns(self.product), by_columns(self.precondition)
        with self._in_use:
            what = self.pencil.what
            return conjugate_gradients("multigrid", what, *operators, rhs, tolerance, most)

    def product(self, x: FloatArray) -> FloatArray:
        """Return (K + s²M) x."""
        padded = np.zeros(self._length)
        padded[self._place] = x
        return self._blocks.multiply(padded, self._work)[self._place]

    def precondition(self, r: FloatArray) -> FloatArray:
        """Return one V-cycle applied to `r`."""
        size = float(np.abs(r).max())
        if size == 0.0:
            return np.zeros_like(r)
        padded = np.zeros(self._length, dtype=np.float32)
        padded[self._place] = r / size
        with self._in_use:
            x = self._cycle(0, padded)[self._place]
        return x.astype(np.float64) * (size / self._scale)

    def _cycle(self, depth: int, r: Single) -> Single:
        """Return the solution for `r` of a V-cycle that begins on level `depth`; overwrites `r`."""
        if depth == len(self._levels):
            return self._coarsest.solve(r.astype(np.float64)).astype(np.float32)
        level = self._levels[depth]
        x = np.zeros_like(r)
        level.smoother.smooth(x, r, finish=True)
        below = self._cycle(depth + 1, level.moved(r, level.restriction))
        correction = level.moved(below, level.prolongation)
        x += correction
        level.smoother.subtract(correction, r)
        level.smoother.smooth(x, r, finish=False)
        return x


def _cost(pencil: Pencil) -> Cost:
    """Return the estimated cost of multigrid; times are proportional to the entries of K."""
    stored, quadratic = float(pencil.K.nnz), pencil.mesh is not None and pencil.mesh.quadratic
    aspect = 1.0 if pencil.mesh is None else _aspect(pencil.mesh)
    each = _WITHOUT_NODES if pencil.nodes is None else _ITERATIONS + _PER_ASPECT * aspect**2
    memory = (_BYTES_QUADRATIC if quadratic else _BYTES) * stored
    memory += _BYTES_COARSEST * _most_in_coarsest(pencil)
    return Cost(_SET_UP * stored, _ITERATION * stored, memory, each)


def _aspect(mesh: Mesh) -> float:
    """Return the elements' aspect ratio, longest to shortest extent: the median over the nodes.

    Extents of all elements about a node together: tetrahedra cut from a cube have aspect ratio 1.
    """
    about = np.zeros((mesh.n_nodes, 9))
    for block in mesh.blocks:
        cells = block.cells[:, : block.element.n_corners]
        spread = mesh.nodes[cells] - mesh.nodes[cells].mean(axis=1, keepdims=True)
        squares = np.einsum("eni,enj->eij", spread, spread).reshape(-1, 9)
        for corner in cells.T:
            np.add.at(about, corner, squares)
    lengths = np.linalg.eigvalsh(about[about.any(axis=1)].reshape(-1, 3, 3))
    return float(
        np.median(np.sqrt(lengths[:, 2] / np.maximum(lengths[:, 0], ROUNDING * lengths[:, 2])))
    )


MULTIGRID = Method("multigrid", lambda pencil: Multigrid(pencil).inverse, _cost)
