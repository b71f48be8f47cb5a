"""Models fitted to the contact time: a body projected on motions that impacts at its ports excite.

The paper takes the constraint modes of the whole body, most of which a short contact does not
excite. Here the body is first projected on the vectors that a contact of duration T excites,
(K + s²M)⁻¹ b, (K + s²M)⁻¹ M (K + s²M)⁻¹ b, … with s ~ 1/T, each of which costs one solution. A
constrained body is projected on its static modes as well: without static modes a model of few
vectors is far too stiff.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
import scipy

from ..base import (
    PRINTED,
    ROUNDING,
    ConvergenceError,
    FloatArray,
    SingularError,
    bar,
    boolean,
    integer,
    require,
    warn,
)
from ..contact import (
    SHIFT_TIMES_DURATION,
    ContactPoint,
    fitted_shifts,
    highest_shift,
    moves_rigidly,
    refuse_massless,
    refuse_mechanism,
    slow_shift,
)
from ..fem import displacement
from ..linalg import (
    FEW_SOLUTIONS,
    LinearSolver,
    Solver,
    checked_solver,
)
from .body import Body, checked_ports, of_modes, ways_of
from .recovery import SOLVED
from .star import AOModel, excited, of_body

# Largest ratio between a shift and the best shift at which both are equally good. On the paper's
# beam, shifts from 8/T to 14/T are equally good, with the contact time T.
_AS_GOOD = 1.3

# Largest number of vectors per wanted oscillator in the search for missing oscillators.
_MOST_IDLE = 2


# Number of vectors for which the ratio of SHIFT_TIMES_DURATION to the contact time is the best
# shift. For more vectors the best shift grows in proportion, up to the highest frequency of the
# mesh at the contact. On a clamped beam of 17 000 dofs and a clamped plate of 19 000, 200 and 550
# vectors then give the force to ten digits; with an unchanged shift, 800 vectors give four digits.
ORDER_FITTED = 5

# _SHARPENED_FROM: number of vectors per contact point after which the shift is first raised.
# _SHARPENED_BY: ratio of the next such number to the last one; the raised shift is best for the
# next number. Each change costs a factorisation.
_SHARPENED_FROM, _SHARPENED_BY = 48, 4

# Largest stiffness of a mechanism, relative to the sum of absolute values of its terms: some
# hundred rounding errors.
_NO_STIFFNESS = 1e-14

# Ratio of a vector's lengths after and before a pass of Gram-Schmidt above which a further pass
# would change no digit.
_NO_CANCELLATION = 0.5

# For the search of a compact body's static mode in the span of Krylov vectors: _FIRST: first number
# of vectors per contact point; _PROMISING: largest relative residual at which one more vector per
# point is tried; _LAST: largest number of such trials; _REACHED: relative residual at which the
# search succeeds. For the static mode x, the error of bᵀx is of the order of the residual squared,
# but not the error of the part of x orthogonal to the other vectors. Success spares a factorisation
# of K: models of 8 oscillators of blocks of 9 400 and 42 000 dofs are made 1.7 and 2.1 times as
# fast.
_FIRST, _PROMISING, _LAST, _REACHED = 6, 0.1, 8, 1e-7

# Largest ω² = xᵀKx/xᵀMx of a vector x, relative to the largest K_ii/M_ii. Above this limit x has
# practically no mass, and its rounding errors spoil other vectors. The ratio is up to 3 in bodies
# with mass everywhere; if M is singular, modes are lost with limits of 2000 and more.
_WITHOUT_MASS = 300.0


class KrylovSpace:
    """The Krylov space of a body's models fitted to a scene, which grows with their order.

    `antioscillators(tip, n, method="krylov")` and `interface` make a space for a single use. A
    space that is kept returns models of any order; each next order costs one more solution.
    Symmetric bodies may need up to three solutions when models are accurate to rounding errors,
    which then add motions that no port excites. The static mode of a constrained compact body is a
    combination of some six to ten vectors, which larger models need anyway. For slender and thin
    bodies, the static mode takes a factorisation of K.

    Parameters
    ----------
    tips : ContactPoint, or a sequence of them
        Contact points on one body, from `FEModel.contact`.
    contact_time : float, optional
        Duration of the contact, s, to a factor of two or three. By default half a period of the
        body's mass on the stiffness of its contact coordinate. This default is far too short for
        matrices without a mesh if the material is nearly incompressible.
    duration : float, optional
        Duration for which the body's motion must be accurate, s, if much longer than the contact;
        ``math.inf`` for the lowest natural modes. Every other vector is then fitted to this
        duration, at the price of a second factorisation. By default the motion is accurate for a
        few contact times. The motion of a free body as a whole, and that of a constrained body
        under slowly varying forces, is always accurate.
    sharpened : bool, optional
        True to fit vectors beyond the 48th, and again beyond the 192nd, to models of that size.
        Each of the two changes costs a further factorisation.
    solver : str or callable, optional
        See `FEModel.inverse`.

    Raises
    ------
    InputError
        If the tips are not on one body, or `contact_time` is shorter than what the mesh resolves.
    SingularError
        If a port moves part of the body as a mechanism.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> space = KrylovSpace(bar.contact(point=(0.1, 0.005, 0.005)), contact_time=1e-4)
    >>> [space.antioscillators(n).n for n in (2, 3)]  # the second costs one more solution
    [2, 3]
    """

    def __init__(
        self,
        tips: ContactPoint | Sequence[ContactPoint],
        *,
        contact_time: float | None = None,
        duration: float | None = None,
        sharpened: bool = False,
        solver: Solver = "auto",
    ) -> None:
        self.tips = checked_ports("tips", tips)
        body = self.body = self.tips[0].body
        shift = fitted_shifts(self.tips, contact_time, None)[0]
        highest = min(map(highest_shift, self.tips))
        other = self.tips[0].shift or shift  # the body may have a solver with this shift
        near = abs(math.log(other / shift)) <= math.log(_AS_GOOD)
        if near and other <= highest and len(self.tips) == 1:
            shift = other
        self.contact_time = SHIFT_TIMES_DURATION / shift
        refuse_mechanism(self.tips)
        refuse_massless(self.tips)
        # shift: s of K + s²M, rad/s, which grows with the number of vectors; _slow: shifts for slow
        # motion, which alternate with `shift`.
        self.shift, self._slow = shift, tuple[float, ...]()
        self._highest = highest if boolean("sharpened", sharpened) else 0.0
        self.solver_name, self._solver = "", checked_solver(solver)
        self._solvers: dict[float, LinearSolver] = {}
        rigid = body.rigid_modes
        self.rigid_count = rigid.shape[1]
        # Rigid motions are taken out of b: the basis contains them, and for small s they would
        # dominate the Krylov vectors.
        functionals = np.stack([tip.b for tip in self.tips])
        elastic = functionals - (functionals @ rigid) @ (body.M @ rigid).T
        rigid_only = np.linalg.norm(elastic, axis=1) <= ROUNDING * np.linalg.norm(functionals)
        elastic[rigid_only] = 0.0
        self._b = elastic
        self._held = [i for i, tip in enumerate(self.tips) if not moves_rigidly(tip)]
        # The basis: rigid motions; a slot for each static mode outside the span of the other
        # vectors, zero until it is needed; and the Krylov vectors.
        self._given = self.rigid_count + len(self._held)
        self._count: int = self._given
        self._solved = 0
        self._basis = np.zeros((self._given, body.n_dofs))
        self._basis[: self.rigid_count] = rigid.T
        self._stiffness = np.zeros((self._given, self._given))
        # _ordered: coordinates on the basis of the models' vectors, in order. _next: next Krylov
        # vector.
        self._ordered = list(np.eye(self.rigid_count, self._given))
        self._next = self._given
        self._statics, self._wanted, self._ended = 0, 0, False
        stiffness, mass = body.K.diagonal(), body.M.diagonal()
        heavy = mass > 0.0
        self._fastest = _WITHOUT_MASS * float((stiffness[heavy] / mass[heavy]).max())
        if duration is not None:
            self.include(duration)

    @property
    def solves(self) -> int:
        """Number of linear systems solved so far; each static mode counts as one."""
        return self._statics + self._solved

    @property
    def exhausted(self) -> bool:
        """True if the space contains all motions that the ports excite."""
        return len(self._ordered) < self._wanted

    def release(self) -> None:
        """Free the memory of the factors, which are recomputed if they are needed again.

        :meta private:
        """
        self._solvers.clear()

    def include(self, duration: float) -> None:
        """Fit every other vector from now on to motion of the duration `duration`, s.

        :meta private:
        """
        slow = slow_shift(self.tips[0], duration)
        self._slow = (slow,) if slow < self.shift else ()

    def antioscillators(self, n: int) -> AOModel:
        """Return the model of `n` anti-oscillators, in ascending frequency; see `antioscillators`.

        Parameters
        ----------
        n : int
            0 … n_dofs - 1.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> space = KrylovSpace(bar.contact(point=(0.09, 0.005, 0.01)), contact_time=1e-4)
        >>> [space.antioscillators(n).n for n in (2, 3)]
        [2, 3]
        """
        wanted = integer("n", n, low=0, high=self.tips[0].body.n_dofs - 1)
        vectors = wanted
        star = self.of_vectors(vectors).alone.star
        while star.n < wanted and not self.exhausted and vectors < _MOST_IDLE * wanted:
            # If b excites few modes, rounding errors add vectors that are no oscillators.
            vectors += wanted - star.n
            star = self.of_vectors(vectors).alone.star
        if star.n < wanted:
            warn(f"n={n}: only {star.n} anti-oscillators carry mass at this contact")
        return star if star.n <= wanted else _of_largest_mass(star, wanted)

    def of_vectors(self, n: int) -> Body:
        """Return the model of the static mode and `n` further vectors: `n` oscillators, or fewer.

        The model is cheap, as its modes are computed only when needed, but it keeps a reference to
        the whole space.

        :meta private:
        """
        # The static mode of a constrained body is one more vector; the static mode of a free body
        # is a rigid motion.
        first = self.rigid_count + (0 if moves_rigidly(self.tips[0]) else 1)
        return only_excited(self.of_all(first + integer("n", n, low=0), "AO"))

    def of_all(self, n: int, kind: str = "interface") -> Body:
        """Return the model of `n` vectors, rigid motions included, or of all if there are fewer.

        Only the first vectors of the basis are used, as many as needed, so that the result is
        bitwise independent of later vectors.

        Raises
        ------
        SingularError
            If a mode that is no rigid motion has no stiffness.

        :meta private:
        """
        with bar(f"model of {self.body.n_dofs} dofs", unit="solution"):
            size, rigid = self._grow(n), self.rigid_count
        elastic = self._coordinates()[rigid:size]
        first = max(rigid, 1 + int(np.flatnonzero(elastic.any(axis=0)).max(initial=-1)))
        elastic, there = elastic[:, :first], self._stiffness[:first, :first]
        omega2, y = scipy.linalg.eigh(elastic @ there @ elastic.T)
        doubtful = omega2 <= ROUNDING * np.abs(omega2).max(initial=0.0)
        if doubtful.any():
            # Recompute the stiffness of soft motions from K: the projected stiffness has the
            # rounding errors of the stiffest motion. Values below the rounding errors of K are
            # mechanisms.
            K, motions = self.body.K, self._basis[:first].T @ (elastic.T @ y[:, doubtful])
            soft, turned = scipy.linalg.eigh(motions.T @ (K @ motions))
            sizes = np.abs(motions @ turned)
            if (soft <= _NO_STIFFNESS * (sizes * (abs(K) @ sizes)).sum(axis=0)).any():
                raise SingularError(
                    "a motion that is no rigid-body motion has no stiffness: part of the body is a "
                    "mechanism (supports missing, a piece joined along one edge or at one point); "
                    "see body.frequencies(10)"
                )
            omega2[doubtful], y[:, doubtful] = soft, y[:, doubtful] @ turned
        whole = np.eye(first, min(rigid, size))
        return of_modes(
            self.tips,
            np.concatenate([np.zeros(whole.shape[1]), omega2]),
            partial(self._first_vectors, first),
            np.column_stack([whole, elastic.T @ y]),
            kind=kind,
            linear_solver=self.solver_name,
            contact_time=self.contact_time,
            slow=SHIFT_TIMES_DURATION / self._slow[0] if self._slow else None,
        )

    def _first_vectors(self, count: int) -> FloatArray:
        """First vectors of the M-orthonormal basis, shape (n_dofs, count), as a view."""
        return self._basis[:count].T

    def _grow(self, count: int) -> int:
        """Grow the space to `count` vectors, rigid motions included; return their number.

        There are fewer vectors if the functionals excite no more motions. Earlier vectors do not
        change. Rigid motions come first, then the static modes of ports that rigid motions do not
        move.
        """
        self._wanted = max(self._wanted, count)
        if len(self._ordered) == self.rigid_count < count and self._next == self._given:
            for coordinates in self._static_modes(count - self.rigid_count):
                self._append(coordinates)
        while len(self._ordered) < count:
            if self._next == self._count and not self._solve(count - len(self._ordered)):
                break
            self._append(np.eye(1, self._count, self._next)[0])
            self._next += 1
        return min(count, len(self._ordered))

    def _coordinates(self) -> FloatArray:
        padded = np.zeros((len(self._ordered), self._count))
        for row, coordinates in zip(padded, self._ordered, strict=True):
            row[: len(coordinates)] = coordinates
        return padded

    def _append(self, coordinates: FloatArray) -> None:
        """Append the vector with given coordinates, unless earlier vectors already contain it."""
        before, rest = self._coordinates(), coordinates.copy()
        for _ in range(2):
            rest -= (before @ rest) @ before
        length = float(np.linalg.norm(rest))
        if length > ROUNDING * float(np.linalg.norm(coordinates)):
            self._ordered.append(rest / length)

    def _static_modes(self, wanted: int) -> list[FloatArray]:
        """Return coordinates of the static modes, for `wanted` vectors besides rigid motions.

        With an iterative solver, static modes come before all other vectors, which are made
        orthogonal to them. In the reverse order, errors of the approximate solutions would displace
        slow motions.
        """
        if not self._held:
            return []
        loads = self._b[self._held]
        dynamic = self._inverse(min((self.shift, *self._slow)))
        if dynamic.precondition is None:
            within = self._spanned(loads, wanted - int(np.linalg.matrix_rank(loads)))
            if within is not None:
                return list(within)
        invert = lru_cache(1)(dynamic.at or partial(self.body.inverse, solver=self._solver))
        found = []
        for slot, (place, load) in enumerate(zip(self._held, loads, strict=True), self.rigid_count):
            # An approximate solution is not shared, since it depends on the shift of its
            # preconditioner.
            known = {} if dynamic.precondition else self.tips[place].deflections
            if self._solver not in known:
                known[self._solver] = displacement(self.body, load, invert, tolerance=SOLVED)
            self._statics += 1
            # The orthogonal remainder of the static mode takes the slot in the basis.
            x = known[self._solver]
            x, _, coordinates, length = self._across(x, self.body.M @ x)
            if length > 0.0:
                coordinates[slot] = length
                self._put(slot, x / length)
            found.append(coordinates)
        return found

    def _across(
        self, x: FloatArray, mx: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        """Return x made M-orthogonal to the basis, M x, the coordinates removed, and x's length.

        The length is 0 if the new x is a rounding error. Gram-Schmidt passes end with a pass that
        hardly shortens x.
        """
        vectors, parts, before = self._basis[: self._count], np.zeros(self._count), math.inf
        size = length = _length(x, mx)
        while ROUNDING * size < length < _NO_CANCELLATION * before:
            along = _products(vectors, mx)
            x, parts, before = x - _combinations(along[None], vectors)[0], parts + along, length
            mx = self.body.M @ x
            length = _length(x, mx)
        return x, mx, parts, length if length > ROUNDING * size else 0.0

    def _put(self, slot: int, vector: FloatArray) -> None:
        """Store a basis vector, and its inner products in K with all vectors (rigid motions: 0)."""
        if not np.isfinite(vector).all():
            raise ConvergenceError(
                "a motion that the contact excites overflows, since it has hardly any mass"
            )
        self._basis[slot] = vector
        self._count = max(self._count, slot + 1)
        row = _products(self._basis[: self._count], self.body.K @ vector)
        row[: self.rigid_count] = 0.0
        self._stiffness[slot, : self._count] = self._stiffness[: self._count, slot] = row

    def _spanned(self, loads: FloatArray, wanted: int) -> FloatArray | None:
        """Return K⁻¹ of each load as coordinates on Krylov vectors; None if outside their span.

        If the residual of `wanted` vectors is small, more vectors are tried. In compact bodies this
        search spares a factorisation of K.
        """
        places = int(np.linalg.matrix_rank(self._b))
        sizes = np.linalg.norm(loads, axis=1)
        wanted = max(wanted, _FIRST * places)
        for _ in range(1 + _LAST):
            while (missing := self._given + wanted - self._count) > 0 and self._solve(missing):
                pass
            found, new = np.zeros((len(loads), self._count)), slice(self._given, self._count)
            stiffness, vectors = self._stiffness[new, new], self._basis[new]
            if not (stiffness.diagonal() > 0.0).all():  # rounding errors of K, or a mechanism
                return None
            scale = 1.0 / np.sqrt(stiffness.diagonal())
            try:
                factors = scipy.linalg.cho_factor(scale[:, None] * stiffness * scale)
            except np.linalg.LinAlgError:
                return None
            for row, load in zip(found, loads, strict=True):
                forces = scale * _products(vectors, load)
                row[new] = scale * scipy.linalg.cho_solve(factors, forces)
            rest = loads - (self.body.K @ _combinations(found[:, new], vectors).T).T
            left = (np.linalg.norm(rest, axis=1) / np.where(sizes > 0.0, sizes, 1.0)).max()
            if left <= _REACHED:
                return found
            if left > _PROMISING:
                return None
            wanted = self._count - self._given + places
        return None

    def _solve(self, most: int) -> bool:
        """Add some vectors, at most `most`; return True if at least one was new."""
        if self._ended:
            return False
        # All functionals are used in turn with one shift before the next shift.
        solves, places = self._solved, len(self._b)
        turn, until, first = solves // places, _SHARPENED_FROM, self.shift
        while turn >= until:
            until *= _SHARPENED_BY
            first = max(first, min(until / ORDER_FITTED * self.shift, self._highest))
        shifts = (first, *self._slow)
        for passed in set(self._solvers) - set(shifts):  # solvers of the shift before it was raised
            at = self._solvers.pop(passed).at
            if at is not None and first not in self._solvers:
                self._solvers[first] = at(first**2)
        inverse = self._inverse(shifts[turn % len(shifts)])
        most = 1 if len(shifts) > 1 else min(most, until * places - solves)
        before = self._count
        wanted = before + min(most, max(1, solves))  # solutions are at most doubled
        had, dofs = self._basis.shape
        if wanted > had:
            more = max(wanted - had, had // 2)
            require(
                8.0 * float(had + more) * dofs,  # bytes
                f"a basis of {wanted} vectors of {dofs} dofs",
                "ask for fewer oscillators or a larger rtol, or coarsen the mesh away from the "
                "contact",
            )
            self._basis = np.concatenate([self._basis, np.empty((more, dofs))])
            self._stiffness = np.pad(self._stiffness, (0, more))

        while self._count < wanted and self._given + self._solved < places + self._count:
            turn = self._solved
            if turn < places:
                self._load = self._b[turn]
            elif places > 1:  # with one functional, the last pass has set the load
                self._load = self.body.M @ self._basis[self._given + turn - places]
            x, _, mx = inverse.solve_roughly(self._load)
            self._solved += 1
            x, mx, _, length = self._across(x, mx)
            if length > 0.0:
                self._load = mx / length
                self._put(self._count, x / length)
        self.solver_name = inverse.name  # an iterative solver may have been replaced by factors
        light = np.flatnonzero(np.diagonal(self._stiffness)[before : self._count] > self._fastest)
        if len(light):
            self._count, self._ended = before + int(light[0]), True
        return self._count > before

    def _inverse(self, shift: float) -> LinearSolver:
        if shift not in self._solvers:
            try:
                self._solvers[shift] = self.body.inverse(
                    shift**2,
                    solver=self._solver,
                    solutions=max(FEW_SOLUTIONS, self._wanted - self.rigid_count - self._solved),
                )
            except SingularError as error:
                raise SingularError(
                    f"{error} at s = {shift:.3g} rad/s, for motions of "
                    f"{SHIFT_TIMES_DURATION / shift:.3g} s: give the durations of the contact and "
                    "of the motion in seconds"
                ) from None
        self.solver_name = self._solvers[shift].name
        return self._solvers[shift]


def only_excited(body: Body) -> Body:
    """Return a body of one port without the modes that an impact on it does not excite.

    At most two rigid motions remain. The first is the motion that the port excites. The second
    completes the span of a translation along the direction of travel, with which an eccentric
    impact begins.
    """
    tip, r, still = body.tips[0], body.shape[0], body.omega == 0.0
    on = np.eye(len(r)) if body.coordinates is None else body.coordinates
    moved = excited(body)
    rigid = ways_of(tip, np.where(moved, r, 0.0)[still], body.spanning @ on[:, still])
    elastic = moved & ~still
    coordinates = np.hstack([on[:, still] @ rigid, on[:, elastic]])
    shape = np.concatenate([r[still] @ rigid, r[elastic]])[None]
    shape[0, 1 : rigid.shape[1]] = 0.0
    omega = np.concatenate([np.zeros(rigid.shape[1]), body.omega[elastic]])
    omega2 = omega[rigid.shape[1] :] ** 2
    distinct = np.count_nonzero(np.diff(omega2, prepend=-np.inf) > PRINTED * omega2)
    n = distinct + min(rigid.shape[1], 1) - 1
    return replace(
        body,
        kind="AO" if n or not rigid.shape[1] else "rigid",
        n=n,
        omega=omega,
        shape=shape,
        push=shape,
        inertia=np.ones(len(omega)),
        coordinates=coordinates,
    )


def _of_largest_mass(star: AOModel, n: int) -> AOModel:
    """Return the model of the `n` heaviest oscillators, in their order; others' mass joins m0."""
    by_mass = np.argsort(-star.m, kind="stable")
    order = np.concatenate([np.sort(by_mass[:n]), by_mass[n:]])
    assert star.origin is not None
    return of_body(replace(star, m=star.m[order], k=star.k[order]), star.origin).truncated(n)


