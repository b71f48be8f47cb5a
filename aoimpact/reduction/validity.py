"""Durations for which forces may act on a model that was fitted to a contact time."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..contact import SHIFT_TIMES_DURATION
from .body import Body, BodyModel

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
    assert isinstance(model, Body)
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
