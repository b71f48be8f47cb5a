"""Anti-oscillators that fit the blow: the paper's construction on a rational Krylov subspace.

The paper takes the constraint modes of the whole body, most of which a short blow never reaches.
Here the body is first projected on the vectors that a blow of duration T excites,
(K + s²M)⁻¹ b, (K + s²M)⁻¹ M (K + s²M)⁻¹ b, … with s ~ 1/T, each of which costs one solve; and, if
it is held, on its static mode, without which a short blow's vectors make it far too stiff.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from . import _core
from .checks import integer, positive
from .contact import ContactPoint
from .errors import InputError, InputTypeError, SingularError, warn
from .modes import star_of_modes
from .solvers import FEW_SOLUTIONS, LinearSolver, Solver, checked_solver
from .star import AOModel
from .statics import displacement, moves_rigidly

__all__ = [
    "SHIFT_TIMES_DURATION",
    "KrylovSpace",
    "Subspace",
    "fitted_shifts",
    "own_contact_time",
    "shortest_contact_time",
]

FloatArray = npt.NDArray[np.float64]

# s T of the shift for a blow of duration T. On the paper's beam 8 to 14 are alike, a third of it
# and three times as much need two more oscillators for the same force. A spread of shifts was
# measured to be worse for each solve.
SHIFT_TIMES_DURATION = 10.0

# A Ritz value below this share of the largest is none of an elastic motion.
_NO_STIFFNESS = 1e-12

# Vectors, as a multiple of the oscillators wanted, after which no more are tried for those missing.
_MOST_IDLE = 2

# As many times as many solutions are foreseen once there were more than foreseen.
_UNFORESEEN = 10

# What is left of b beside the rigid motions, over |b|, that is rounding.
_RIGID_ONLY = 1e-13


class Subspace:
    """A rational Krylov subspace of a body, seen from one or more places; it grows.

    Rigid motions come first, then the static modes of the places where these do not move the body.

    Parameters
    ----------
    tips : sequence of ContactPoint
        The places, on one body.
    shifts : sequence of float
        s of K + s²M, rad/s, taken in turn.
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
        solver: Solver = "auto",
    ) -> None:
        body = tips[0].body
        rigid = body.rigid_modes
        self.body = body
        self.rigid_count = rigid.shape[1]
        self.shifts = tuple(shifts)
        self.solver_name = ""
        self._solver = checked_solver(solver)
        self._solvers: dict[float, LinearSolver] = {}
        self._foreseen = FEW_SOLUTIONS
        # The rigid part would drown the rest where s is small; it is in the basis exactly.
        functionals = np.stack([tip.b for tip in tips])
        elastic = functionals - (functionals @ rigid) @ (body.M @ rigid).T
        silent = np.linalg.norm(elastic, axis=1) <= _RIGID_ONLY * np.linalg.norm(functionals)
        elastic[silent] = 0.0
        self._b = elastic
        self._held = [i for i, tip in enumerate(tips) if not moves_rigidly(tip)]
        self._basis = np.ascontiguousarray(rigid.T)
        self._stiffness = np.zeros((self.rigid_count, self.rigid_count))
        self._given = self._count = self.rigid_count
        self._statics, self._solves, self._wanted = 0, 0, 0
        self._K, self._M = _for_core(body.K), _for_core(body.M)

    @property
    def solves(self) -> int:
        """How many linear systems were solved so far, a static mode's counted as one."""
        return self._statics + self._solves

    @property
    def exhausted(self) -> bool:
        """Whether the functionals excite no more than what is there."""
        found: bool = self._count < self._wanted
        return found

    def grow(self, count: int) -> int:
        """Grow to `count` vectors, rigid motions included; return how many there are.

        There are fewer where the functionals excite no more. Those that were there stay.
        """
        self._reserve(count)
        self._wanted = max(self._wanted, count)
        while self._count < count and self._statics < len(self._held):
            self._add_static_mode(self._held[self._statics])
            self._statics += 1
        while self._count < count:
            # One solve at a time, so that signals are heard in between.
            # All functionals have their turn with a shift before the next shift has its own.
            shift = self.shifts[self._solves // len(self._b) % len(self.shifts)]
            before = self._solves
            solve = self._inverse(shift).solve
            self._count, self._solves = self._extend(
                self._b, shift**2, solve, self._given, self._solves
            )
            if self._solves == before:
                break
        size: int = min(count, self._count)
        return size

    def ritz(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return ω² (ascending) and M-orthonormal modes, shape (n_dofs, m), of `count` vectors.

        Raises
        ------
        SingularError
            If a mode that is no rigid motion has no stiffness.
        """
        size, rigid = self.grow(count), self.rigid_count
        omega2, y = la.eigh(self._stiffness[rigid:size, rigid:size])
        if (omega2 <= _NO_STIFFNESS * np.abs(omega2).max(initial=0.0)).any():
            raise SingularError(
                "a motion that is no rigid-body motion has no stiffness: part of the body is a "
                "mechanism (supports missing, a piece joined along one edge or at one point); see "
                "body.frequencies(10)"
            )
        modes = np.column_stack([self._basis[:rigid].T, self._basis[rigid:size].T @ y])
        return np.concatenate([np.zeros(rigid), omega2]), modes

    def _reserve(self, count: int) -> None:
        had = len(self._basis)
        if count <= had:
            return
        more = count - had
        self._basis = np.concatenate([self._basis, np.empty((more, self._basis.shape[1]))])
        self._stiffness = np.pad(self._stiffness, (0, more))

    def _add_static_mode(self, tip: int) -> None:
        before = self._count
        load = self._b[tip, None].copy()
        self._count, _ = self._extend(load, 0.0, self._static_mode, before, 0)
        self._given = self._count
        if self._count > before and self.shifts[0] ** 2 < self._stiffness[before, before]:
            # In a slow blow (K + s²M)⁻¹ b is φ_st but for rounding; what M φ_st gives spans the
            # same with φ_st, and would be φ_st but for rounding in a fast one.
            self._b[tip] = self.body.M @ self._basis[before]

    def _extend(
        self,
        loads: FloatArray,
        s2: float,
        solve: Callable[[FloatArray], FloatArray],
        given: int,
        solves: int,
    ) -> tuple[int, int]:
        """Grow by one vector beside those `given`; return the counts of vectors and of solves."""

        def in_place(buffer: memoryview) -> None:
            x = np.frombuffer(buffer)
            x[:] = solve(x.copy())

        return _core.krylov_extend(
            self._K,
            self._M,
            s2,
            in_place,
            loads,
            self._basis,
            self._stiffness,
            self.rigid_count,
            given,
            self._count,
            solves,
            self._count + 1,
        )

    def _inverse(self, shift: float) -> LinearSolver:
        while self._solves >= self._foreseen:
            # More than were foreseen: what iterates is chosen anew, for many times as many.
            self._foreseen *= _UNFORESEEN
            if self._solver == "auto":
                direct = {s: one for s, one in self._solvers.items() if one.precondition is None}
                self._solvers = direct
        if shift not in self._solvers:
            try:
                self._solvers[shift] = self.body.inverse(
                    shift**2, solver=self._solver, solutions=self._foreseen
                )
            except SingularError as error:
                raise SingularError(
                    f"{error} at s = {shift:.3g} rad/s, for motions of "
                    f"{SHIFT_TIMES_DURATION / shift:.3g} s: give the durations of the contact and "
                    "of the motion in seconds"
                ) from None
        self.solver_name = self._solvers[shift].name
        return self._solvers[shift]

    def _static_mode(self, load: FloatArray) -> FloatArray:
        invert = partial(self.body.inverse, solver=self._solver, solutions=1)
        return displacement(self.body, load, invert, dynamic=self._inverse(min(self.shifts)))


class KrylovSpace:
    """The space from which scene-fitted anti-oscillators of a body are made; it grows.

    `antioscillators(tip, n, method="krylov")` makes one and asks it once. Kept by hand it gives
    models of any order, the next one for a single solve more. A held body's static mode costs, by
    direct solvers, some six solves with the same factors if the body is compact; if it is slender
    or thin and of elements of second order, some ten to thirty and the factors of the linear
    elements on its corners. If that does not do (slender and of linear elements or without a mesh;
    in part free), it takes a factorisation of K, as large again as that of K + s²M.

    Parameters
    ----------
    tip : ContactPoint
        From `FEModel.contact`.
    contact_time : float, optional
        How long the blow lasts, s; within a factor of two or three is near enough. Without it, as
        long as half an oscillation of the body's mass on the stiffness of its contact coordinate.
    duration : float, optional
        How long the body's motion is to be right, s, if that is much longer than the blow: every
        other vector is then fitted to it, which takes a second factorisation. Without it the
        motion is right for some blows' lengths; always right are a free body's as a whole and what
        a held one does under forces that change slowly.
    solver : str or callable, optional
        See `FEModel.inverse`.

    Raises
    ------
    InputError
        If `contact_time` is shorter than what the mesh resolves.
    """

    def __init__(
        self,
        tip: ContactPoint,
        *,
        contact_time: float | None = None,
        duration: float | None = None,
        solver: Solver = "auto",
    ) -> None:
        if not isinstance(tip, ContactPoint):
            raise InputTypeError(f"tip must come from FEModel.contact(...), got {tip!r}")
        self.tip = tip
        self.shift = fitted_shifts([tip], contact_time, None)[0]
        self.contact_time = SHIFT_TIMES_DURATION / self.shift
        self._space = Subspace([tip], [self.shift], solver=solver)
        if duration is not None:
            self.include(duration)
        # A held body's static mode is one more vector; a free one's is rigid, and there already.
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
        return star

    def of_vectors(self, n: int) -> AOModel:
        """Return the model of `n` vectors beside the static one: of `n` oscillators, or fewer."""
        omega2, modes = self._space.ritz(self._first + n)
        return star_of_modes(
            self.tip,
            omega2,
            modes,
            "AO",
            solver=self._space.solver_name,
            contact_time=self.contact_time,
        )

    @property
    def exhausted(self) -> bool:
        """Whether all that b excites is in the space."""
        return self._space.exhausted

    def include(self, duration: float) -> None:
        """Fit every other vector from here on to motion of that duration, s, as well."""
        slow = SHIFT_TIMES_DURATION / positive("duration", duration, unit="s")
        if slow < self.shift:
            self._space.shifts = (self.shift, slow)


def fitted_shifts(
    tips: Sequence[ContactPoint], contact_time: float | None, duration: float | None
) -> list[float]:
    """Return the shifts s, rad/s, for blows that long at any of the tips, and motion that long."""
    if contact_time is None:
        times = [min(own_contact_time(tip) for tip in tips)]
    else:
        times = [positive("contact_time", contact_time, unit="s")]
        for tip in tips:
            _check_resolved(tip, contact_time)
    if duration is not None and positive("duration", duration, unit="s") > times[0]:
        times.append(duration)
    return [SHIFT_TIMES_DURATION / time for time in times]


def own_contact_time(tip: ContactPoint) -> float:
    """Half a period of the body's mass on the stiffness that its elements give the contact, s."""
    body, b = tip.body, tip.b
    share = float(b @ b)
    stiffness = float(b @ (body.K @ b)) / share**2
    mass = float(body.M.diagonal().sum()) if body.mass is None else body.mass
    if stiffness <= 0.0:
        raise InputError("no contact_time can be estimated where K gives b no stiffness; give it")
    return math.pi * math.sqrt(mass / stiffness)


def shortest_contact_time(tip: ContactPoint) -> float:
    """The shortest blow that the mesh resolves at the contact, s: shorter waves are elements."""
    body, b = tip.body, tip.b
    highest = math.sqrt(float(b @ (body.K @ b)) / float(b @ (body.M @ b)))
    return SHIFT_TIMES_DURATION / highest


def _check_resolved(tip: ContactPoint, contact_time: float) -> None:
    shortest = shortest_contact_time(tip)
    if contact_time < shortest:
        raise InputError(
            f"contact_time={contact_time:g} s is shorter than what the mesh resolves at the "
            f"contact, {shortest:.2g} s: give the duration of the contact in seconds, or refine "
            "the mesh"
        )


def _for_core(matrix: Any) -> tuple[Any, ...]:
    csr = matrix.tocsr()
    return (
        csr.indptr.astype(np.int32, copy=False),
        csr.indices.astype(np.int32, copy=False),
        csr.data,
    )