def interface(
    tips: ContactPoint | Sequence[ContactPoint],
    n: int,
    *,
    contact_time: float | None = None,
    duration: float = math.inf,
    solver: Solver = "auto",
) -> Body:
    """Return the reduced model of a body with several contact points.

    Its modes are those of the body projected on the rigid motions and on the vectors that impacts
    at the ports excite, port by port in turn: (K + s²M)⁻¹ B, (K + s²M)⁻¹ M (K + s²M)⁻¹ B, …

    Parameters
    ----------
    tips : ContactPoint, or a sequence of them
        Contact points on one body, from `FEModel.contact`.
    n : int
        Number of modes: the body's rigid motions, and at least one more for each port.
    contact_time : float, optional
        Shortest duration of a contact that the modes are fitted to, s; by default the shortest
        estimate of all ports (see `KrylovSpace`).
    duration : float, optional
        Duration for which the body's motion must be accurate, s. By default it is infinite: every
        other vector is static, so that the lowest natural modes are accurate.
        ``duration=contact_time`` fits all vectors to the contact, which spares a factorisation and
        is best if only the force is of interest.
    solver : str or callable, optional
        See `FEModel.inverse`.

    Raises
    ------
    InputError
        If the tips are not on one body, or `n` is out of range.
    SingularError
        If a port moves part of the body as a mechanism.

    Warns
    -----
    AOImpactWarning
        If the ports excite fewer than `n` modes.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> places = [bar.contact(point=(x, 0.005, 0.01)) for x in (0.03, 0.07)]
    >>> model = ao.interface(places, n=8, contact_time=1e-4)
    >>> len(model.tips), model.participation.shape
    (2, (2, 8))
    """
    space = KrylovSpace(tips, contact_time=contact_time, duration=duration, solver=solver)
    body = space.tips[0].body
    least = min(space.rigid_count + len(space.tips), body.n_dofs)
    n = integer("n", n, low=least, high=body.n_dofs)
    model = space.of_all(n).alone
    if model.n < n:
        warn(f"n={n}: the ports excite only {model.n} modes")
    return model


# Products over all dofs avoid BLAS, whose last bits depend on the number of threads, and the
# orthogonal remainder of a static mode may consist of such bits.


def _products(vectors: FloatArray, x: FloatArray) -> FloatArray:
    found: FloatArray = np.einsum("kn,n->k", vectors, x)
    return found


def _combinations(parts: FloatArray, vectors: FloatArray) -> FloatArray:
    found: FloatArray = np.einsum("mk,kn->mn", parts, vectors)
    return found


def _length(x: FloatArray, mx: FloatArray) -> float:
    return math.sqrt(max(0.0, np.einsum("n,n->", x, mx)))
