"""Anti-oscillators fitted to the contact time: the paper's, on a rational Krylov subspace.

The paper takes the constraint modes of the whole body. A short contact does not excite most of
them. Here the body is first projected on the vectors that a contact of duration T excites,
(K + s²M)⁻¹ b, (K + s²M)⁻¹ M (K + s²M)⁻¹ b, … with s ~ 1/T, each of which costs one solve; and, if
it is constrained, on its static mode, without which the model of few vectors is far too stiff.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import scipy

from .. import _core
from ..base import (
    FloatArray,
    InputError,
    InputTypeError,
    SingularError,
    boolean,
    integer,
    positive,
    require,
    warn,
)
from ..fem import ContactPoint, displacement, moves_rigidly, refuse_mechanism
from ..linalg import (
    FEW_SOLUTIONS,
    LinearSolver,
    Solver,
    SolverBook,
    checked_solver,
    core_rows,
    stays_quickest,
)
from .contactstiffness import contact_stiffness
from .modes import star_of_modes
from .star import AOModel

__all__ = [
    "SHIFT_TIMES_DURATION",
    "KrylovSpace",
    "Subspace",
    "fitted_shifts",
    "highest_shift",
    "own_contact_time",
    "shortest_contact_time",
]


# s T of the shift for a contact of duration T. On the paper's beam 8 to 14 are alike, a third of it
# and three times as much need two more oscillators for the same force. A spread of shifts was
# measured to be worse for each solve.
SHIFT_TIMES_DURATION = 10.0

# The order that this is best for; more vectors are best with s T in proportion, up to the highest
# frequency of the mesh at the contact. On a clamped beam of 17 000 dofs and a clamped plate of
# 19 000, 200 and 550 vectors then give the force to ten digits, 800 with the shift above to four.
_ORDER_FITTED = 5

# So many vectors for each place after which s is fitted to four times as many, and again, each time
# at the price of a factorisation.
_SHARPENED_FROM, _SHARPENED_BY = 48, 4

# Below this share of the largest, a Ritz value may be that of a mechanism, but slender bodies under
# short contacts span as much. It is one if it is at most this share of the sum of the magnitudes of
# its terms: some hundred roundings.
_DOUBTFUL, _NO_STIFFNESS = 1e-12, 1e-14

# Vectors, as a multiple of the oscillators wanted, after which no more are tried for those missing.
_MOST_IDLE = 2

# When there are more solutions than foreseen, so many times as many are foreseen: iterations are
# given up for factors once they have cost as much as these would have.
_UNFORESEEN = 2

# A vector of which less than this share is new is a combination of those before it.
_NOTHING_NEW = 1e-11

# Vectors in whose span a compact body's static mode is searched, for each place; the share of |b|
# that is left then; how many more will find it at most; and what is left in the end. The error of
# bᵀx goes with the square of that, but its direction across the other vectors does not. It spares a
# factorisation of K: models of 8 oscillators on blocks of 9 400 and 42 000 dofs are made 1.7 and
# 2.1 times as fast.
_FIRST, _PROMISING, _LAST, _REACHED = 6, 0.1, 8, 1e-7

_BYTES_PER_NUMBER = 8.0

# What is left of b beside the rigid motions, over |b|, that is rounding.
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

    Attributes
    ----------
    solver_name : str
        What solved; empty before the first solution.
    """

    def __init__(
        self,
        tips: Sequence[ContactPoint],
        shifts: Sequence[float],
        *,
        highest: float = 0.0,
        solver: Solver = "auto",
    ) -> None:
        body = tips[0].body
        refuse_mechanism(tips)
        rigid = body.rigid_modes
        self.body = body
        self.rigid_count = rigid.shape[1]
        self.shifts = tuple(shifts)
        self._highest = highest
        self.solver_name = ""
        self._solver = checked_solver(solver)
        self._solvers: dict[float, LinearSolver] = {}
        self._foreseen = FEW_SOLUTIONS
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
        """Whether the functionals excite no more than what is there."""
        return len(self._ordered) < self._wanted

    def grow(self, count: int) -> int:
        """Grow to `count` vectors, rigid motions included; return how many there are.

        There are fewer where the functionals excite no more. Those that were there stay.
        """
        self._wanted = max(self._wanted, count)
        self._foresee(self._wanted - self.rigid_count)
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

    def ritz(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return ω² (ascending) and M-orthonormal modes, shape (n_dofs, m), of `count` vectors.

        Raises
        ------
        SingularError
            If a mode that is no rigid motion has no stiffness.
        """
        omega2, coordinates = self.ritz_on_basis(count)
        return omega2, self.vectors @ coordinates

    @property
    def vectors(self) -> FloatArray:
        """The M-orthonormal basis, shape (n_dofs, there), as it is now."""
        return self.first_vectors(self._count)

    def first_vectors(self, count: int) -> FloatArray:
        """Return the first vectors of the basis: a view, which keeps its memory allocated."""
        return self._basis[:count].T

    def ritz_on_basis(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return ω² and the modes' coordinates on `vectors`, shape (there, m); as `ritz`."""
        size, rigid = self.grow(count), self.rigid_count
        elastic = self._coordinates()[rigid:size]
        there = self._stiffness[: self._count, : self._count]
        omega2, y = scipy.linalg.eigh(elastic @ there @ elastic.T)
        doubtful = omega2 <= _DOUBTFUL * np.abs(omega2).max(initial=0.0)
        if self._without_stiffness(omega2[doubtful], elastic.T @ y[:, doubtful]):
            raise SingularError(
                "a motion that is no rigid-body motion has no stiffness: part of the body is a "
                "mechanism (supports missing, a piece joined along one edge or at one point); see "
                "body.frequencies(10)"
            )
        whole = np.eye(self._count, min(rigid, size))
        coordinates = np.column_stack([whole, elastic.T @ y])
        return np.concatenate([np.zeros(min(rigid, size)), omega2]), coordinates

    def _without_stiffness(self, omega2: FloatArray, coordinates: FloatArray) -> bool:
        """Whether any of these Ritz values is no more than rounding of K, in its own motion."""
        sizes = np.abs(self._basis[: self._count].T @ coordinates)
        if not sizes.size:
            return False
        rounding = (sizes * (abs(self.body.K) @ sizes)).sum(axis=0)
        return bool((omega2 <= _NO_STIFFNESS * rounding).any())

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

        In compact bodies they lie in the span of the vectors that are wanted anyway, and of a few
        more; else K is factorised.
        """
        if not self._held:
            return []
        loads = self._b[self._held]
        wanted -= int(np.linalg.matrix_rank(loads))
        places = int(np.linalg.matrix_rank(self._b))
        dynamic = self._inverse(min(self.shifts))
        # An iterative method solves for K itself at the cost of few solves.
        direct = dynamic.precondition is None
        if direct:
            wanted = max(wanted, _FIRST * places)
        self._solve_to(wanted)
        within, left = self._galerkin(loads)
        for _ in range(_LAST if direct else 0):
            if not _REACHED < left <= _PROMISING:
                break
            self._solve_to(self._count - self._given + places)
            within, left = self._galerkin(loads)
        if left <= _REACHED:
            return list(within)
        invert = SolverBook(
            dynamic.at or partial(self.body.inverse, solver=self._solver, solutions=len(loads))
        )
        return [
            self._outside(place, displacement(self.body, load, invert))
            for place, load in enumerate(loads)
        ]

    def _galerkin(self, loads: FloatArray) -> tuple[FloatArray, float]:
        """K⁻¹ of each load in the span of the vectors so far, and the largest |b - K x|/|b|."""
        new = slice(self._given, self._count)
        vectors = self._basis[new]
        stiffness = self._stiffness[new, new]
        found = np.zeros((len(loads), self._count))
        if not (stiffness.diagonal() > 0.0).all():  # rounding of K, or a mechanism
            return found, np.inf
        scale = 1.0 / np.sqrt(stiffness.diagonal())
        try:
            factors = scipy.linalg.cho_factor(scale[:, None] * stiffness * scale)
        except np.linalg.LinAlgError:
            return found, np.inf
        found[:, new] = scale * scipy.linalg.cho_solve(factors, (loads @ vectors.T * scale).T).T
        rest = loads - (self.body.K @ (found[:, new] @ vectors).T).T
        sizes = np.linalg.norm(loads, axis=1)
        return found, float((np.linalg.norm(rest, axis=1) / np.where(sizes > 0, sizes, 1.0)).max())

    def _outside(self, place: int, x: FloatArray) -> FloatArray:
        """Put what is new of a static mode found by other means in its place in the basis."""
        self._statics += 1
        K, M, slot = self.body.K, self.body.M, self.rigid_count + place
        coordinates = np.zeros(self._count)
        vectors = self._basis[: self._count]
        size = math.sqrt(x @ (M @ x))
        for _ in range(2):
            parts = vectors @ (M @ x)
            x = x - parts @ vectors
            coordinates += parts
        length = math.sqrt(x @ (M @ x))
        if length > _NOTHING_NEW * size:
            coordinates[slot] = length
            vectors[slot] = x / length
            row = vectors @ (K @ vectors[slot])
            row[: self.rigid_count] = 0.0
            self._stiffness[slot, : self._count] = self._stiffness[: self._count, slot] = row
        return coordinates

    def _solve_to(self, vectors: int) -> None:
        """Solve until there are so many vectors beside rigid motions and static modes."""
        while (missing := self._given + vectors - self._count) > 0 and self._solve(missing):
            pass

    def _solve(self, most: int) -> bool:
        """Add some vectors, at most so many; whether there was one."""
        # All functionals have their turn with a shift before the next shift has its own.
        turn = self._solves // len(self._b)
        shifts, until = self._sharpened(turn)
        for passed in set(self._solvers) - set(shifts):
            del self._solvers[passed]
        inverse = self._inverse(shifts[turn % len(shifts)])
        most = 1 if len(shifts) > 1 else min(most, until * len(self._b) - self._solves)
        before = self._count
        self._extend(inverse, before + min(most, self._foreseen - self._solves))
        return self._count > before

    def _sharpened(self, turn: int) -> tuple[tuple[float, ...], int]:
        """The shifts of a place's vector of that number, and of those up to which others."""
        first, until = self.shifts[0], _SHARPENED_FROM
        while turn >= until:
            until *= _SHARPENED_BY
            first = max(first, min(until / _ORDER_FITTED * self.shifts[0], self._highest))
        return (first, *self.shifts[1:]), until

    def _reserve(self, count: int) -> None:
        had = len(self._basis)
        if count <= had:
            return
        more, dofs = max(count - had, had // 2), self._basis.shape[1]
        require(
            _BYTES_PER_NUMBER * float(had + more) * dofs,
            f"a basis of {count} vectors of {dofs} dofs",
            "ask for fewer oscillators or a larger rtol, or coarsen the mesh away from the contact",
        )
        self._basis = np.concatenate([self._basis, np.empty((more, dofs))])
        self._stiffness = np.pad(self._stiffness, (0, more))

    def _extend(self, inverse: LinearSolver, wanted: int) -> None:
        self._reserve(wanted)

        def in_place(*buffers: memoryview) -> None:
            x, kx, mx = map(np.frombuffer, buffers)
            x[:], kx[:], mx[:] = inverse.solve_with_products(x.copy())

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

    def _inverse(self, shift: float) -> LinearSolver:
        if self._solves >= self._foreseen:
            self._foresee(_UNFORESEEN * self._solves)
        if shift not in self._solvers:
            try:
                self._solvers[shift] = self.body.inverse(
                    shift**2, solver=self._solver, solutions=self._foreseen - self._solves
                )
            except SingularError as error:
                raise SingularError(
                    f"{error} at s = {shift:.3g} rad/s, for motions of "
                    f"{SHIFT_TIMES_DURATION / shift:.3g} s: give the durations of the contact and "
                    "of the motion in seconds"
                ) from None
        self.solver_name = self._solvers[shift].name
        return self._solvers[shift]

    def _foresee(self, solutions: int) -> None:
        """Drop iterative solvers, if for so many solutions in all factors are quicker."""
        if solutions <= self._foreseen:
            return
        self._foreseen, left = solutions, solutions - self._solves
        if self._solver == "auto":
            self._solvers = {
                shift: one
                for shift, one in self._solvers.items()
                if one.precondition is None or stays_quickest(one, left)
            }


class KrylovSpace:
    """The space from which scene-fitted anti-oscillators of a body are made; it grows.

    `antioscillators(tip, n, method="krylov")` makes one and uses it once. Kept, it gives
    models of any order, the next one for a single solve more; up to three on symmetric bodies once
    the model is right to rounding, which then adds motions that b does not excite. The static mode
    of a constrained body is, in compact bodies, a combination of some six to ten vectors that
    larger models take anyway. In slender and thin ones it takes another factorisation, of K.

    Parameters
    ----------
    tip : ContactPoint
        From `FEModel.contact`.
    contact_time : float, optional
        How long the contact lasts, s; a factor of two or three does not matter. By default half a
        period of the body's mass on the stiffness of its contact coordinate, which is far too short
        for matrices without a mesh of nearly incompressible material.
    duration : float, optional
        How long the body's motion is to be right, s, if that is much longer than the contact: every
        other vector is then fitted to it, which takes a second factorisation. Without it the
        motion is right for some contact times. Always right are the motion of a free body as a
        whole and that of a constrained one under forces that change slowly.
    sharpened : bool, optional
        Whether vectors beyond the 48th and the 192nd are fitted to models that large, which takes
        another factorisation for each.
    solver : str or callable, optional
        See `FEModel.inverse`.

    Raises
    ------
    InputError
        If `contact_time` is shorter than what the mesh resolves.
    SingularError
        If the contact moves part of the body as a mechanism.
    """

    def __init__(
        self,
        tip: ContactPoint,
        *,
        contact_time: float | None = None,
        duration: float | None = None,
        sharpened: bool = False,
        solver: Solver = "auto",
    ) -> None:
        if not isinstance(tip, ContactPoint):
            raise InputTypeError(f"tip must come from FEModel.contact(...), got {tip!r}")
        self.tip = tip
        self.shift = fitted_shifts([tip], contact_time, None)[0]
        self.contact_time = SHIFT_TIMES_DURATION / self.shift
        highest = highest_shift(tip) if boolean("sharpened", sharpened) else 0.0
        self._space = Subspace([tip], [self.shift], highest=highest, solver=solver)
        if duration is not None:
            self.include(duration)
        # A constrained body's static mode is one more vector; a free one's is a rigid motion.
        self._first = self._space.rigid_count + (0 if moves_rigidly(tip) else 1)

    @property
    def solves(self) -> int:
        """How many linear systems were solved so far."""
        return self._space.solves

    def antioscillators(self, n: int) -> AOModel:
        """Return the model of `n` anti-oscillators, in ascending frequency; see `antioscillators`.

        Parameters
        ----------
        n : int
            0 … n_dofs - 1.
        """
        wanted = integer("n", n, low=0, high=self.tip.body.n_dofs - 1)
        vectors = wanted
        star = self.of_vectors(vectors)
        while star.n < wanted and not self.exhausted and vectors < _MOST_IDLE * wanted:
            # Where b excites only some modes, rounding adds vectors of the others.
            vectors += wanted - star.n
            star = self.of_vectors(vectors)
        if star.n < wanted:
            warn(f"n={n}: only {star.n} anti-oscillators carry mass at this contact")
        return star if star.n <= wanted else _of_largest_mass(star, wanted)

    def of_vectors(self, n: int) -> AOModel:
        """Return the model of `n` vectors beside the static one: of `n` oscillators, or fewer."""
        return self.factored(n).multiplied_out()

    def factored(self, n: int) -> AOModel:
        """Return the model of `of_vectors` with shapes that are multiplied out when needed.

        It is made for much less, and holds the whole space as long as it lives.
        """
        vectors = integer("n", n, low=0)
        omega2, coordinates = self._space.ritz_on_basis(self._first + vectors)
        return star_of_modes(
            self.tip,
            omega2,
            self._space.vectors,
            "AO",
            coordinates=coordinates,
            vectors=partial(self._space.first_vectors, len(coordinates)),
            solver=self._space.solver_name,
            contact_time=self.contact_time,
        )

    def seen(self, n: int) -> AOModel:
        """Return what `factored` does, by its former name."""
        warnings.warn("seen is now called factored", DeprecationWarning, stacklevel=2)
        return self.factored(n)

    @property
    def exhausted(self) -> bool:
        """Whether all that b excites is in the space."""
        return self._space.exhausted

    def include(self, duration: float) -> None:
        """Fit every other vector from here on to motion of that duration, s, as well."""
        slow = SHIFT_TIMES_DURATION / positive("duration", duration, unit="s")
        if slow < self.shift:
            self._space.shifts = (self.shift, slow)


def _of_largest_mass(star: AOModel, n: int) -> AOModel:
    """The `n` oscillators of the largest mass, in the star's order; the others' joins m0."""
    by_mass = np.argsort(-star.m, kind="stable")
    order = np.concatenate([np.sort(by_mass[:n]), by_mass[n:]])
    assert star.origin is not None  # it was made from modes
    origin = replace(star.origin, oscillators=star.origin.oscillators[:, order])
    return replace(star, m=star.m[order], k=star.k[order], origin=origin).truncated(n)


def fitted_shifts(
    tips: Sequence[ContactPoint], contact_time: float | None, duration: float | None
) -> list[float]:
    """Return the shifts s, rad/s, for that contact time at any of the places, and duration."""
    if contact_time is None:
        times = [min(own_contact_time(tip) for tip in tips)]
        if math.isinf(times[0]):
            raise InputError(
                "no contact_time can be estimated where K gives b no stiffness; give it"
            )
    else:
        times = [positive("contact_time", contact_time, unit="s")]
        for tip in tips:
            _check_resolved(tip, contact_time)
    if duration is not None and positive("duration", duration, unit="s") > times[0]:
        times.append(duration)
    return [SHIFT_TIMES_DURATION / time for time in times]


def own_contact_time(tip: ContactPoint) -> float:
    """Half a period of the body's mass on the stiffness that its elements give the contact, s.

    Infinite where K gives b no stiffness.
    """
    body = tip.body
    stiffness = contact_stiffness(tip)
    mass = float(body.M.diagonal().sum()) if body.mass is None else body.mass
    return math.pi * math.sqrt(mass / stiffness) if stiffness > 0.0 else math.inf


def shortest_contact_time(tip: ContactPoint) -> float:
    """The shortest contact that the mesh resolves, s: a shorter wave is shorter than an element.

    0 where K gives b no stiffness, and so no waves.
    """
    highest = highest_shift(tip)
    return SHIFT_TIMES_DURATION / highest if highest > 0.0 else 0.0


def highest_shift(tip: ContactPoint) -> float:
    """The frequency of the elements at the contact, rad/s: it bounds from below the highest."""
    body, b = tip.body, tip.b
    return math.sqrt(max(0.0, float(b @ (body.K @ b)) / float(b @ (body.M @ b))))


def _check_resolved(tip: ContactPoint, contact_time: float) -> None:
    shortest = shortest_contact_time(tip)
    if contact_time < shortest:
        raise InputError(
            f"contact_time={contact_time:g} s is shorter than what the mesh resolves at the "
            f"contact, {shortest:.2g} s: give the duration of the contact in seconds, or refine "
            "the mesh"
        )
