"""Rational Krylov subspaces: the motions of a body that contacts of some duration excite.

They are spanned by (K + s²M)⁻¹ b, (K + s²M)⁻¹ M (K + s²M)⁻¹ b, …, with s about 10 over the contact
time, each of which costs one solve; and, if the body is constrained, by its static modes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import scipy

from .. import _core
from ..base import FloatArray, SingularError, require
from ..contact import (
    SHIFT_TIMES_DURATION,
    ContactPoint,
    moves_rigidly,
    refuse_massless,
    refuse_mechanism,
)
from ..fem import displacement
from ..linalg import (
    FEW_SOLUTIONS,
    LinearSolver,
    Solver,
    SolverBook,
    checked_solver,
    core_rows,
)

# The order that this is best for; more vectors are best with s T in proportion, up to the highest
# frequency of the mesh at the contact. On a clamped beam of 17 000 dofs and a clamped plate of
# 19 000, 200 and 550 vectors then give the force to ten digits, 800 with the shift above to four.
ORDER_FITTED = 5

# So many vectors for each place after which s is fitted to four times as many, and again, each time
# at the price of a factorisation.
_SHARPENED_FROM, _SHARPENED_BY = 48, 4

# Below this share of the largest, a Ritz value may be that of a mechanism, but slender bodies under
# short contacts span as much. It is one if it is at most this share of the sum of the magnitudes of
# its terms: some hundred roundings.
_DOUBTFUL, _NO_STIFFNESS = 1e-12, 1e-14


# A vector of which less than this share is new is a combination of those before it.
_NOTHING_NEW = 1e-11

# Vectors in whose span a compact body's static mode is searched, for each place; the share of |b|
# that is left then; how many more will find it at most; and what is left in the end. The error of
# bᵀx goes with the square of that, but its direction across the other vectors does not. It spares a
# factorisation of K: models of 8 oscillators on blocks of 9 400 and 42 000 dofs are made 1.7 and
# 2.1 times as fast.
_FIRST, _PROMISING, _LAST, _REACHED = 6, 0.1, 8, 1e-7

# ‖b - K x‖ / ‖b‖ of a static mode by an iterative method: of a clamped plate's 180 vectors, 1e-6
# changes no error.
_STATIC = 1e-4

# ω² of a vector, of the largest K_ii/M_ii, beyond which it is a motion without mass, whose rounding
# spoils the others: up to 3 on bodies of full mass; from 2000 on modes are lost, M being singular.
_WITHOUT_MASS = 300.0

# Part of b beyond the rigid motions, over |b|, that is rounding.
_RIGID_ONLY = 1e-13


class Subspace:
    """A rational Krylov subspace of a body for one or more contact points; it grows.

    Rigid motions come first, then the static modes of the places where these do not move the body.

    Parameters
    ----------
    tips : sequence of ContactPoint
        The places, on one body.
    shifts : sequence of float
        s of K + s²M, rad/s, taken in turn.
    highest : float, optional
        Up to which the first of them grows with the number of vectors; 0 if it stays.
    solver : str or callable, optional
        See `FEModel.inverse`.
    known : LinearSolver, optional
        That of the first shift, where it has been set up for something else.

    Attributes
    ----------
    solver_name : str
        Linear solver in use; empty before the first solution.
    """

    def __init__(
        self,
        tips: Sequence[ContactPoint],
        shifts: Sequence[float],
        *,
        highest: float = 0.0,
        solver: Solver = "auto",
        known: LinearSolver | None = None,
    ) -> None:
        body = tips[0].body
        refuse_mechanism(tips)
        refuse_massless(tips)
        rigid = body.rigid_modes
        self.body = body
        self._tips = tuple(tips)
        self.rigid_count = rigid.shape[1]
        self.shifts = tuple(shifts)
        self._highest = highest
        self.solver_name = ""
        self._solver = checked_solver(solver)
        self._solvers: dict[float, LinearSolver] = {} if known is None else {shifts[0]: known}
        # The rigid part would drown the rest where s is small; it is in the basis exactly.
        functionals = np.stack([tip.b for tip in tips])
        elastic = functionals - (functionals @ rigid) @ (body.M @ rigid).T
        rigid_only = np.linalg.norm(elastic, axis=1) <= _RIGID_ONLY * np.linalg.norm(functionals)
        elastic[rigid_only] = 0.0
        self._b = elastic
        self._held = [i for i, tip in enumerate(tips) if not moves_rigidly(tip)]
        # Rigid motions; a place for each static mode that is not among what the solves give, zero
        # until it is needed; and what they give.
        self._given = self.rigid_count + len(self._held)
        self._progress = np.array([self._given, 0], dtype=np.int32)  # columns, solves
        self._basis = np.zeros((self._given, body.n_dofs))
        self._basis[: self.rigid_count] = rigid.T
        self._stiffness = np.zeros((self._given, self._given))
        # Coordinates on the basis of what is handed out, in its order, and the next to be added.
        self._ordered: list[FloatArray] = []
        self._next = self._given
        self._statics, self._wanted = 0, 0
        self._K, self._M = core_rows(body.K), core_rows(body.M)
        self._load = np.empty(body.n_dofs)
        stiffness, mass = body.K.diagonal(), body.M.diagonal()
        heavy = mass > 0.0
        self._fastest = _WITHOUT_MASS * float((stiffness[heavy] / mass[heavy]).max())
        self._ended = False

    def release(self) -> None:
        """Give the memory of the factors back: those that are needed again are made again."""
        self._solvers.clear()

    @property
    def _count(self) -> int:
        return int(self._progress[0])

    @property
    def _solves(self) -> int:
        return int(self._progress[1])

    @property
    def solves(self) -> int:
        """How many linear systems were solved so far, a static mode's counted as one."""
        return self._statics + self._solves

    @property
    def exhausted(self) -> bool:
        """True if the functionals excite no more than what is there."""
        return len(self._ordered) < self._wanted

    def grow(self, count: int) -> int:
        """Grow to `count` vectors, rigid motions included; return how many there are.

        There are fewer where the functionals excite no more. Those that were there stay.
        """
        self._wanted = max(self._wanted, count)
        if not self._ordered:
            self._ordered = list(np.eye(self.rigid_count, self._count))
        if len(self._ordered) == self.rigid_count < count and self._next == self._given:
            for coordinates in self._static_modes(count - self.rigid_count):
                self._append(coordinates)
        while len(self._ordered) < count:
            if self._next == self._count and not self._solve(count - len(self._ordered)):
                break
            self._append(np.eye(1, self._count, self._next)[0])
            self._next += 1
        return min(count, len(self._ordered))

    def first_vectors(self, count: int) -> FloatArray:
        """Return the first of the M-orthonormal basis, shape (n_dofs, count): a view of all."""
        return self._basis[:count].T

    def ritz_on_basis(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return ω² (ascending) and M-orthonormal modes of `count` vectors.

        By their coordinates on the first vectors, shape (first, m), only as many as there is need
        for: the last bits do not depend on those that came later.

        Raises
        ------
        SingularError
            If a mode that is no rigid motion has no stiffness.
        """
        size, rigid = self.grow(count), self.rigid_count
        elastic = self._coordinates()[rigid:size]
        first = max(rigid, 1 + int(np.flatnonzero(elastic.any(axis=0)).max(initial=-1)))
        elastic, there = elastic[:, :first], self._stiffness[:first, :first]
        omega2, y = scipy.linalg.eigh(elastic @ there @ elastic.T)
        doubtful = omega2 <= _DOUBTFUL * np.abs(omega2).max(initial=0.0)
        if doubtful.any():
            omega2[doubtful], turned = self._soft(elastic.T @ y[:, doubtful])
            y[:, doubtful] = y[:, doubtful] @ turned
        if (omega2[doubtful] == 0.0).any():
            raise SingularError(
                "a motion that is no rigid-body motion has no stiffness: part of the body is a "
                "mechanism (supports missing, a piece joined along one edge or at one point); see "
                "body.frequencies(10)"
            )
        whole = np.eye(first, min(rigid, size))
        coordinates = np.column_stack([whole, elastic.T @ y])
        return np.concatenate([np.zeros(min(rigid, size)), omega2]), coordinates

    def _soft(self, coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the Ritz values of soft motions, shape (m,), and how they turn, shape (m, m).

        By K itself: the rounding of its projection is that of the stiffest motion. A value that is
        no more than rounding of K in its own motion is 0.
        """
        motions = self.first_vectors(len(coordinates)) @ coordinates
        omega2, turned = scipy.linalg.eigh(motions.T @ (self.body.K @ motions))
        sizes = np.abs(motions @ turned)
        rounding = (sizes * (abs(self.body.K) @ sizes)).sum(axis=0)
        return np.where(omega2 <= _NO_STIFFNESS * rounding, 0.0, omega2), turned

    def _coordinates(self) -> FloatArray:
        padded = np.zeros((len(self._ordered), self._count))
        for row, coordinates in zip(padded, self._ordered, strict=True):
            row[: len(coordinates)] = coordinates
        return padded

    def _append(self, coordinates: FloatArray) -> None:
        """Put a combination of the basis next in order, unless those before it span it."""
        before, rest = self._coordinates(), coordinates.copy()
        for _ in range(2):
            rest -= (before @ rest) @ before
        length = float(np.linalg.norm(rest))
        if length > _NOTHING_NEW * float(np.linalg.norm(coordinates)):
            self._ordered.append(rest / length)

    def _static_modes(self, wanted: int) -> list[FloatArray]:
        """Return the coordinates of the static modes, `wanted` being vectors beside rigid motions.

        Of an iterative method these come before all vectors, across which rough solutions then
        are: else vectors lose slow motions to what the solutions leave of them.
        """
        if not self._held:
            return []
        loads = self._b[self._held]
        dynamic = self._inverse(min(self.shifts))
        if dynamic.precondition is None:
            within, left = self._spanned(loads, wanted - int(np.linalg.matrix_rank(loads)))
            if left <= _REACHED:
                return list(within)
        anew = partial(self.body.inverse, solver=self._solver)
        invert = SolverBook(dynamic.at or anew)
        found = []
        for place, load in enumerate(loads):
            # A rough solution depends on the shift that it was begun from: it is not shared.
            known = {} if dynamic.precondition else self._tips[self._held[place]].deflections
            if self._solver not in known:
                known[self._solver] = displacement(self.body, load, invert, tolerance=_STATIC)
            found.append(self._outside(place, known[self._solver]))
        return found

    def _spanned(self, loads: FloatArray, wanted: int) -> tuple[FloatArray, float]:
        """K⁻¹ of each load in the span of the vectors wanted anyway and, if promising, of more.

        In compact bodies that is all of it, and K need not be factorised.
        """
        places = int(np.linalg.matrix_rank(self._b))
        self._solve_to(max(wanted, _FIRST * places))
        within, left = self._galerkin(loads)
        for _ in range(_LAST):
            if not _REACHED < left <= _PROMISING:
                break
            self._solve_to(self._count - self._given + places)
            within, left = self._galerkin(loads)
        return within, left

    def _galerkin(self, loads: FloatArray) -> tuple[FloatArray, float]:
        """K⁻¹ of each load in the span of the vectors so far, and the largest |b - K x|/|b|."""
        found = np.zeros((len(loads), self._count))
        new = slice(self._given, self._count)
        stiffness = self._stiffness[new, new]
        if not (stiffness.diagonal() > 0.0).all():  # rounding of K, or a mechanism
            return found, np.inf
        scale = 1.0 / np.sqrt(stiffness.diagonal())
        try:
            factors = scipy.linalg.cho_factor(scale[:, None] * stiffness * scale)
        except np.linalg.LinAlgError:
            return found, np.inf
        for row, load in zip(found, loads, strict=True):
            row[new] = scale * scipy.linalg.cho_solve(
                factors, scale * _products(self._basis[new], load)
            )
        spanned = _combinations(found[:, new], self._basis[new])
        rest = loads - (self.body.K @ spanned.T).T
        sizes = np.linalg.norm(loads, axis=1)
        return found, float((np.linalg.norm(rest, axis=1) / np.where(sizes > 0, sizes, 1.0)).max())

    def _outside(self, place: int, x: FloatArray) -> FloatArray:
        """Put what is new of a static mode found by other means in its place in the basis."""
        self._statics += 1
        K, M, slot = self.body.K, self.body.M, self.rigid_count + place
        coordinates = np.zeros(self._count)
        vectors = self._basis[: self._count]
        size = _norm(x, M)
        for _ in range(2):
            parts = _products(vectors, M @ x)
            x = x - _combinations(parts[None], vectors)[0]
            coordinates += parts
        length = _norm(x, M)
        if length > _NOTHING_NEW * size:
            coordinates[slot] = length
            vectors[slot] = x / length
            row = _products(vectors, K @ vectors[slot])
            row[: self.rigid_count] = 0.0
            self._stiffness[slot, : self._count] = self._stiffness[: self._count, slot] = row
        return coordinates

    def _solve_to(self, vectors: int) -> None:
        """Solve until there are so many vectors beside rigid motions and static modes."""
        while (missing := self._given + vectors - self._count) > 0 and self._solve(missing):
            pass

    def _solve(self, most: int) -> bool:
        """Add some vectors, at most so many; whether there was one."""
        if self._ended:
            return False
        # All functionals have their turn with a shift before the next shift has its own.
        turn = self._solves // len(self._b)
        shifts, until = self._sharpened(turn)
        for passed in set(self._solvers) - set(shifts):  # the first, sharpened
            at = self._solvers.pop(passed).at
            if at is not None and shifts[0] not in self._solvers:
                self._solvers[shifts[0]] = at(shifts[0] ** 2)
        inverse = self._inverse(shifts[turn % len(shifts)])
        most = 1 if len(shifts) > 1 else min(most, until * len(self._b) - self._solves)
        before = self._count
        self._extend(inverse, before + min(most, max(1, self._solves)))  # then looks at its pace
        light = np.flatnonzero(np.diagonal(self._stiffness)[before : self._count] > self._fastest)
        if len(light):
            self._progress[0], self._ended = before + light[0], True
        return self._count > before

    def _sharpened(self, turn: int) -> tuple[tuple[float, ...], int]:
        """The shifts of a place's vector of that number, and of those up to which others."""
        first, until = self.shifts[0], _SHARPENED_FROM
        while turn >= until:
            until *= _SHARPENED_BY
            first = max(first, min(until / ORDER_FITTED * self.shifts[0], self._highest))
        return (first, *self.shifts[1:]), until

    def _reserve(self, count: int) -> None:
        had = len(self._basis)
        if count <= had:
            return
        more, dofs = max(count - had, had // 2), self._basis.shape[1]
        require(
            8.0 * float(had + more) * dofs,  # doubles
            f"a basis of {count} vectors of {dofs} dofs",
            "ask for fewer oscillators or a larger rtol, or coarsen the mesh away from the contact",
        )
        self._basis = np.concatenate([self._basis, np.empty((more, dofs))])
        self._stiffness = np.pad(self._stiffness, (0, more))

    def _extend(self, inverse: LinearSolver, wanted: int) -> None:
        self._reserve(wanted)

        def in_place(*buffers: memoryview) -> None:
            x, kx, mx = map(np.frombuffer, buffers)
            x[:], kx[:], mx[:] = inverse.solve_roughly(x.copy())

        _core.krylov_extend(
            self._K,
            self._M,
            inverse.s2,
            in_place,
            self._b,
            self._basis,
            self._stiffness,
            self._load,
            self.rigid_count,
            self._given,
            self._progress,
            wanted,
        )
        self.solver_name = inverse.name  # factors may have taken over

    def _inverse(self, shift: float) -> LinearSolver:
        if shift not in self._solvers:
            try:
                self._solvers[shift] = self.body.inverse(
                    shift**2,
                    solver=self._solver,
                    solutions=max(FEW_SOLUTIONS, self._wanted - self.rigid_count - self._solves),
                )
            except SingularError as error:
                raise SingularError(
                    f"{error} at s = {shift:.3g} rad/s, for motions of "
                    f"{SHIFT_TIMES_DURATION / shift:.3g} s: give the durations of the contact and "
                    "of the motion in seconds"
                ) from None
        self.solver_name = self._solvers[shift].name
        return self._solvers[shift]


# Products over all dofs without BLAS, whose threads change the last bits with the number of cores:
# what is left of a static mode across the other vectors may be as small as these are large.


def _products(vectors: FloatArray, x: FloatArray) -> FloatArray:
    found: FloatArray = np.einsum("kn,n->k", vectors, x)
    return found


def _combinations(parts: FloatArray, vectors: FloatArray) -> FloatArray:
    found: FloatArray = np.einsum("mk,kn->mn", parts, vectors)
    return found


def _norm(x: FloatArray, M: Any) -> float:
    return math.sqrt(np.einsum("n,n->", x, M @ x))
