"""Static mode of a body at its contact, and shifts s of K + s²M for a contact time.

The static mode follows eqs. (1)-(3) and (11) of the paper.
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

# Largest rᵀb/|r||b| of a rigid motion r that counts as 0, and largest error of entries of r that
# should be 0 or 1. With the weakest springs to the ground that are detected (1e-9 of the diagonal
# of K), r is accurate to about 1e-16/1e-9.
_MOVED, _AS_ONE = 1e-7, 1e-6


@dataclass(frozen=True, eq=False)
class StaticMode:
    """The static mode of a body at a contact functional, eqs. (1)-(3), (11).

    Attributes
    ----------
    phi : ndarray, shape (n_dofs,)
        Static mode φ_st, with bᵀφ_st = 1.
    k0 : float
        Static stiffness φ_stᵀ K φ_st, N/m; exactly 0 if b excites rigid motion.
    m_phi : ndarray, shape (n_dofs,)
        Product M φ_st.
    mass : float
        Static mass m_st = φ_stᵀ M φ_st, kg.
    unobservable : ndarray, shape (n_dofs, r)
        M-orthonormal rigid motions that do not displace the contact point.
    """

    phi: FloatArray
    k0: float
    m_phi: FloatArray
    mass: float
    unobservable: FloatArray


def static_mode(
    tip: ContactPoint, *, invert: Callable[[float], LinearSolver] | None = None
) -> StaticMode:
    """Return the static mode or, if b excites a rigid motion, that rigid motion.

    Parameters
    ----------
    tip : ContactPoint
    invert : callable, optional
        Function s² ↦ solver of K + s²M of the body; by default `FEModel.inverse`.

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
    """Return whether a force at the contact excites rigid motion of the body."""
    rigid = tip.body.rigid_modes
    reach = float(np.linalg.norm(rigid.T @ tip.b))
    return reach > _MOVED * float(np.linalg.norm(tip.b) * np.linalg.norm(rigid))


def centre_of(tip: ContactPoint, phi: Callable[[], FloatArray]) -> tuple[FloatArray, float, bool]:
    """Return the functional of the centre of mass, the body's mass, kg, and whether both are exact.

    Without nodes, the mean displacement weighted with the static mode, and the mode's mass, are
    returned instead. The two replacements are exact if the mode is a translation, with all entries
    0 or 1.

    Parameters
    ----------
    tip : ContactPoint
    phi : callable
        Function that returns φ_st, shape (n_dofs,).
    """
    if tip.direction is not None and tip.body.mass is not None:
        return tip.body.com_functional(tip.direction), tip.body.mass, True
    static = phi()
    momentum = tip.body.M @ static
    mass = float(static @ momentum)
    as_one = bool((np.abs(static * (1.0 - static)) <= _AS_ONE).all())
    return momentum / mass, mass, as_one


def refuse_mechanism(tips: Sequence[ContactPoint]) -> None:
    """Refuse contact points whose force excites a mechanism of the body.

    Mechanisms that none of the forces excites are accepted, as they do not contribute.

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
    """Return the shifts s of K + s²M, rad/s, for the contact time and for a longer duration.

    Without a contact time, the shortest of the contact points' estimates (`own_contact_time`) is
    taken.
    """
    if contact_time is None:
        contact_time = min(own_contact_time(tip) for tip in tips)
        if math.isinf(contact_time):
            raise InputError(
                "contact_time cannot be estimated, as K gives b no stiffness; give contact_time"
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
    """Return the shift, rad/s, for motion over `duration`, s; nearly 0 if that is infinite."""
    wanted = SHIFT_TIMES_DURATION / positive("duration", duration, unit="s", infinite=True)
    return max(wanted, math.sqrt(near_static(tip.body)))


def shortest_contact_time(tip: ContactPoint) -> float:
    """Return the shortest contact time that the mesh resolves, s.

    Waves whose period is this time are about as long as an element. The time is 0 if bᵀKb = 0.
    """
    highest = highest_shift(tip)
    return SHIFT_TIMES_DURATION / highest if highest > 0.0 else 0.0


def highest_shift(tip: ContactPoint) -> float:
    """Return √(bᵀKb/bᵀMb), rad/s: a lower bound of the body's highest frequency."""
    refuse_massless([tip])
    body, b = tip.body, tip.b
    return math.sqrt(max(0.0, quadratic(body.K, b) / quadratic(body.M, b)))


def refuse_massless(tips: Sequence[ContactPoint]) -> None:
    """Refuse contact on massless dofs, whose compliance the modes of a truncated model lack.

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
