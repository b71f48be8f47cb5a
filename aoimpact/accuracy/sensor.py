"""Base class of sensors: quantities of interest that are measured on one body."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any, ClassVar

import numpy as np

from ..base import FloatArray, Frozen, InputTypeError
from ..contact import ContactPoint
from ..fem import FEModel
from ..fields import Response, response_of
from ..results import Quantity, Run

# Number of runs whose responses are cached while models are chosen: one run with the current
# models, three with smaller models, and one per body with a smaller model of that body.
_COMPARED = 9


class Sensor(Frozen):
    """Base class of quantities of interest that are measured on one body.

    Attributes
    ----------
    body : FEModel or None
        Body that is measured. None means the only finite-element body or, if both bodies of an
        impact are finite-element bodies, the target.
    named, unit : str
        Name and unit of the measured quantity.
    memory : float
        Time by which the record must be longer than the impact, s.
    """

    body: Any
    named: ClassVar[str]
    unit: ClassVar[str]
    memory: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "body", body_of(self.body))
        if self.body is not None:
            self.check(self.body)
        super().__post_init__()

    def check(self, body: FEModel) -> None:
        """Raise InputError if the quantity is not defined for a body."""

    def measured(self, body: FEModel) -> Callable[[Response, FloatArray], FloatArray]:
        """Return a function of a response and times, s, that returns the history, (times,)."""
        raise NotImplementedError

    def quantity(self, body: FEModel, number: int) -> Quantity:
        """Return the `Quantity` that measures a body, whose number in the plan is `number`.

        :meta private:
        """
        measured = cache(lambda: self.measured(body))

        @lru_cache(maxsize=_COMPARED)
        def response(run: Run) -> Response:
            found = response_of(run, number)
            assert found is not None  # the body has a mesh
            return found

        def history(run: Run, times: FloatArray) -> FloatArray:
            if run.plan.bodies[number].wall:  # a model of order 0 does not deform
                return np.full((1, len(times)), np.nan)
            return np.asarray(measured()(response(run), times)).reshape(1, -1)

        return Quantity(
            self.named,
            self.unit,
            history=history,
            each="bodies",
            lasting=True,
            memory=self.memory,
        )


def body_of(body: Any) -> FEModel | None:
    """Return the checked body, given itself or by one of its contact points; None if not given."""
    model = body.body if isinstance(body, ContactPoint) else body
    if model is not None and not isinstance(model, FEModel):
        raise InputTypeError(f"body must be an FEModel or a contact point, got {body!r}")
    return model
