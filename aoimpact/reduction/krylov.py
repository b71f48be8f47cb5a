"""Models fitted to the contact time: a body projected on what impacts at its ports excite.

The paper takes the constraint modes of the whole body. A short contact does not excite most of
them. Here the body is first projected on the vectors that a contact of duration T excites,
(K + s²M)⁻¹ b, (K + s²M)⁻¹ M (K + s²M)⁻¹ b, … with s ~ 1/T, each of which costs one solve; and, if
it is constrained, on its static modes, without which the model of few vectors is far too stiff.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..base import InputError, bar, boolean, instance, integer, warn
from ..contact import (
    SHIFT_TIMES_DURATION,
    ContactPoint,
    fitted_shifts,
    highest_shift,
    moves_rigidly,
    slow_shift,
)
from ..linalg import EQUAL, LinearSolver, Solver
from .body import Body, checked_ports, of_modes, ways_of
from .star import AOModel, excited, of_body
from .subspace import Subspace

# A shift is as good as the best within this factor: on the paper's beam 8 to 14 over the contact
# time are alike.
_AS_GOOD = 1.3

# Vectors, as a multiple of the oscillators wanted, after which no more are tried for those missing.
_MOST_IDLE = 2


class KrylovSpace:
    """The space from which models of a body that are fitted to a scene are made; it grows.

    `antioscillators(tip, n, method="krylov")` and `interface` make one and use it once. Kept, it
    gives models of any order, the next one for a single solve more; up to three on symmetric bodies
    once the model is right to rounding, which then adds motions that no port excites. The static
    mode of a constrained body is, in compact bodies, a combination of some six to ten vectors that
    larger models take anyway. In slender and thin ones it takes another factorisation, of K.

    Parameters
    ----------
    tips : ContactPoint, or a sequence of them
        Places on one and the same body, from `FEModel.contact`.
    contact_time : float, optional
        How long the contact lasts, s; a factor of two or three does not matter. By default half a
        period of the body's mass on the stiffness of its contact coordinate, which is far too short
        for matrices without a mesh of nearly incompressible material.
    duration : float, optional
        How long the body's motion is to be right, s, if that is much longer than the contact:
        ``math.inf`` for the lowest natural modes. Every other vector is then fitted to it, which
        takes a second factorisation. Without it the motion is right for some contact times. Always
        right are the motion of a free body as a whole and that of a constrained one under forces
        that change slowly.
    sharpened : bool, optional
        Whether vectors beyond the 48th and the 192nd are fitted to models that large, which takes
        another factorisation for each.
    solver : str or callable, optional
        See `FEModel.inverse`.
    known : LinearSolver, optional
        One of this body that has been set up for something else; it serves, and its shift is
        taken, if that is about the one for the contact time.

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
        known: LinearSolver | None = None,
    ) -> None:
        self.tips = checked_ports("tips", tips)
        body = self.tips[0].body
        self.shift = fitted_shifts(self.tips, contact_time, None)[0]
        highest = min(map(highest_shift, self.tips))
        if known is not None and instance("known", known, LinearSolver).pencil.K is not body.K:
            raise InputError("known: it solves for another body; take tip.body.inverse(s2)")
        shift = math.sqrt(known.s2) if known else self.tips[0].shift or self.shift
        near = abs(math.log(shift / self.shift)) <= math.log(_AS_GOOD)
        if near and shift <= highest and len(self.tips) == 1:
            self.shift = shift
        else:
            known = None
        self.contact_time = SHIFT_TIMES_DURATION / self.shift
        limit = highest if boolean("sharpened", sharpened) else 0.0
        self._space = Subspace(self.tips, [self.shift], highest=limit, solver=solver, known=known)
        self.rigid_count = self._space.rigid_count
        if duration is not None:
            self.include(duration)
        # A constrained body's static mode is one more vector; a free one's is a rigid motion.
        self._first = self.rigid_count + (0 if moves_rigidly(self.tips[0]) else 1)

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
            # Where b excites only some modes, rounding adds vectors of the others.
            vectors += wanted - star.n
            star = self.of_vectors(vectors).alone.star
        if star.n < wanted:
            warn(f"n={n}: only {star.n} anti-oscillators carry mass at this contact")
        return star if star.n <= wanted else _of_largest_mass(star, wanted)

    def of_vectors(self, n: int) -> Body:
        """Return the model of `n` vectors beside the static one: of `n` oscillators, or fewer.

        Its modes are multiplied out when they are needed. It is made for much less than one whose
        are, and holds the whole space as long as it lives.

        :meta private:
        """
        return only_excited(self.of_all(self._first + integer("n", n, low=0), "AO"))

    def of_all(self, n: int, kind: str = "interface") -> Body:
        """Return the model of `n` vectors, rigid motions included, or of as many as there are.

        :meta private:
        """
        with bar(f"model of {self.tips[0].body.n_dofs} dofs", unit="solution"):
            omega2, coordinates = self._space.ritz_on_basis(n)
        return of_modes(
            self.tips,
            omega2,
            partial(self._space.first_vectors, len(coordinates)),
            coordinates,
            kind=kind,
            linear_solver=self._space.solver_name,
            contact_time=self.contact_time,
        )

    def release(self) -> None:
        """Give back the memory of the factors.

        :meta private:
        """
        self._space.release()

    @property
    def exhausted(self) -> bool:
        """True if all that the ports excite is in the space."""
        return self._space.exhausted

    def include(self, duration: float) -> None:
        """Fit every other vector from here on to motion of that duration, s, as well.

        :meta private:
        """
        slow = slow_shift(self.tips[0], duration)
        if slow < self.shift:
            self._space.shifts = (self.shift, slow)


def only_excited(body: Body) -> Body:
    """Return a body of one port without the modes that an impact on it does not excite.

    Two rigid motions are left at most: that which the port excites, and the rest of a translation
    along the direction of travel, with which an impact off the centre begins.
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
    distinct = np.count_nonzero(np.diff(omega2, prepend=-np.inf) > EQUAL * omega2)
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
    """The `n` oscillators of the largest mass, in the star's order; the others' joins m0."""
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
    """Return the model of a body touched in several places.

    Its modes are those of the body projected on the rigid motions and on what impacts at the ports
    excite, port by port in turn: (K + s²M)⁻¹ B, (K + s²M)⁻¹ M (K + s²M)⁻¹ B, …

    Parameters
    ----------
    tips : ContactPoint, or a sequence of them
        Places on one and the same body, from `FEModel.contact`.
    n : int
        Number of modes, the body's rigid motions included and at least one more for each port.
    contact_time : float, optional
        The shortest contact that the modes are fitted to, s; by default the shortest of those that
        the ports have by themselves.
    duration : float, optional
        How long the body's motion is to be right, s. By default for ever: every other vector is
        static, so that the lowest natural modes are right. ``duration=contact_time`` fits all
        vectors to the contact, which spares a factorisation and is best for its force alone.
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
