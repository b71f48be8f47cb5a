"""Anti-oscillators fitted to the contact time: the paper's, on a rational Krylov subspace.

The paper takes the constraint modes of the whole body. A short contact does not excite most of
them. Here the body is first projected on the vectors that a contact of duration T excites,
(K + s²M)⁻¹ b, (K + s²M)⁻¹ M (K + s²M)⁻¹ b, … with s ~ 1/T, each of which costs one solve; and, if
it is constrained, on its static mode, without which the model of few vectors is far too stiff.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from ..base import (
    InputError,
    InputTypeError,
    bar,
    boolean,
    instance,
    integer,
    warn,
)
from ..fem import (
    SHIFT_TIMES_DURATION,
    ContactPoint,
    fitted_shifts,
    highest_shift,
    moves_rigidly,
    slow_shift,
)
from ..linalg import LinearSolver, Solver
from .modes import star_of_modes
from .star import AOModel
from .subspace import Subspace

# A shift is as good as the best within this factor: on the paper's beam 8 to 14 over the contact
# time are alike.
_AS_GOOD = 1.3

# Vectors, as a multiple of the oscillators wanted, after which no more are tried for those missing.
_MOST_IDLE = 2


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
        If `contact_time` is shorter than what the mesh resolves.
    SingularError
        If the contact moves part of the body as a mechanism.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> space = ao.KrylovSpace(bar.contact(point=(0.1, 0.005, 0.005)), contact_time=1e-4)
    >>> [space.antioscillators(n).n for n in (2, 3)]  # the second costs one more solution
    [2, 3]
    """

    def __init__(
        self,
        tip: ContactPoint,
        *,
        contact_time: float | None = None,
        duration: float | None = None,
        sharpened: bool = False,
        solver: Solver = "auto",
        known: LinearSolver | None = None,
    ) -> None:
        if not isinstance(tip, ContactPoint):
            raise InputTypeError(f"tip must come from FEModel.contact(...), got {tip!r}")
        self.tip = tip
        self.shift = fitted_shifts([tip], contact_time, None)[0]
        highest = highest_shift(tip)
        if known is not None and instance("known", known, LinearSolver).pencil.K is not tip.body.K:
            raise InputError("known: it solves for another body; take tip.body.inverse(s2)")
        shift = math.sqrt(known.s2) if known else tip.shift or self.shift
        if abs(math.log(shift / self.shift)) > math.log(_AS_GOOD) or shift > highest:
            known = None
        else:
            self.shift = shift
        self.contact_time = SHIFT_TIMES_DURATION / self.shift
        limit = highest if boolean("sharpened", sharpened) else 0.0
        self._space = Subspace([tip], [self.shift], highest=limit, solver=solver, known=known)
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

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> space = ao.KrylovSpace(bar.contact(point=(0.09, 0.005, 0.01)), contact_time=1e-4)
        >>> [space.antioscillators(n).n for n in (2, 3)]
        [2, 3]
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
        """Return the model of `n` vectors beside the static one: of `n` oscillators, or fewer.

        :meta private:
        """
        return self.factored(n).multiplied_out

    def factored(self, n: int) -> AOModel:
        """Return the model of `of_vectors` with shapes that are multiplied out when needed.

        It is made for much less, and holds the whole space as long as it lives.

        :meta private:
        """
        vectors = integer("n", n, low=0)
        with bar(f"model of {self.tip.body.n_dofs} dofs", unit="solution"):
            omega2, coordinates = self._space.ritz_on_basis(self._first + vectors)
        return star_of_modes(
            self.tip,
            omega2,
            self._space.first_vectors(len(coordinates)),
            "AO",
            coordinates=coordinates,
            vectors=partial(self._space.first_vectors, len(coordinates)),
            solver=self._space.solver_name,
            contact_time=self.contact_time,
        )

    def release(self) -> None:
        """Give back the memory of the factors.

        :meta private:
        """
        self._space.release()

    @property
    def exhausted(self) -> bool:
        """True if all that b excites is in the space."""
        return self._space.exhausted

    def include(self, duration: float) -> None:
        """Fit every other vector from here on to motion of that duration, s, as well.

        :meta private:
        """
        slow = slow_shift(self.tip, duration)
        if slow < self.shift:
            self._space.shifts = (self.shift, slow)


def _of_largest_mass(star: AOModel, n: int) -> AOModel:
    """The `n` oscillators of the largest mass, in the star's order; the others' joins m0."""
    by_mass = np.argsort(-star.m, kind="stable")
    order = np.concatenate([np.sort(by_mass[:n]), by_mass[n:]])
    assert star.origin is not None  # it was made from modes
    origin = replace(star.origin, oscillators=star.origin.oscillators[:, order])
    return replace(star, m=star.m[order], k=star.k[order], origin=origin).truncated(n)
