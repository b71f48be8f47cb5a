"""The stress at a point of a body, as a quantity of interest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import numpy as np

from ..base import (
    FloatArray,
    Frozen,
    InputError,
    InputTypeError,
    checked,
    choice,
    held_warnings,
    place,
)
from ..fem import ContactPoint, FEModel, Stress, stresses_around
from ..fields import Response, response_of, stress_rows_at
from ..linalg import SolverBook
from ..mesh import weights_at
from ..reduction import SOLVED
from ..results import Quantity, Run

__all__ = ["StressAt", "stress_quantity"]

# Runs that a search goes back to: of one order, and of those up to eight larger.
_COMPARED = 9

_COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz", "von_mises")


@dataclass(frozen=True, eq=False)
class StressAt(Frozen):
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

    def __post_init__(self) -> None:
        model = self.body.body if isinstance(self.body, ContactPoint) else self.body
        if not isinstance(model, FEModel):
            raise InputTypeError(f"body must be an FEModel or a contact point, got {self.body!r}")
        if model.mesh is None:
            raise InputError(f"body {model!r} has no mesh, without which no stress is known")
        object.__setattr__(self, "body", model)
        checked(self, point=place)
        choice("component", self.component, _COMPONENTS)
        weights_at(model.mesh, self.point)
        super().__post_init__()


def stress_quantity(wanted: StressAt, number: int) -> Quantity:
    """Return the stress at a point of the body with that number in the plan."""

    factors = SolverBook(wanted.body.inverse)  # for all models that are compared

    @cache
    def rows() -> Any:
        return stress_rows_at(wanted.body, wanted.point)

    @lru_cache(maxsize=_COMPARED)
    def dual(s: float) -> FloatArray:
        solver = factors(s**2)
        return np.stack([solver.solve_roughly(row, SOLVED)[0] for row in rows().toarray()])

    @lru_cache(maxsize=_COMPARED)
    def response(run: Run) -> Response:
        found = response_of(run.plan, run.recorder, run.events, number, factors)
        assert found is not None  # a body with a mesh
        return found

    def stress(run: Run, times: FloatArray) -> FloatArray:
        if run.plan.bodies[number].wall:  # the body as one that does not deform
            return np.full((1, len(times)), np.nan)
        found = response(run).functionals(rows(), times, dual)
        found = found + response(run).half_space_stress(times, wanted.point[None])[:, 0].T
        return _component(Stress(found.T, wanted.point), wanted.component)[None]

    def local(run: Run) -> float:
        history = np.abs(stress(run, run.t)[0])
        largest = float(history.max())
        if not largest > 0.0:
            return 0.0
        with held_warnings():
            field = response(run).field(run.t[[int(history.argmax())]])
        return _roughness(wanted, field.of_elements[0]) / largest

    return Quantity("stress", "Pa", history=stress, each="bodies", lasting=True, local=local)


def _component(stress: Stress, name: str) -> FloatArray:
    return stress.von_mises if name == "von_mises" else stress[name]


def _roughness(wanted: StressAt, displacement: FloatArray) -> float:
    """By how much the elements about a point differ from their average there, Pa.

    The root mean square, as in the energy by which Zienkiewicz and Zhu estimate errors.
    """
    nodes, weights = weights_at(wanted.body.mesh, wanted.point)
    square = 0.0
    for node, weight in zip(nodes, weights, strict=True):
        averaged, of_elements = (
            _component(found, wanted.component)
            for found in stresses_around(wanted.body, displacement, int(node))
        )
        square += abs(weight) * float(np.mean((of_elements - averaged) ** 2))
    return math.sqrt(square)
