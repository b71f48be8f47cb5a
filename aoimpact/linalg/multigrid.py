"""Multigrid: conjugate gradients preconditioned by a V-cycle, for bodies too large for factors.

Elements of second order are corrected by linear ones on their corners; below these, and for
matrices that came without a mesh, smoothed aggregation takes over, with the rigid motions as the
motions of no stiffness. The preconditioner works in single precision, the iteration in double.
"""

from __future__ import annotations

import copy
import math
import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import ROUNDING, ConvergenceError, FloatArray, SingularError, bar
from ..mesh import Mesh, rigid_motions
from .blocks import Blocks, diagonal_places, slabs
from .coarsening import aggregated, corner_interpolation
from .dissection import fill
from .finest import add, add_to_diagonal, finest_level, in_order
from .method import Inverse, Method
from .pencil import Pencil
from .rows import congruent
from .smoother import Smoother, inner
from .superlu import factorize

Single = npt.NDArray[np.float32]

# λ_max of what is smoothed over λ_min of that: wider than isotropic elements need (8), for elements
# three times as long as wide; and on the levels of aggregates.
_BAND_MESH, _BAND_AGGREGATES = 20.0, 15.0

# The coarsest level is the first whose L has no more entries than the first of these, or than that
# share of K's. Aggregates do not bend as beams and plates do: where L of K has fewer than so many
# times n^(4/3) entries the share is larger, as long as that leaves the entries few. It has 26 to 56
# times n^(4/3) in balls, cubes and plates of 6:6:1, 11 to 15 in sheets and bars.
_FEWEST_ENTRIES, _COARSEST_SHARE = 3e5, 0.03
_FEW_ENTRIES, _SHARE_OF_FEW, _SLENDER = 4e6, 0.7, 20.0
_DENSE = 300

# A level that has not less than this share of the dofs above it is no progress: K does not couple.
_SHRINKS = 0.7

# Three times what the worst bodies measured take: a cube takes 13, a sheet 150 times as long as
# thick 142, a cube of ν = .499 169.
_MOST_ITERATIONS = 500

# The set-up takes at most so many bytes per entry of K, beside K, M and the coarsest level's
# factors, with a mesh of second order; of linear tetrahedra 42 were measured.
_BYTES_QUADRATIC = 20.0

# Seconds per entry of K of the set-up and of an iteration; bytes per entry of the coarsest level's
# factors and of K.
_COST = 0.0, 4e-8, 1.5e-9, 30.0, 44.0

# ‖f - A x‖ / ‖f‖ to iterate to: half of what `LinearSolver` asks for, since the residual that is
# computed afresh comes out slightly larger.
_TOLERANCE, _OF_WHAT_IS_ASKED = 5e-11, 0.5

# Iterations of a solution: the first of these and the second times the square of the elements'
# aspect ratio, since the smoother treats all directions alike. Measured: 13 with cubes of elements,
# 43 with 2.5:2.5:1, 88 with 3:3:1, 189 with 5:5:1. Without coordinates of the nodes aggregates do
# not turn.
_ITERATIONS, _PER_ASPECT, _WITHOUT_NODES = 5.0, 8.0, 200.0


def _most_in_coarsest(pencil: Pencil) -> float:
    """Entries that L of the coarsest level may have."""
    stored, slender = float(pencil.K.nnz), pencil.fill.entries < _SLENDER * pencil.n ** (4 / 3)
    few = min(_FEW_ENTRIES, _SHARE_OF_FEW * stored) if slender else 0.0
    return max(_FEWEST_ENTRIES, _COARSEST_SHARE * stored, few)


@dataclass(frozen=True, eq=False)
class _Level:
    smoother: Smoother
    prolongation: Any
    restriction: Any
    width: int  # of the vectors' rows: 3 where one weight serves all components of a node

    def moved(self, x: Single, by: Any) -> Single:
        """Return `x` on the next level by the restriction, or on this one by the prolongation."""
        result: Single = by @ (x.reshape(-1, 3) if self.width == 3 else x)
        return result.reshape(-1)


