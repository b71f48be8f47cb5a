"""The static mode of a body at its contact, and the shifts s of K + s²M that fit its contact time.

The mode is that of eqs. (1)-(3) and (11) of the paper.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ..base import ROUNDING, FloatArray, InputError, SingularError, positive
from ..fem import displacement, near_static
from ..linalg import LinearSolver
from .point import SHIFT_TIMES_DURATION, ContactPoint, own_contact_time, quadratic

# rᵀb/|r||b| of a motion r that b moves. Less is rounding: beside springs to the ground that are
# just distinguished from none (1e-9 of the diagonal of K) motions are known to some 1e-16/1e-9.
_MOVED = 1e-7

# Rounding of a null space: deviation of a motion that is 0 or 1 everywhere.
_AS_ONE = 1e-6


@dataclass(frozen=True, eq=False)
class StaticMode:
    """The static mode of a body at a contact functional, eqs. (1)-(3), (11).

    Attributes
    ----------
    phi : ndarray, shape (n_dofs,)
        φ_st with bᵀφ_st = 1.
    k0 : float
        φ_stᵀ K φ_st, N/m; exactly 0 where b moves the body rigidly.
    m_phi : ndarray, shape (n_dofs,)
        M φ_st.
    mass : float
        m_st = φ_stᵀ M φ_st, kg.
    unobservable : ndarray, shape (n_dofs, r)
        The M-orthonormal rigid motions that do not move the contact point.
    """

    phi: FloatArray
    k0: float
    m_phi: FloatArray
    mass: float
    unobservable: FloatArray


def static_mode(
    tip: ContactPoint, *, invert: Callable[[float], LinearSolver] | None = None
) -> StaticMode:
    """Return the static mode; for a body that b can move rigidly, that rigid motion.

    Parameters
    ----------
    tip : ContactPoint
    invert : callable, optional
        s² ↦ the solver of K + s²M of its body; `FEModel.inverse` if left out.

    Raises
    ------
    SingularError
        If K is singular though the body has no rigid motion: a mechanism.
    """
    rigid, b = tip.body.rigid_modes, tip.b
    reach = rigid.T @ b
    if moves_rigidly(tip):
        phi, k0 = rigid @ reach / (reach @ reach), 0.0
        rigid = rigid @ scipy.linalg.qr(reach[:, None])[0][:, 1:]
    else:
        phi = displacement(tip.body, b, invert or tip.body.inverse)
        k0 = 1.0 / float(b @ phi)
        phi = k0 * phi
    m_phi = tip.body.M @ phi
    return StaticMode(phi, k0, m_phi, float(phi @ m_phi), rigid)


def moves_rigidly(tip: ContactPoint) -> bool:
    """True if a force at the contact moves the body as a whole: for that force it is free."""
    rigid = tip.body.rigid_modes
    reach = float(np.linalg.norm(rigid.T @ tip.b))
    return reach > _MOVED * float(np.linalg.norm(tip.b) * np.linalg.norm(rigid))


def centre_of(tip: ContactPoint, phi: Callable[[], FloatArray]) -> tuple[FloatArray, float, bool]:
    """Return the centre of mass's functional, the body's mass, kg, and whether these are right.

    Without nodes, the mean over the static mode stands for the centre, and its mass for
    the body's. That is right if the mode is a translation: all that moves moves as the contact.

    Parameters
    ----------
    tip : ContactPoint
    phi : callable
        Returns φ_st, shape (n_dofs,).
    """
    if tip.direction is not None and tip.body.mass is not None:
        return tip.body.com_functional(tip.direction), tip.body.mass, True
    static = phi()
    momentum = tip.body.M @ static
    mass = float(static @ momentum)
    as_one = bool((np.abs(static * (1.0 - static)) <= _AS_ONE).all())
    return momentum / mass, mass, as_one


def refuse_mechanism(tips: Sequence[ContactPoint]) -> None:
    """Refuse contact points from which part of their body is a mechanism.

    A mechanism that no force there moves is accepted: its motion takes no part in the response.

    Raises
    ------
    SingularError
    """
    mechanism = tips[0].body.mechanism
    if mechanism is None:
        return
    for tip in tips:
        if mechanism.moved_by(tip.b):
            raise SingularError(
                "part of the body is a mechanism that the contact moves without any elastic force: "
                f"{mechanism.where(tip.b)}; join the parts by whole sides of elements (merge the "
                "nodes of both), or hold them by supports"
            )


def fitted_shifts(
    tips: Sequence[ContactPoint], contact_time: float | None, duration: float | None
) -> list[float]:
    """Return the shifts s, rad/s, for that contact time at any of the places, and duration."""
    if contact_time is None:
        contact_time = min(own_contact_time(tip) for tip in tips)
        if math.isinf(contact_time):
            raise InputError(
                "no contact_time can be estimated where K gives b no stiffness; give it"
            )
    else:
        positive("contact_time", contact_time, unit="s")
        shortest = max(shortest_contact_time(tip) for tip in tips)
        if contact_time < shortest:
            raise InputError(
                f"contact_time={contact_time:g} s is shorter than what the mesh resolves at the "
                f"contact, {shortest:.2g} s: give the duration of the contact in seconds, or "
                "refine the mesh"
            )
    shifts = [SHIFT_TIMES_DURATION / contact_time]
    if duration is not None and (slow := slow_shift(tips[0], duration)) < shifts[0]:
        shifts.append(slow)
    return shifts


def slow_shift(tip: ContactPoint, duration: float) -> float:
    """Return the shift for motion of that duration, rad/s; of an infinite one a static shift."""
    wanted = SHIFT_TIMES_DURATION / positive("duration", duration, unit="s", infinite=True)
    return max(wanted, math.sqrt(near_static(tip.body)))


def shortest_contact_time(tip: ContactPoint) -> float:
    """The shortest contact that the mesh resolves, s: a shorter wave is shorter than an element.

    0 where K gives b no stiffness, and so no waves.
    """
    highest = highest_shift(tip)
    return SHIFT_TIMES_DURATION / highest if highest > 0.0 else 0.0


def highest_shift(tip: ContactPoint) -> float:
    """The frequency of the elements at the contact, rad/s: it bounds from below the highest."""
    refuse_massless([tip])
    body, b = tip.body, tip.b
    return math.sqrt(max(0.0, quadratic(body.K, b) / quadratic(body.M, b)))


def refuse_massless(tips: Sequence[ContactPoint]) -> None:
    """Refuse contact on dofs without mass: no mode of a truncated model has their compliance.

    Raises
    ------
    InputError
    """
    for tip in tips:
        loaded = np.abs(tip.b) > ROUNDING * np.abs(tip.b).max(initial=0.0)
        touched = np.flatnonzero(loaded & (tip.body.M.diagonal() == 0.0))
        if len(touched):
            raise InputError(
                f"the contact acts on {len(touched)} dofs without mass, the first is {touched[0]}, "
                "and modes leave their compliance out; take antioscillators(tip, "
                "method='eigen') or full(tip), or give the dofs mass"
            )
