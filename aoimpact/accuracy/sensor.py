"""A quantity of interest of one body, and its responses in the runs that are compared."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any, ClassVar

import numpy as np

from ..base import FloatArray, Frozen, InputTypeError, held_warnings
from ..contact import ContactPoint, to_nodes
from ..fem import FEModel, Stress, corner_stress
from ..fields import Field, Response, response_of
from ..mesh import weights_at
from ..reduction import SharedSolutions
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

    def of_stress(self, body: FEModel) -> Callable[[Stress], FloatArray] | None:
        """Return what is measured of the elements' stress, which errs there; None of no point."""
        return None

    def quantity(self, body: FEModel, number: int) -> Quantity:
        """Return the quantity of a body with that number in the plan.

        :meta private:
        """
        shared, measured = SharedSolutions(body), cache(lambda: self.measured(body))
        of_stress = self.of_stress(body)

        @lru_cache(maxsize=_COMPARED)
        def response(run: Run) -> Response:
            found = response_of(run.plan, run.recorder, run.events, number, shared)
            assert found is not None  # a body with a mesh
            return found

        def history(run: Run, times: FloatArray) -> FloatArray:
            if run.plan.bodies[number].wall:  # the body as one that does not deform
                return np.full((1, len(times)), np.nan)
            return np.asarray(measured()(response(run), times)).reshape(1, -1)

        def local(run: Run) -> float:
            values = np.abs(history(run, run.t)[0])
            largest = float(values.max())
            if not largest > 0.0 or of_stress is None:
                return 0.0
            with held_warnings():
                field = response(run).field(run.t[[int(values.argmax())]])
            return _roughness(body, field, self, of_stress) / largest

        return Quantity(
            self.named,
            self.unit,
            history=history,
            each="bodies",
            lasting=True,
            local=None if of_stress is None else local,
        )


def body_of(body: Any) -> FEModel | None:
    """Return the checked body that takes part, by itself or by where it is touched."""
    model = body.body if isinstance(body, ContactPoint) else body
    if model is not None and not isinstance(model, FEModel):
        raise InputTypeError(f"body must be an FEModel or a contact point, got {body!r}")
    return model


def _roughness(body: FEModel, field: Field, of: Any, seen: Callable[[Stress], FloatArray]) -> float:
    """Return by how much the elements about a point differ from their average there.

    The root mean square, as in the energy by which Zienkiewicz and Zhu estimate errors.

    Parameters
    ----------
    body : FEModel
    field : Field
        At one time.
    of : Sensor
        With a point, and where in a shell or beam it is.
    seen : callable
        Stress to the number that is asked for.
    """
    point, layer = of.point, of.where
    assert body.mesh is not None
    assert body.material is not None
    nodes, weights = weights_at(body.mesh, to_nodes(body, point))
    square, moved = 0.0, field.of_elements[0]
    if body.mesh.thin:
        moved = np.hstack([field.displacement[0], field.rotation[0]])
    for node, weight in zip(nodes, weights, strict=True):
        around = corner_stress(body.mesh, body.material, int(node), layer, moved)
        if not len(around):  # a beam is exact
            continue
        pair = Stress(around.mean(axis=0), point), Stress(around, point)
        averaged, of_elements = map(seen, pair)
        square += abs(weight) * float(np.mean((of_elements - averaged) ** 2))
    return math.sqrt(square)
