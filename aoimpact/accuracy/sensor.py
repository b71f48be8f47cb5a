"""A quantity of interest of one body, and its responses in the runs that are compared."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from ..base import FloatArray, Frozen, InputTypeError, held_warnings
from ..fem import (
    ContactPoint,
    FEModel,
    Layer,
    Stress,
    corner_stress,
    stresses_around,
    to_nodes,
)
from ..fields import Field, Response, response_of
from ..linalg import SolverBook
from ..mesh import weights_at
from ..reduction import SOLVED
from ..results import Quantity, Run

# Runs that a search goes back to: of one order, and of those up to eight larger.
_COMPARED = 9


class Responses:
    """The responses of a body in the runs that are compared, and what all of them share."""

    def __init__(self, body: FEModel, number: int) -> None:
        self.body, self.number, factors = body, number, SolverBook(body.inverse)
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

    def quantity(
        self,
        name: str,
        unit: str,
        seen: Callable[[Response, FloatArray], FloatArray],
        point: tuple[FloatArray, Callable[[Stress], FloatArray], Layer] | None = None,
    ) -> Quantity:
        """Return a history of the body as a quantity of interest.

        Parameters
        ----------
        name, unit : str
        seen : callable
            Response and times, s, to values of shape (times,).
        point : (ndarray, callable, layer), optional
            Where the elements' stress is taken, m, what of it, and in which layer of a shell, for
            the error by the elements.
        """

        def history(run: Run, times: FloatArray) -> FloatArray:
            if run.plan.bodies[self.number].wall:  # the body as one that does not deform
                return np.full((1, len(times)), np.nan)
            return np.asarray(seen(self.of(run), times)).reshape(1, -1)

        def local(run: Run) -> float:
            assert point is not None
            values = np.abs(history(run, run.t)[0])
            largest = float(values.max())
            if not largest > 0.0:
                return 0.0
            with held_warnings():
                field = self.of(run).field(run.t[[int(values.argmax())]])
            return _roughness(self.body, field, *point) / largest

        return Quantity(
            name,
            unit,
            history=history,
            each="bodies",
            lasting=True,
            local=None if point is None else local,
        )


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

    def quantity(self, body: FEModel, number: int) -> Quantity:
        """Return the quantity of a body with that number in the plan."""
        raise NotImplementedError

    def check(self, body: FEModel) -> None:
        """Refuse a body that has no such quantity."""


def body_of(body: Any) -> FEModel | None:
    """Return the checked body that takes part, by itself or by where it is touched."""
    model = body.body if isinstance(body, ContactPoint) else body
    if model is not None and not isinstance(model, FEModel):
        raise InputTypeError(f"body must be an FEModel or a contact point, got {body!r}")
    return model


def _roughness(
    body: FEModel,
    field: Field,
    point: FloatArray,
    seen: Callable[[Stress], FloatArray],
    layer: Layer,
) -> float:
    """Return by how much the elements about a point differ from their average there.

    The root mean square, as in the energy by which Zienkiewicz and Zhu estimate errors.

    Parameters
    ----------
    body : FEModel
    field : Field
        At one time.
    point : ndarray, shape (3,)
        m.
    seen : callable
        Stress to the number that is asked for.
    layer : Layer
    """
    assert body.mesh is not None
    nodes, weights = weights_at(body.mesh, to_nodes(body, point))
    square = 0.0
    for node, weight in zip(nodes, weights, strict=True):
        if body.mesh.thin:
            moved = np.hstack([field.displacement[0], field.rotation[0]])
            assert body.material is not None
            around = corner_stress(body.mesh, body.material, int(node), layer, moved)
            if not len(around):  # a beam is exact
                continue
            pair = Stress(around.mean(axis=0), point), Stress(around, point)
        else:
            pair = stresses_around(body, field.of_elements[0], int(node))
        averaged, of_elements = map(seen, pair)
        square += abs(weight) * float(np.mean((of_elements - averaged) ** 2))
    return math.sqrt(square)
