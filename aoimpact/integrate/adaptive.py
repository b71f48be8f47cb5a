"""The settings of the adaptive method: a tolerance instead of a step."""

from __future__ import annotations

from dataclasses import dataclass

from ..base import InputError, positive
from .tolerances import TIGHTEST


@dataclass(frozen=True, kw_only=True)
class Adaptive:
    """Integrate to a tolerance.

    Parameters
    ----------
    rtol : float, optional
        Relative error of peak force, contact times and impulse, and of velocities relative to the
        largest initial one; from 1e-13 up to, not including, 1.

    Raises
    ------
    InputError
        If `rtol` is out of range.

    Notes
    -----
    The peak force and the impulse are those of each contact over the record; of one that has less
    than a hundredth of the largest contact's, the error is relative to that hundredth. Contact
    times, start and end, have the relative error `rtol` of the end; velocities are those of
    the centres of mass after contacts, relative to the largest initial one or, where gravity and
    loads make greater ones, to those; of bodies at rest, to a thousandth of what the impulse of
    their contacts would give them. A velocity or displacement at a given time of a long record
    suffers from the error of that time as well: g rtol t for a ball that bounces under gravity g.

    Scenes of several contacts are run to 0.3 of `rtol`, since bodies that meet at a small part of
    their speeds multiply errors. From the second contact of two bodies on, errors grow with each.
    Then the scene is run again with a smaller tolerance, in most cases once, until two runs agree
    to `rtol`; the last of them is the result. Where rounding or chaotic motion leaves no tolerance
    small enough, a warning is given, and `error.time` is how far the result may be off; 1.0 means
    that no digit is reliable.

    With friction an elastic contact's memory follows the motion within each step. Velocities and
    spins have the error `rtol`, or 1e-5 where that is less: `error.time` says so. Momentum is kept
    to rounding and energy to `rtol`. Friction of damped laws is refused, and of bodies whose
    contact points have no mass.

    Touches that have together less than a hundredth of the impulse of a contact's largest one do
    not count. Bodies at rest side by side begin to press each other at no certain time when a wave
    reaches them: the start of such a touch is when its force is no longer rounding.

    Examples
    --------
    >>> ball = ao.rigid(mass=0.1)
    >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0,
    ...                duration=1e-3, solver=ao.Adaptive(rtol=1e-10))
    >>> abs(hit.restitution - 1.0) < 1e-10
    True
    """

    rtol: float = 1e-8

    def __post_init__(self) -> None:
        object.__setattr__(self, "rtol", positive("rtol", self.rtol))
        if not TIGHTEST <= self.rtol < 1.0:
            raise InputError(
                f"rtol must be from {TIGHTEST:g} to below 1, got {self.rtol:g}: double precision "
                "carries no more digits"
            )
