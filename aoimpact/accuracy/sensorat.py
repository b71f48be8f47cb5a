"""Strain, filtered acceleration and reactions, as quantities of interest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from ..base import (
    FloatArray,
    InputError,
    checked,
    choice,
    nonnegative,
    place,
    unit_vector,
    warn,
    with_unit,
)
from ..fem import FEModel, Layer, Strain, Stress, StressRows, VirtualMotion, checked_layer
from ..fields import (
    Channel,
    Response,
    filtered_acceleration,
    gauge_ends,
    motion_rows,
    place_rows,
    shell_gauge_rows,
    strain_rows_at,
)
from ..results import Quantity
from .sensor import Responses, Sensor, body_of

# Channel frequency class that is taken if none was given, Hz.
_CLASS = 1000.0

# Periods of the filter's pole after the impact in which the acceleration is looked at.
_AFTER = 2.0

_COMPONENTS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "yz": (1, 2), "xz": (0, 2)}


@dataclass(frozen=True, eq=False)
class StrainAt(Sensor):
    """The strain at a point, or of a gauge, for ``simulate(quantity=StrainAt(...))``.

    ``error.mesh`` has what the elements leave out of the body's vibration and of the force; of the
    strain at a point also by how much theirs differs from its average there.

    Parameters
    ----------
    body : FEModel or ContactPoint
        The body that takes part, by itself or by where it is touched.
    point : array_like, shape (3,)
        In the undeformed body or on its surface, m.
    component : str or array_like, shape (3,)
        "xx", "yy", "zz", "xy", "yz", "xz" (shears are those of the tensor), or a direction.
    length : float, optional
        Length of a gauge along a direction on the surface, m; 0 is the strain at the point.
    layer, part : optional
        Where in a shell or beam, and of which group of elements; see `Field.stress`.

    Raises
    ------
    InputError, InputTypeError
        If the point is off the body, the body has no mesh, or the gauge is not on its surface.

    Examples
    --------
    >>> steel = Material(E=210e9, nu=0.3, rho=7800)
    >>> plate = FEModel.from_mesh(box_mesh((0.2, 0.2, 0.01), (8, 8, 1)), steel)
    >>> gauge = StrainAt(plate, (0.1, 0.1, 0.0), (1, 0, 0), length=3e-3)  # simulate(quantity=gauge)
    >>> gauge.length
    0.003
    """

    body: Any
    point: FloatArray
    component: Any = "xx"
    length: float = 0.0
    layer: Any = None
    part: str | None = None

    def __post_init__(self) -> None:
        model = body_of(self.body)
        if model is None or model.mesh is None:
            raise InputError(f"body {model!r} has no mesh, without which no strain is known")
        object.__setattr__(self, "body", model)
        checked(self, point=place, length=lambda name, x: nonnegative(name, x, unit="m"))
        if isinstance(self.component, str):
            if self.component[::-1] in _COMPONENTS:  # of a symmetric tensor
                object.__setattr__(self, "component", self.component[::-1])
            choice("component", self.component, tuple(_COMPONENTS))
        else:
            checked(self, component=lambda name, x: tuple(unit_vector(name, x).tolist()))
        if self.length:
            shell_gauge_rows(model, *self.ends, self._where)  # which checks them
        else:
            strain_rows_at(model, self.point, self._where)
        super().__post_init__()

    @cached_property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """Ends of the gauge, m, and the unit vector along it.

        :meta private:
        """
        if isinstance(self.component, str):
            i, j = _COMPONENTS[self.component]
            if i != j:
                raise InputError(
                    f"component={self.component!r}: a gauge measures along a direction; give one"
                )
            along = np.eye(3)[i]
        else:
            along = np.array(self.component)
        return gauge_ends(self.body, self.point, along, self.length, "component")

    def quantity(self, body: FEModel, number: int) -> Quantity:
        """Return the quantity of a body with that number in the plan.

        :meta private:
        """
        if self.length:
            return self._of_gauge(body, number)
        responses = Responses(body, number)
        weights = self._weights

        @cache
        def by_dofs() -> tuple[StressRows, FloatArray]:
            rows, compliance = strain_rows_at(body, self.point, self._where)
            return rows, weights @ compliance

        dual = responses.dual(lambda: by_dofs()[0].rows)

        def strain(response: Response, times: FloatArray) -> FloatArray:
            rows, compliance = by_dofs()
            under = response.half_space_stress(times, self.point[None])[:, 0]
            found = rows.components(response.functionals(rows.rows, times, dual))[:, 0]
            return np.asarray(found @ weights + under @ compliance)

        def seen(stress: Stress) -> FloatArray:
            return np.asarray(stress.components @ by_dofs()[1])

        return responses.quantity("strain", "", strain, (self.point, seen, self._where))

    @property
    def _where(self) -> Layer:
        return checked_layer(self.layer, self.part)

    @property
    def _weights(self) -> FloatArray:
        """The component by all six, (6,)."""
        components = np.eye(6)
        if isinstance(self.component, str):
            return np.asarray(components[list(_COMPONENTS).index(self.component)])
        return Strain(components, np.empty(0)).along(np.array(self.component))

    def _of_gauge(self, body: FEModel, number: int) -> Quantity:
        responses, (ends, along) = Responses(body, number), self.ends
        axes = along[None]

        @cache
        def rows() -> Any:
            of_shell = shell_gauge_rows(body, ends, along, self._where)
            return motion_rows(body, place_rows(body, ends), axes) if of_shell is None else of_shell

        dual = responses.dual(rows)
        thin = body.mesh is not None and body.mesh.thin
        size = float(np.linalg.norm(ends[1] - ends[0]))

        def strain(response: Response, times: FloatArray) -> FloatArray:
            if thin:
                return np.asarray(response.functionals(rows(), times, dual)[0])
            u = response.motion_at(ends, axes, rows(), times, dual, rates=False)[0]
            return np.asarray((u[:, 1] - u[:, 0]) / size)

        return responses.quantity("strain", "", strain)


@dataclass(frozen=True, eq=False)
class AccelerationAt(Sensor):
    """The acceleration of a point behind a filter, for ``simulate(quantity=AccelerationAt(...))``.

    An acceleration after an impact has no finite bandwidth: it grows with the number of modes of a
    model, and no model has enough of them. It is defined behind the filter of a channel, up to the
    filter's settling time before the end of the record; see `Probe.filtered`. A record that is not
    given lasts two periods of the filter and this time longer than the impact.

    Parameters
    ----------
    point : array_like, shape (3,)
        In the undeformed body or on its surface, m.
    direction : array_like, shape (3,)
        Any length but zero.
    cfc : float, optional
        Channel frequency class of SAE J211, Hz.
    corner : float, optional
        In place of the class, the frequency where the filter is 3 dB down, Hz.
    body : FEModel or ContactPoint, optional
        By itself the only finite-element body; of an impact of two, the target.

    Raises
    ------
    InputError, InputTypeError
        If the point is off the body, both filters are given, or the filter passes frequencies
        above those that the elements at the point have.

    Warns
    -----
    AOImpactWarning
        If no filter is given: the class 1000 is taken.

    Examples
    --------
    >>> AccelerationAt((0.1, 0.1, 0.0), (0, 0, 1), cfc=1000).channel
    Channel(cfc=1000.0, corner=None)
    """

    point: FloatArray
    direction: FloatArray
    cfc: float | None = None
    corner: float | None = None
    body: Any = None

    def __post_init__(self) -> None:
        if self.cfc is None and self.corner is None:
            warn(
                "AccelerationAt: without a filter an acceleration after an impact has no finite "
                "bandwidth and grows with the number of modes, so cfc=1000 is taken; give cfc or "
                "corner"
            )
            object.__setattr__(self, "cfc", _CLASS)
        object.__setattr__(self, "body", body_of(self.body))
        checked(self, point=place, direction=unit_vector)
        channel = self.channel
        object.__setattr__(self, "cfc", channel.cfc)
        object.__setattr__(self, "corner", channel.corner)
        if self.body is not None:
            self.check(self.body)
        super().__post_init__()

    @property
    def channel(self) -> Channel:
        """The filter."""
        return Channel(cfc=self.cfc, corner=self.corner)

    @property
    def memory(self) -> float:  # type: ignore[override]
        """Length of a record beyond that of the impact, s.

        :meta private:
        """
        return _AFTER / self.channel.pole + self.channel.settling_time

    def check(self, body: FEModel) -> None:
        """Refuse a body that has no such quantity.

        :meta private:
        """
        if body.nodes is None:
            raise InputError(f"body {body!r} has no nodes, without which no point is known")
        row = motion_rows(body, place_rows(body, self.point[None]), self.direction[None])
        stiffness, mass = (float((row @ of @ row.T).sum()) for of in (body.K, body.M))
        if 0.0 < mass * (2.0 * math.pi * self.channel.passed) ** 2 > stiffness > 0.0:
            carried = math.sqrt(stiffness / mass) / (2.0 * math.pi)
            raise InputError(
                f"{self.channel} passes {with_unit(self.channel.passed, 'Hz')}, and the elements "
                f"at the point vibrate at {with_unit(carried, 'Hz')} at most: take a class of "
                f"{0.5 * carried:.2g} or less, or smaller elements"
            )

    def quantity(self, body: FEModel, number: int) -> Quantity:
        """Return the quantity of a body with that number in the plan.

        :meta private:
        """
        responses, places, axes = Responses(body, number), self.point[None], self.direction[None]

        @cache
        def rows() -> Any:
            return motion_rows(body, place_rows(body, places), axes)

        dual = responses.dual(rows)

        def acceleration(response: Response, times: FloatArray) -> FloatArray:
            def motion(at: FloatArray) -> tuple[FloatArray, FloatArray]:
                return response.motion_at(places, axes, rows(), at, dual)

            found = filtered_acceleration(motion, response.motion.duration, self.channel, times)
            return np.nan_to_num(found)  # what follows the record is not known, and not compared

        return responses.quantity("acceleration", "m/s²", acceleration)


@dataclass(frozen=True, eq=False)
class ReactionAt(Sensor):
    """The force of supports or springs on a body, for ``simulate(quantity=ReactionAt(...))``.

    Parameters
    ----------
    nodes : str, callable or array_like
        As of `BodyResult.reaction`, such as the name of the set that is held.
    direction : array_like, shape (3,)
        Any length but zero.
    body : FEModel or ContactPoint, optional
        By itself the only finite-element body; of an impact of two, the target.

    Raises
    ------
    InputError, InputTypeError
        If none of the nodes is held, or the body was not made from a mesh.

    Examples
    --------
    >>> ReactionAt("edge", (0, 0, 1)).nodes
    'edge'
    """

    nodes: Any
    direction: FloatArray
    body: Any = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "body", body_of(self.body))
        checked(self, direction=unit_vector)
        if self.body is not None:
            self.check(self.body)
        super().__post_init__()

    def check(self, body: FEModel) -> None:
        """Refuse a body that has no such quantity.

        :meta private:
        """
        body.grounding.nodes("nodes", self.nodes)

    def quantity(self, body: FEModel, number: int) -> Quantity:
        """Return the quantity of a body with that number in the plan.

        :meta private:
        """
        responses, grounding = Responses(body, number), body.grounding

        @cache
        def moved() -> VirtualMotion:
            held = grounding.nodes("nodes", self.nodes)
            motions = grounding.resultants(held, np.zeros(3))[:, :3]
            return grounding.virtual((motions @ self.direction)[:, None])

        def reaction(response: Response, times: FloatArray) -> FloatArray:
            return response.held.work(moved(), times)

        return responses.quantity("reaction", "N", reaction)
