"""The settings of Newmark's rule with Newton-Raphson (section 3.1 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from ..base import InputError, boolean, checked, positive, real


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
        checked(self, beta=positive, gamma=real, rtol=positive, estimate=boolean)
        if self.gamma < 0.5:
            raise InputError(
                f"gamma must be at least 1/2 (below it energy is fed in), got {self.gamma:g}"
            )
        if self.rtol >= 1.0:
            raise InputError(f"rtol must be below 1, got {self.rtol:g}")
