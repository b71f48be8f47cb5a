"""The band of a reduced model, and the times that it is valid for.

In the band it has the receptance of its body.

At the frequency iω a model leaves the forces r = b - (K + ω²M) X_r unbalanced, and its receptance
bᵀX_r is too small by rᵀ(K + ω²M)⁻¹ r, since r is orthogonal to its shapes (Galerkin). M is positive
semidefinite, so this is at most rᵀK⁻¹ r at every ω. K⁻¹ exists for r even where the body is free:
the model contains its rigid motions. r has about one direction for each force, so the bound takes
a few static solutions. Receptances at iω are those at ω, averaged over frequencies about as far
apart as ω itself.
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

# Error of the receptance at iω up to which a frequency is in the band. A mode that gives a tenth of
# the receptance there is then right to 1 %.
_RIGHT = 1e-3

# Frequencies at which the error is computed, in each decade.
_EACH_DECADE = 16

# Factor by which a contact may be shorter than what was fitted before it is checked: measured on
# twelve impacts with three and eight oscillators, down to there the force is hardly worse.
_SHORTER = 3.0

# Factor between the times at which longer contacts are checked: of three oscillators a contact 1.5
# times as long may have a fifth of the force wrong, where eight know one of three times.
_LONGER = 1.15

# Unbalanced share at which the force of one contact begins to be worse than what a good fit would
# give: on the same impacts it was wrong by .02 to .9 where this was above .01, and hardly worse
# than fitted below .005.
_BALANCED = 5e-3


@dataclass(frozen=True, eq=False)
class Band:
    """The error of a model's receptance over frequency.

    Attributes
    ----------
    omega : ndarray, shape (k,)
        Ascending, rad/s.
    error : ndarray, shape (k,)
        Upper bound of the relative error of the receptance at iω, the largest of all ports.
    """

    omega: FloatArray
    error: FloatArray

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest frequency, Hz, about the one of the least error; 0, 0 if none is."""
        wrong, best = self.error > _RIGHT, int(self.error.argmin())
        if wrong[best]:
            return 0.0, 0.0
        below, above = np.flatnonzero(wrong[:best]), np.flatnonzero(wrong[best:])
        low = self.omega[below[-1] + 1] if len(below) else 0.0
        high = self.omega[best + above[0] - 1] if len(above) else math.inf
        return float(low) / (2.0 * math.pi), float(high) / (2.0 * math.pi)

    def warn_outside(self, omega: FloatArray, *, fitted: bool) -> None:
        """Warn where the model's receptance is asked for at frequencies that it does not know.

        Parameters
        ----------
        omega : ndarray
            rad/s, any shape.
        fitted : bool
            Whether the model was fitted to times.
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
    decades = math.log10(max(fast / slow, 10.0))
    omega = np.geomspace(slow, fast, math.ceil(_EACH_DECADE * decades))
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
    """Return between which durations of a contact the models need no check, s."""
    fitted = [model.contact_time for model in models if model.contact_time is not None]
    return max(fitted, default=0.0) / _SHORTER, min(fitted, default=math.inf)


def is_valid_for(model: BodyModel, lasted: float, port: int = 0, most: float = _BALANCED) -> bool:
    """Return whether a model is accurate enough for forces that act for a time, s.

    It leaves no more than `most` unbalanced at any time from the one fitted to up to this; what was
    found is kept with the model.
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
    """Return what a model leaves unbalanced at i s under a force at a port, relative.

    √(rᵀD⁻¹r / bᵀX) of the residual r = b - (K + s²M) X, D the diagonal of K + s²M.
    """
    point, x = model.tips[port], model.deflection(s, port)
    body = point.body
    K, M, rigid = body.K, body.M, body.rigid_modes
    left = point.b - K @ x - s**2 * (M @ x)
    left -= M @ (rigid @ (rigid.T @ left))
    stiffness = K.diagonal() + s**2 * M.diagonal()
    return math.sqrt(float(left @ (left / stiffness)) / float(point.b @ x))
