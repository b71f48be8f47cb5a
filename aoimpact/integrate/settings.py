"""The settings of both methods of time integration, and shares of a tolerance.

The measurements are over random impacts and scenes with a known answer; the tests repeat some of
them on fewer. Two more tolerances are shared out elsewhere: that of a quantity of interest among
models, time and mesh, by accuracy/choice.py; that of a run among what a step does wrong, in the
core, by csrc/adaptive (the table in csrc/README.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from ..base import boolean, checked, positive, within

# The smallest tolerance that may be given: double precision has no more digits.
TIGHTEST = 1e-13

# A contact, or a touch, with less than this share of the largest one's peak or impulse is measured
# by that share: whether bodies that move on side by side graze each other is rounding. The core
# has the same rule (step.h).
LESSER = 0.01

# The finest precision to which a contact with friction draws its stretches, as a share of the
# largest: some 700 springs, 1150 of a ball that has rolled for 1800 periods of its tangential
# vibration, each of which leaves two, and the core has room for 2048. An impact's friction errs by
# 0.01 to 0.14 of the precision along one line, and by up to 0.7 of it where the slide turns.
DRAWN = 1e-5


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
        checked(self, rtol=partial(within, low=TIGHTEST, high=1.0, below=True))  # double precision


@dataclass(frozen=True, kw_only=True)
class Newmark:
    """Newmark β-γ time integration with a fixed step.

    Parameters
    ----------
    dt : float, optional
        Largest time step, s. The step taken is the largest that makes a whole number of steps of
        the record: `dt` itself where it does. If not given, the step is halved until the estimated
        error is below `rtol`.
    beta, gamma : float, optional
        β > 0 and γ ≥ 1/2. The default, β = 1/4 and γ = 1/2 (average acceleration), is of second
        order, keeps the energy of a linear system and is stable for any step, as is every rule
        with 2β ≥ γ.
    rtol : float, optional
        Relative error of peak force and impulse of each contact to aim at when `dt` is not given;
        of a contact with less than a hundredth of the largest, relative to that hundredth.
    estimate : bool, optional
        Whether to run again with twice and four times the step, at three quarters of the cost, to
        estimate that error. The estimate is some three times the error where forces are smooth,
        and no less where touches, jumps and contact points without mass lower the order. Times of
        touch and release are known to within a step's interpolation and are not part of it.

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
        checked(self, beta=positive, gamma=partial(within, low=0.5))  # below, energy is fed in
        checked(self, rtol=partial(within, low=TIGHTEST, high=1.0, below=True), estimate=boolean)
