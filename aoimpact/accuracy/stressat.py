"""The stress at a point of a body, as a quantity of interest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from ..base import (
    FloatArray,
    InputError,
    InputTypeError,
    checked,
    choice,
    place,
)
from ..fem import FEModel, Layer, Stress, checked_layer
from ..fields import Response, stress_rows_at
from ..results import Quantity
from .sensor import Responses, Sensor, body_of

_COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz", "von_mises")


@dataclass(frozen=True, eq=False)
class StressAt(Sensor):
    """The stress at a point over the record, for ``simulate(quantity=StressAt(...))``.

    ``error.mesh`` has what the elements leave out of the body's vibration and of the force, and by
    how much their own stress differs from its average at the point.

    Parameters
    ----------
    body : FEModel or ContactPoint
        The body that takes part, by itself or by where it is touched.
    point : array_like, shape (3,)
        Anywhere in the undeformed body or on its surface, m.
    component : str, optional
        "xx", "yy", "zz", "xy", "yz", "xz" or "von_mises".
    layer, part : optional
        Where in a shell or beam, and of which group of elements; see `Field.stress`.

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
    layer: Any = None
    part: str | None = None

    def __post_init__(self) -> None:
        model = body_of(self.body)
        if model is None:
            raise InputTypeError(f"body must be an FEModel or a contact point, got {self.body!r}")
        if model.mesh is None:
            raise InputError(f"body {model!r} has no mesh, without which no stress is known")
        object.__setattr__(self, "body", model)
        checked(self, point=place)
        choice("component", self.component, _COMPONENTS)
        stress_rows_at(model, self.point, self._where)
        super().__post_init__()

    def quantity(self, body: FEModel, number: int) -> Quantity:
        """Return the stress at the point of the body with that number in the plan.

        :meta private:
        """
        responses = Responses(body, number)

        @cache
        def rows() -> Any:
            return stress_rows_at(body, self.point, self._where)

        dual = responses.dual(lambda: rows().rows)

        def stress(response: Response, times: FloatArray) -> FloatArray:
            found = rows().components(response.functionals(rows().rows, times, dual))
            found = found + response.half_space_stress(times, self.point[None])
            return self._seen(Stress(found[:, 0], self.point))

        return responses.quantity("stress", "Pa", stress, (self.point, self._seen, self._where))

    @property
    def _where(self) -> Layer:
        return checked_layer(self.layer, self.part)

    def _seen(self, stress: Stress) -> FloatArray:
        """The component that is asked for."""
        return stress.von_mises if self.component == "von_mises" else stress[self.component]