class Multigrid:
    """(K + s²M)⁻¹ by conjugate gradients.

    Threads that share one wait for each other: it has one work space.

    Parameters
    ----------
    pencil : Pencil
    tolerance : float
        ‖f - (K + s²M) x‖ / ‖f‖ to iterate to, where `solve` gets no other one.

    Attributes
    ----------
    sizes : list of int
        Dofs of the levels, the finest first.

    Raises
    ------
    SingularError
        If the matrix turns out to be singular or not positive definite.
    """

    def __init__(self, pencil: Pencil, tolerance: float) -> None:
        self.pencil, self.tolerance = pencil, tolerance
        self._levels: list[_Level] = []
        self._in_use, self._stored = threading.RLock(), pencil.s2
        # One matrix in blocks is read in a sixth of the time that K and M take.
        with bar(f"multigrid, {pencil.n} dofs", unit="level") as progress:
            A, candidates, places, self._place = finest_level(pencil)
            self._scale, self._length, self.sizes = pencil.scale, A.shape[0], [A.shape[0]]
            self._blocks = Blocks(A, None if places is None else slabs(places, A.blocksize[0]))
            self._work = np.empty(self._blocks.work_length)
            if pencil.mesh is not None and pencil.mesh.quadratic:
                A, candidates, places = self._to_corners(A) or (A, candidates, places)
            progress.update()
            self._coarsen(A, candidates, places, progress)

    def _coarsen(self, A: Any, candidates: FloatArray, places: Any, progress: Any) -> None:
        """Make the levels from that of A on."""
        affordable = _most_in_coarsest(self.pencil)
        while True:
            if len(self._levels) == 1:
                self._second = A, candidates, places
            few = 0.5 * A.nnz <= affordable and fill(A).entries <= affordable
            if few or A.shape[0] <= _DENSE:
                break
            A, candidates = self._to_aggregates(A, candidates, places)
            places = None
            progress.update()
        self._coarsest = factorize(A / self._scale, what=self.pencil.what)

    def below(self, s2: float) -> Multigrid:
        """Return (K + s²M)⁻¹ at a smaller shift, with this one's smoother on the finest level.

        It damps as well there. At a larger one, where its matrix is too small, it does not. The
        two share the work space, and wait for each other.
        """
        if not self._levels or s2 > self._stored:
            return Multigrid(self.pencil.at(s2), self.tolerance)
        other = copy.copy(self)
        other.pencil = self.pencil.at(s2)
        other._levels, other.sizes = self._levels[:1], self.sizes[:2]
        A, candidates, places = self._second
        with bar(f"multigrid, {self.pencil.n} dofs", unit="level") as progress:
            masses = self._coarse_masses()
            A = add(A.copy(), s2 - self.pencil.s2, masses)
            other._coarsen(A, candidates, places, progress)
        return other

    def _coarse_masses(self) -> Any:
        """Return Pᵀ M P on the second level."""
        level = self._levels[0]
        P = level.prolongation.astype(np.float64)
        P = sp.kron(P, np.eye(3), format="csr") if level.width == 3 else P.tocsr()
        return congruent(self.pencil.M, P[self._place])

    def _to_corners(self, A: Any) -> tuple[Any, FloatArray, FloatArray] | None:
        """Make the finest level of a quadratic mesh; return matrix, motions, places of corners.

        None where all corners are constrained.
        """
        pencil = self.pencil
        assert pencil.nodes is not None  # a body with a mesh has nodes
        assert pencil.free is not None
        weights, corners = corner_interpolation(pencil.mesh)
        nodes = np.unique(pencil.free // 3)
        kept = np.isin(corners, nodes, assume_unique=True)
        if not kept.any():
            return None
        weights = weights[nodes][:, kept]
        self._add(self._smoother(self._blocks, A, _BAND_MESH), weights, width=3)
        coarse = congruent(A, sp.kron(weights, np.eye(3)).tobsr((3, 3)))
        motions = rigid_motions(pencil.nodes).reshape(-1, 3, 6)[corners[kept]]
        return self._coarse_matrix(coarse, 3), motions, pencil.nodes[corners[kept]]

    def _to_aggregates(
        self, A: Any, candidates: FloatArray, places: FloatArray | None
    ) -> tuple[Any, FloatArray]:
        band = _BAND_AGGREGATES if self._levels else _BAND_MESH
        blocks = self._blocks
        if self._levels:
            blocks = Blocks(A, None if places is None else slabs(places, A.blocksize[0]))
        smoother = self._smoother(blocks, A, band)
        prolongation, coarse = aggregated(A, candidates, smoother.highest)
        if prolongation.shape[1] > _SHRINKS * prolongation.shape[0]:
            raise ConvergenceError(
                f"solver 'multigrid' finds no coarser level below {A.shape[0]} dofs of "
                f"{self.pencil.what} ({self.pencil.n} dofs): too few of them are coupled; take "
                "another one by solver="
            )
        self._add(smoother, prolongation, width=1)
        return self._coarse_matrix(congruent(A, prolongation), coarse.shape[1]), coarse

    def _smoother(self, blocks: Blocks, A: Any, band: float) -> Smoother:
        diagonal = A.data[diagonal_places(A)]
        return Smoother(blocks, diagonal, scale=self._scale, band=band, what=self.pencil.what)

    def _add(self, smoother: Smoother, prolongation: Any, width: int) -> None:
        single = prolongation.astype(np.float32)
        restriction = single.T.tocsr() if single.format == "csr" else single.T
        self._levels.append(_Level(smoother, single, restriction, width))

    def _coarse_matrix(self, coarse: Any, size: int) -> Any:
        """Return Pᵀ A P with something on the diagonal where candidates were dependent."""
        coarse = in_order(coarse.tobsr((size, size)))
        empty = coarse.diagonal() == 0.0
        if empty.any():
            add_to_diagonal(coarse, np.where(empty, self._scale, 0.0))
        self.sizes.append(coarse.shape[0])
        return coarse

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return (K + s²M)⁻¹ `rhs` for one right-hand side (n,) or several (n, m)."""
        if rhs.ndim == 2:
            return np.column_stack([self.solve(column) for column in rhs.T])
        return self.iterate(rhs, self.tolerance, _MOST_ITERATIONS)[0]

    def iterate(self, rhs: FloatArray, tolerance: float, most: float) -> tuple[FloatArray, int]:
        """Return (K + s²M)⁻¹ `rhs`, shape (n,), and the iterations that it took, `most` at most.

        With β after Polak and Ribière, which forgives the preconditioner its rounding.

        Raises
        ------
        SingularError
            If a motion turns out to have no positive stiffness.
        ConvergenceError
            If the iterations do not suffice, or the preconditioner is not positive: of a matrix
            that is nearly singular, by its rounding.
        """
        what, limit = self.pencil.what, max(1, int(min(most, _MOST_ITERATIONS)))
        size = math.sqrt(inner(rhs, rhs))
        if size == 0.0:
            return np.zeros_like(rhs), 0
        x, r = np.zeros_like(rhs), rhs
        label, digits = f"multigrid, {self.pencil.n} dofs", -math.log10(tolerance)
        with self._in_use, bar(label, digits, unit="digit") as progress:
            p = z = self.precondition(r)
            rz, reached = inner(r, z), 0.0
            for iteration in range(1, limit + 1):
                along = self.product(p)
                curvature = inner(p, along)
                if not rz > 0.0:
                    raise ConvergenceError(
                        f"iterations with {what} have to be given up: it is nearly singular, and "
                        "the rounding of what speeds them up takes over; take another solver"
                    )
                if not curvature > 0.0:
                    raise SingularError(
                        f"{what} is singular or not positive definite: a motion has a stiffness "
                        f"of {curvature:.2g}"
                    )
                step = rz / curvature
                x += step * p
                before, r = r, r - step * along
                left = math.sqrt(inner(r, r)) / size
                if left <= tolerance:
                    return x, iteration
                progress.update(max(0.0, -math.log10(left) - reached))
                reached = max(reached, -math.log10(left))
                z = self.precondition(r)
                rz_next = inner(r, z)
                p = z + (rz_next - inner(before, z)) / rz * p
                rz = rz_next
        raise ConvergenceError(
            f"solver 'multigrid' of {what} ({self.pencil.n} dofs) reached {left:.2g} of the "
            f"right-hand side in {limit} iterations, {tolerance:g} was asked for: the matrix is "
            "nearly singular (a mechanism, missing supports, ν near .5) or its elements are flat. "
            "Take another solver"
        )

    def product(self, x: FloatArray) -> FloatArray:
        """Return (K + s²M) x."""
        padded = np.zeros(self._length)
        padded[self._place] = x
        found = self._blocks.multiply(padded, self._work)[self._place]
        change = self.pencil.s2 - self._stored
        return found + change * self.pencil.momentum(x) if change else found

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
        """Improve upon zero for the right-hand side `r`, which is written to."""
        if depth == len(self._levels):
            return self._coarsest.solve(r.astype(np.float64)).astype(np.float32)
        level = self._levels[depth]
        x = np.zeros_like(r)
        level.smoother.smooth(x, r, finish=True)
        if depth == 0:
            self._shift(x, r)
        below = self._cycle(depth + 1, level.moved(r, level.restriction))
        correction = level.moved(below, level.prolongation)
        x += correction
        level.smoother.subtract(correction, r)
        if depth == 0:
            self._shift(correction, r)
        level.smoother.smooth(x, r, finish=False)
        return x

    def _shift(self, x: Single, r: Single) -> None:
        """Make `r`, the residual after `x` at the shift of the finest smoother, that at ours.

        Else corrections of slow motions, which s²M governs, are taken for far too large or small.
        """
        change = (self.pencil.s2 - self._stored) / self._scale
        if change:
            momentum = self.pencil.momentum(x[self._place].astype(np.float64))
            r[self._place] -= (change * momentum).astype(np.float32)


def _set_up(pencil: Pencil) -> Inverse:
    return _inverse(Multigrid(pencil, _TOLERANCE))


def _inverse(multigrid: Multigrid) -> Inverse:
    def iterate(rhs: FloatArray, tolerance: float, most: float) -> tuple[FloatArray, int]:
        return multigrid.iterate(rhs, _OF_WHAT_IS_ASKED * tolerance, most)

    def below(s2: float) -> Inverse:
        return _inverse(multigrid.below(s2))

    return Inverse(multigrid.solve, iterate, multigrid.precondition, at=below)


class _Iterations(Method):
    """Its cost, by entries of K in place of those of L."""

    def seconds(self, pencil: Pencil, solutions: float) -> float:
        """Return the estimated time of the set-up and some solutions, s."""
        aspect = 1.0 if pencil.mesh is None else _aspect(pencil.mesh)
        each = _ITERATIONS + _PER_ASPECT * aspect**2
        if pencil.nodes is None:
            each = _WITHOUT_NODES
        return self.per_entry * float(pencil.K.nnz) + solutions * each * self.iteration(pencil)

    def memory(self, pencil: Pencil) -> float:
        """Return the estimated bytes that it needs besides K and M."""
        quadratic = pencil.mesh is not None and pencil.mesh.quadratic
        copied = _BYTES_QUADRATIC if quadratic else self.bytes_copied
        return copied * float(pencil.K.nnz) + self.bytes_per_entry * _most_in_coarsest(pencil)

    def iteration(self, pencil: Pencil) -> float:
        """Return the estimated time of an iteration, s."""
        return self.per_solution * float(pencil.K.nnz)


def _aspect(mesh: Mesh) -> float:
    """The ratio of the longest and the shortest of the lengths of elements; median over the nodes.

    Elements about a node count together: bricks cut into tetrahedra are as long as wide.
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


MULTIGRID = _Iterations("multigrid", _set_up, *_COST)
