"""The frequency band of a reduced model, and the durations of contact that it is valid for.

In its band a model has the receptance of its body.

At the imaginary frequency iω a model leaves the forces r = b - (K + ω²M) X_r unbalanced, and its
receptance bᵀX_r is too small by rᵀ(K + ω²M)⁻¹ r, since r is orthogonal to the model's shapes
(Galerkin). M is positive semidefinite, so that the error is at most rᵀK⁻¹ r at every ω. K⁻¹ r
exists even for a free body, since the model contains the rigid motions. r has about one direction
for each force, so that the bound takes a few static solutions. The receptance at iω is an average
of the receptance at real frequencies about ω, with a width of the order of ω.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from ..base import FloatArray, warn, with_unit
from ..contact import SHIFT_TIMES_DURATION, highest_shift
from ..fem import near_static
from .recovery import Recovery

if TYPE_CHECKING:
    from .body import Body, BodyModel

# Largest relative error of the receptance at iω within the band. A mode that contributes a tenth of
# the receptance then has an error of at most 1 %.
_RIGHT = 1e-3

# Ratio of fitted to actual duration up to which models are not checked for shorter contacts. In
# twelve impacts with three and eight oscillators the force was then hardly less accurate than with
# models fitted to the actual duration.
_SHORTER = 3.0

# Ratio of successive durations, or frequencies, at which a model is checked. With three
# oscillators a contact 1.5 times as long as fitted may have an error of a fifth of the force, while
# eight oscillators are accurate for three times the duration.
_LONGER = 1.15

# Largest relative unbalanced force (`unbalanced`) at which the force of a contact is as accurate as
# with a model fitted to its duration. In the twelve impacts of _SHORTER the relative error of the
# force was .02 to .9 for unbalanced forces above .01, and for unbalanced forces below .005 hardly
# larger than with a fitted model.
_BALANCED = 5e-3


@dataclass(frozen=True, eq=False)
class Band:
    """The error of a model's receptance over frequency.

    Attributes
    ----------
    omega : ndarray, shape (k,)
        Angular frequencies ω, ascending, rad/s.
    error : ndarray, shape (k,)
        Upper bound of the relative error of the receptance at iω; the largest for all ports.
    """

    omega: FloatArray
    error: FloatArray

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest frequency of the band about the smallest error, Hz; 0, 0 if empty."""
        wrong, best = self.error > _RIGHT, int(self.error.argmin())
        if wrong[best]:
            return 0.0, 0.0
        below, above = np.flatnonzero(wrong[:best]), np.flatnonzero(wrong[best:])
        low = self.omega[below[-1] + 1] if len(below) else 0.0
        high = self.omega[best + above[0] - 1] if len(above) else math.inf
        return float(low) / (2.0 * math.pi), float(high) / (2.0 * math.pi)

    def warn_outside(self, omega: FloatArray, *, fitted: bool) -> None:
        """Warn if frequencies of a receptance are outside the band.

        Parameters
        ----------
        omega : ndarray
            Angular frequencies, rad/s, any shape.
        fitted : bool
            True if the model was fitted to durations.
        """
        asked = np.clip(np.abs(omega).ravel(), self.omega[0], self.omega[-1])
        error = np.interp(np.log(asked), np.log(self.omega), self.error)
        if not (error > _RIGHT).any():
            return
        worst = int(error.argmax())
        low, high = self.limits
        at, time = asked[worst] / (2.0 * math.pi), SHIFT_TIMES_DURATION / asked[worst]
        fit = "duration=math.inf" if at < low else f"contact_time={time:.2g}"
        warn(
            f"receptance: the reduced model is right from {with_unit(low, 'Hz')} to "
            f"{with_unit(high, 'Hz')} and may be off by {min(error[worst], 1.0):.0%} at "
            f"{with_unit(at, 'Hz')}; make it with {f'{fit} or ' if fitted else ''}a larger n"
        )


def band_of(model: Body) -> Band:
    """Return the band of a model of a finite-element body."""
    slow = math.sqrt(near_static(model.body))
    fast = max(map(highest_shift, model.tips))
    count = math.log(max(fast / slow, 10.0)) / math.log(_LONGER)
    omega = np.geomspace(slow, fast, math.ceil(count))
    recovery = Recovery(model, model.loads(), slow)
    shapes, body = recovery.shapes, model.body
    energy = shapes.T @ (body.K @ shapes) + slow**2 * (shapes.T @ (body.M @ shapes))
    own = 0.0 if model.residual is None else model.residual.diagonal()
    error = np.empty(len(omega))
    for i, s2 in enumerate(omega**2):
        motion = (model.push / (model.omega**2 + s2)).T
        left = recovery.amounts(motion, np.eye(model.ports))
        missing = np.einsum("ip,ij,jp->p", left, energy, left)
        error[i] = (missing / (np.einsum("pi,ip->p", model.shape, motion) + own)).max()
    return Band(omega, error)


def fitted_times(models: Sequence[BodyModel]) -> tuple[float, float]:
    """Return the shortest and longest duration of a contact for which models need no check, s."""
    fitted = [model.contact_time for model in models if model.contact_time is not None]
    return max(fitted, default=0.0) / _SHORTER, min(fitted, default=math.inf)


def is_valid_for(model: BodyModel, lasted: float, port: int = 0, most: float = _BALANCED) -> bool:
    """Return whether a model is accurate enough for forces of the duration `lasted`, s.

    This requires a relative unbalanced force of at most `most` for all durations between the fitted
    one and `lasted`. Results are cached in the model.
    """
    fitted = model.contact_time
    if fitted is None or fitted / _SHORTER <= lasted <= fitted or lasted == 0.0:
        return True
    model = cast("Body", model)
    if lasted < fitted:
        return unbalanced(model, SHIFT_TIMES_DURATION / lasted, port) <= most
    wanted = math.ceil(math.log(lasted / fitted) / math.log(_LONGER))
    found: list[float] = model.kept.setdefault(("unbalanced", port), [])
    while len(found) < wanted and max(found, default=0.0) <= most:
        shift = SHIFT_TIMES_DURATION / (fitted * _LONGER ** (len(found) + 1))
        found.append(unbalanced(model, shift, port))
    return max(found[:wanted], default=0.0) <= most


def unbalanced(model: Body, s: float, port: int = 0) -> float:
    """Return the force that a model leaves unbalanced, relative to the force at a port.

    At the frequency i s, rad/s, the ratio is √(rᵀD⁻¹r / bᵀX) with the model's response X, the
    residual r = b - (K + s²M) X, and the diagonal D of K + s²M.
    """
    point, x = model.tips[port], model.deflection(s, port)
    body = point.body
    K, M, rigid = body.K, body.M, body.rigid_modes
    left = point.b - K @ x - s**2 * (M @ x)
    left -= M @ (rigid @ (rigid.T @ left))
    stiffness = K.diagonal() + s**2 * M.diagonal()
    return math.sqrt(float(left @ (left / stiffness)) / float(point.b @ x))
