"""A quantity of interest of one body, and its responses in the runs that are compared."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from ..base import FloatArray, Frozen, InputTypeError
from ..fem import Body, ContactPoint, FEModel
from ..fields import Response, response_of
from ..linalg import SolverBook
from ..reduction import SOLVED
from ..results import Quantity, Run

# Runs that a search goes back to: of one order, and of those up to eight larger.
_COMPARED = 9


class Responses:
    """The responses of a body in the runs that are compared, and what all of them share."""

    def __init__(self, body: Body, number: int) -> None:
        self.number, factors = number, SolverBook(body.inverse)
        self._factors = factors

        @lru_cache(maxsize=_COMPARED)
        def response(run: Run) -> Response:
            found = response_of(run.plan, run.recorder, run.events, number, factors)
            assert found is not None  # a body with a mesh
            return found

        self.of = response

    def dual(self, rows: Callable[[], Any]) -> Callable[[float], FloatArray]:
        """Return s ↦ rows (K + s²M)⁻¹, the same for all models of a body."""

        @lru_cache(maxsize=_COMPARED)
        def dual(s: float) -> FloatArray:
            solver = self._factors(s**2)
            return np.stack([solver.solve_roughly(row, SOLVED)[0] for row in rows().toarray()])

        return dual


class Sensor(Frozen):
    """A quantity of interest of one body, which its first parameter may leave open.

    Attributes
    ----------
    body : FEModel or None
        None: the only finite-element body; of an impact of two the target.
    memory : float
        By how much longer than the impact a record is, s.
    """

    body: Any
    memory: float = 0.0

    def quantity(self, body: Body, number: int) -> Quantity:
        """Return the quantity of a body with that number in the plan."""
        raise NotImplementedError

    def check(self, body: Body) -> None:
        """Refuse a body that has no such quantity."""


def body_of(body: Any) -> FEModel | None:
    """Return the checked body that takes part, by itself or by where it is touched."""
    model = body.body if isinstance(body, ContactPoint) else body
    if model is not None and not isinstance(model, FEModel):
        raise InputTypeError(f"body must be an FEModel or a contact point, got {body!r}")
    return model
