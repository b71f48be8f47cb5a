"""The settings of both methods of time integration, and constants that they share.

Constants were measured on random impacts and scenes with a known solution; tests repeat some of the
measurements on fewer cases. Tolerances are divided in two other places: accuracy/choice.py divides
the tolerance of a quantity of interest between models and time integration, csrc/adaptive the
tolerance of a run between the errors of a step (see the table in csrc/README.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from ..base import boolean, checked, positive, within

# Smallest tolerance, in view of the digits of double precision.
TIGHTEST = 1e-13

# Share below which a quantity does not count beside the largest. Errors of the peak or impulse of a
# contact or touch are relative to at least this share of the largest peak or impulse: rounding
# errors decide whether bodies moving side by side graze each other. The core has the same rule
# (step.h).
LESSER = 0.01

# Relative tolerance, in the limit of small steps, of the stretches of the springs that represent
# friction (docs/theory/contact.md): error of a stretch divided by the largest stretch. It needs
# some 700 springs, or 1150 in a ball that has rolled for 1800 periods of its tangential vibration;
# the core has room for 2048. The relative error of an impact's friction is 0.01 to 0.14 times this
# tolerance for motion along one line, and up to 0.7 times for a slide that changes its direction.
# It is also the smallest error of friction, relative to its bound μ F, that the adaptive method
# reports: the core computes the stretches to 4e-6 if the direction of friction changes. In 40
# impacts on four bodies, velocities of runs with tolerances of 1e-6 and 1e-8 differ by at most 3e-7
# of the speed, and by 7e-6 for a ball that slips from the touch on.
DRAWN = 1e-5


@dataclass(frozen=True, kw_only=True)
class Adaptive:
    """Adaptive time integration to a tolerance.

    Parameters
    ----------
    rtol : float, optional
        Relative tolerance of peak force, contact times and impulse, and of velocities relative to
        the largest initial one; from 1e-13 up to, not including, 1.

    Raises
    ------
    InputError
        If `rtol` is out of range.

    Notes
    -----
    Peak force and impulse are those of each contact over the record; their errors are relative to
    at least a hundredth of the largest contact's. Errors of the start and end of a contact are
    relative to its end. Velocities are those of centres of mass after contacts; their errors are
    relative to the largest initial velocity, or to a larger velocity that gravity and loads cause.
    Errors of bodies at rest are relative to a thousandth of the velocity that the impulse of their
    contacts would give them. A velocity or displacement at a given time of a long record suffers
    from the error of the contact times as well: for a ball that bounces under gravity g, by g rtol
    t.

    Scenes of several contacts are run to 0.3 of `rtol`, since bodies that meet at a small part of
    their speeds multiply errors. From the second contact of two bodies on, errors grow with each
    contact. Such a scene is run again with a smaller tolerance, in most cases once, until two runs
    agree to `rtol`; the last run is the result. If rounding errors or chaotic motion prevent
    agreement, a warning is given, and `error.time` estimates the error; 1.0 means that no digit is
    reliable.

    With friction, the state of an elastic contact follows the motion within each step. Velocities
    and spins have the error `rtol`, but at least 1e-5, which `error.time` includes. Momentum is
    conserved to rounding errors, energy to `rtol`. Friction with damped laws, or with massless
    contact points, is refused.

    Touches that together have less than a hundredth of the impulse of a contact's largest one do
    not count. If a wave reaches bodies at rest side by side, their contact has no definite start;
    the start is then the time at which the contact force exceeds rounding errors.

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
        checked(self, rtol=partial(within, low=TIGHTEST, high=1.0, below=True))


@dataclass(frozen=True, kw_only=True)
class Newmark:
    """Newmark β-γ time integration with a fixed step.

    Parameters
    ----------
    dt : float, optional
        Largest time step, s. The step taken is the largest one not above `dt` that divides the
        duration of the record. By default the step is halved until the estimated error is below
        `rtol`.
    beta, gamma : float, optional
        Parameters of the rule, β > 0 and γ ≥ 1/2. The default, β = 1/4 and γ = 1/2 (average
        acceleration), is of second order, conserves the energy of a linear system and is stable for
        any step, as is every rule with 2β ≥ γ.
    rtol : float, optional
        Relative tolerance of peak force and impulse of each contact if `dt` is not given. Errors
        are relative to at least a hundredth of the largest contact's values.
    estimate : bool, optional
        True to estimate the error from two more runs, with twice and four times the step, which
        take three quarters of the run's time. The estimate is some three times the error of smooth
        forces, and at least as large as the error if touches, jumps or massless contact points
        reduce the order. The estimate does not include the errors of times of touch and release,
        which are interpolated within a step.

    Raises
    ------
    InputError
        If `dt` ≤ 0, `beta` ≤ 0, `gamma` < 1/2 or `rtol` is not in (0, 1).

    Examples
    --------
    >>> ball = ao.rigid(mass=0.1)
    >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0,
    ...                duration=1e-3, solver=ao.Newmark(dt=1e-6))
    >>> len(hit.t), hit.error.time < 1e-3
    (1001, True)
    """

    dt: float | None = None
    beta: float = 0.25
    gamma: float = 0.5
    rtol: float = 1e-3
    estimate: bool = True

    def __post_init__(self) -> None:
        if self.dt is not None:
            checked(self, dt=partial(positive, unit="s"))
        checked(self, beta=positive, gamma=partial(within, low=0.5))  # lower values add energy
        checked(self, rtol=partial(within, low=TIGHTEST, high=1.0, below=True), estimate=boolean)
