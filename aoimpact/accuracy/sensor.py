"""A quantity of interest of one body, and its responses in the runs that are compared."""

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

# Runs that a search goes back to: of one set of models, of three smaller ones, and of those with
# one body's smaller.
_COMPARED = 9


class Sensor(Frozen):
    """A quantity of interest of one body, which its first parameter may leave open.

    Attributes
    ----------
    body : FEModel or None
        None: the only finite-element body; of an impact of two the target.
    named, unit : str
        Of what it measures.
    memory : float
        By how much longer than the impact a record is, s.
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
        """Refuse a body that has no such quantity."""

    def measured(self, body: FEModel) -> Callable[[Response, FloatArray], FloatArray]:
        """Return what gives the quantity of a body from a response and times, s, (times,)."""
        raise NotImplementedError

    def quantity(self, body: FEModel, number: int) -> Quantity:
        """Return the quantity of a body with that number in the plan.

        :meta private:
        """
        measured = cache(lambda: self.measured(body))

        @lru_cache(maxsize=_COMPARED)
        def response(run: Run) -> Response:
            found = response_of(run, number)
            assert found is not None  # a body with a mesh
            return found

        def history(run: Run, times: FloatArray) -> FloatArray:
            if run.plan.bodies[number].wall:  # the body as one that does not deform
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
    """Return the checked body that takes part, by itself or by where it is touched."""
    model = body.body if isinstance(body, ContactPoint) else body
    if model is not None and not isinstance(model, FEModel):
        raise InputTypeError(f"body must be an FEModel or a contact point, got {body!r}")
    return model
