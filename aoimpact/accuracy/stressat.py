"""The stress at a point of a body, as a quantity of interest."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..base import (
    FloatArray,
    InputError,
    InputTypeError,
    checked,
    choice,
    held_warnings,
    place,
)
from ..fem import Body, Layer, Stress, checked_layer, corner_stress, stresses_around
from ..fields import Field, stress_rows_at
from ..mesh import weights_at
from ..results import Quantity, Run
from .sensor import Responses, Sensor, body_of

_COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz", "von_mises")


@dataclass(frozen=True, eq=False)
class StressAt(Sensor):
    """The stress at a point over the record, for ``simulate(quantity=StressAt(...))``.

    ``error.mesh`` has what the elements leave out of the force, and by how much their own stress
    differs from its average at the point.

    Parameters
    ----------
    body : FEModel or ContactPoint
        The body that takes part, by itself or by where it is touched.
    point : array_like, shape (3,)
        Anywhere in the undeformed body or on its surface, m.
    component : str, optional
        "xx", "yy", "zz", "xy", "yz", "xz" or "von_mises".
    layer : {"top", "middle", "bottom"} or (int, str), optional
        Where in a shell; see `Field.stress`.

    Raises
    ------
    InputError, InputTypeError
        If the point is off the body, or the body has no mesh.

    Examples
    --------
    >>> steel = Material(E=210e9, nu=0.3, rho=7800)
    >>> plate = FEModel.from_mesh(box_mesh((0.2, 0.2, 0.01), (8, 8, 1)), steel)
    >>> opposite = StressAt(plate, (0.1, 0.1, 0.0), "xx")  # simulate(..., quantity=opposite)
    >>> opposite.component
    'xx'
    """

    body: Any
    point: FloatArray
    component: str = "von_mises"
    layer: Any = "top"

    def __post_init__(self) -> None:
        model = body_of(self.body)
        if model is None:
            raise InputTypeError(f"body must be an FEModel or a contact point, got {self.body!r}")
        if model.mesh is None:
            raise InputError(f"body {model!r} has no mesh, without which no stress is known")
        object.__setattr__(self, "body", model)
        checked(self, point=place)
        choice("component", self.component, _COMPONENTS)
        checked(self, layer=checked_layer)
        weights_at(model.mesh, self.point)
        super().__post_init__()

    def quantity(self, body: Body, number: int) -> Quantity:
        """Return the stress at the point of the body with that number in the plan.

        :meta private:
        """
        responses = Responses(body, number)

        @cache
        def rows() -> Any:
            return stress_rows_at(body, self.point, self.layer)

        dual = responses.dual(rows)

        def stress(run: Run, times: FloatArray) -> FloatArray:
            if run.plan.bodies[number].wall:  # the body as one that does not deform
                return np.full((1, len(times)), np.nan)
            found = responses.of(run).functionals(rows(), times, dual)
            found = found + responses.of(run).half_space_stress(times, self.point[None])[:, 0].T
            return _component(Stress(found.T, self.point), self.component)[None]

        def local(run: Run) -> float:
            history = np.abs(stress(run, run.t)[0])
            largest = float(history.max())
            if not largest > 0.0:
                return 0.0
            with held_warnings():
                field = responses.of(run).field(run.t[[int(history.argmax())]])

            def seen(stress: Stress) -> FloatArray:
                return _component(stress, self.component)

            return roughness(body, self.point, seen, field, self.layer) / largest

        return Quantity("stress", "Pa", history=stress, each="bodies", lasting=True, local=local)


def _component(stress: Stress, name: str) -> FloatArray:
    return stress.von_mises if name == "von_mises" else stress[name]


def roughness(
    body: Body,
    point: FloatArray,
    seen: Callable[[Stress], FloatArray],
    field: Field,
    layer: Layer = "top",
) -> float:
    """Return by how much the elements about a point differ from their average there.

    The root mean square, as in the energy by which Zienkiewicz and Zhu estimate errors.

    Parameters
    ----------
    body : FEModel
    point : ndarray, shape (3,)
        m.
    seen : callable
        Stress to the number that is asked for.
    field : Field
        At one time.
    layer : str or (int, str), optional
        Of a shell.
    """
    assert body.mesh is not None
    nodes, weights = weights_at(body.mesh, point)
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
