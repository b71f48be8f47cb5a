"""Stress, strain, filtered acceleration and reactions, as quantities of interest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base import (
    ArrayPair,
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
from ..fem import FEModel, Layer, Strain, Stress, checked_layer
from ..fields import (
    Channel,
    Response,
    TensorAt,
    Work,
    acceleration_of,
    gauge_ends,
    gauge_strain,
    motion_rows,
    place_rows,
)
from .sensor import Sensor

# Default channel frequency class, Hz.
_CLASS = 1000.0

# Time after the impact in which the acceleration is of interest, in periods 1/f of the filter's
# pole frequency f.
_AFTER = 2.0

_COMPONENTS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "yz": (1, 2), "xz": (0, 2)}


class _AtPoint(Sensor):
    """Stress or strain at a point of a body that has a mesh."""

    point: FloatArray
    layer: Any
    part: str | None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.body is None or self.body.mesh is None:
            why = f"has no mesh, without which no {self.named} is known"
            raise InputError(f"body {self.body!r} {why}")
        self.measured(self.body)  # raises if the point is off the body

    @property
    def where(self) -> Layer:
        """Position in the thickness of a shell or the section of a beam.

        :meta private:
        """
        return checked_layer(self.layer, self.part)

    @property
    def _tensor(self) -> TensorAt:
        return TensorAt(self.point[None], self.where, strain=self.named == "strain")


@dataclass(frozen=True, eq=False)
class StressAt(_AtPoint):
    """The stress at a point over the record, for ``simulate(quantity=StressAt(...))``.

    Parameters
    ----------
    body : FEModel or ContactPoint
        Body of the impact, given itself or by a contact point of it.
    point : array_like, shape (3,)
        Position in the undeformed body or on its surface, m.
    component : str, optional
        Stress component: "xx", "yy", "zz", "xy", "yz", "xz" or "von_mises".
    layer, part : optional
        Position in a shell or beam, and group of elements; see `Field.stress`.

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
    named, unit = "stress", "Pa"

    def __post_init__(self) -> None:
        checked(self, point=place)
        choice("component", self.component, (*_COMPONENTS, "von_mises"))
        super().__post_init__()

    def measured(self, body: FEModel) -> Any:
        """See `Sensor`.

        :meta private:
        """
        tensor = self._tensor
        tensor.of(body)  # checks the place

        def seen(response: Response, times: FloatArray) -> FloatArray:
            stress = Stress(tensor(response, times)[:, 0], self.point)
            whole = self.component == "von_mises"
            return stress.von_mises if whole else stress[self.component]

        return seen


@dataclass(frozen=True, eq=False)
class StrainAt(_AtPoint):
    """The strain at a point, or of a gauge, for ``simulate(quantity=StrainAt(...))``.

    Parameters
    ----------
    body : FEModel or ContactPoint
        Body of the impact, given itself or by a contact point of it.
    point : array_like, shape (3,)
        Position in the undeformed body or on its surface, m.
    component : str or array_like, shape (3,)
        Strain component: "xx", "yy", "zz", "xy", "yz" or "xz" of the tensor (half the engineering
        shear strain), or the direction of a normal strain.
    length : float, optional
        Length of a gauge on the surface along the direction, m; 0 is the strain at the point.
    layer, part : optional
        Position in a shell or beam, and group of elements; see `Field.stress`.

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
    named, unit = "strain", ""

    def __post_init__(self) -> None:
        checked(self, point=place, length=lambda name, x: nonnegative(name, x, unit="m"))
        if isinstance(self.component, str):
            if self.component[::-1] in _COMPONENTS:  # "yx" is "xy"
                object.__setattr__(self, "component", self.component[::-1])
            choice("component", self.component, tuple(_COMPONENTS))
        else:
            checked(self, component=lambda name, x: tuple(unit_vector(name, x).tolist()))
        super().__post_init__()

    @cached_property
    def ends(self) -> ArrayPair:
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

    def measured(self, body: FEModel) -> Any:
        """See `Sensor`.

        :meta private:
        """
        if self.length:
            return gauge_strain(body, *self.ends, self.where)
        tensor, weights = self._tensor, self._weights
        tensor.of(body)  # checks the place
        return lambda response, times: tensor(response, times)[:, 0] @ weights

    @property
    def _weights(self) -> FloatArray:
        """Return the weights of the six strain components in the measured strain, shape (6,)."""
        components = np.eye(6)
        if isinstance(self.component, str):
            return np.asarray(components[list(_COMPONENTS).index(self.component)])
        return Strain(components, np.empty(0)).along(np.array(self.component))


@dataclass(frozen=True, eq=False)
class AccelerationAt(Sensor):
    """The filtered acceleration of a point, for ``simulate(quantity=AccelerationAt(...))``.

    An unfiltered acceleration after an impact has no finite bandwidth: it grows with the number of
    modes of a model without limit. The acceleration is therefore defined after the filter of a
    channel, up to the filter's settling time before the end of the record; see `Probe.filtered`. If
    no duration is given, the record is longer than the impact by two periods of the filter and its
    settling time.

    Parameters
    ----------
    point : array_like, shape (3,)
        Position in the undeformed body or on its surface, m.
    direction : array_like, shape (3,)
        Direction of the acceleration, of any length but zero.
    cfc : float, optional
        Channel frequency class of SAE J211, Hz.
    corner : float, optional
        Frequency at which the filter attenuates by 3 dB, Hz, instead of the class.
    body : FEModel or ContactPoint, optional
        Body of the impact; by default the only finite-element body, or the target if both bodies
        have finite elements.

    Raises
    ------
    InputError, InputTypeError
        If the point is off the body, both filters are given, or the filter passes frequencies too
        high for the elements at the point.

    Warns
    -----
    AOImpactWarning
        If neither `cfc` nor `corner` is given: ``cfc=1000`` is taken.

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
    named, unit = "acceleration", "m/s²"

    def __post_init__(self) -> None:
        if self.cfc is None and self.corner is None:
            warn(
                "AccelerationAt: without a filter an acceleration after an impact has no finite "
                "bandwidth and grows with the number of modes, so cfc=1000 is taken; give cfc or "
                "corner"
            )
            object.__setattr__(self, "cfc", _CLASS)
        checked(self, point=place, direction=unit_vector)
        channel = self.channel
        object.__setattr__(self, "cfc", channel.cfc)
        object.__setattr__(self, "corner", channel.corner)
        super().__post_init__()

    @property
    def channel(self) -> Channel:
        """The filter of the channel."""
        return Channel(cfc=self.cfc, corner=self.corner)

    @property
    def memory(self) -> float:  # type: ignore[override]
        """Time by which the record must be longer than the impact, s.

        :meta private:
        """
        return _AFTER / self.channel.pole + self.channel.settling_time

    def check(self, body: FEModel) -> None:
        """Raise InputError if the quantity is not defined for a body.

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

    def measured(self, body: FEModel) -> Any:
        """See `Sensor`; values near the record's end, which are not known, are set to 0.

        :meta private:
        """
        seen = acceleration_of(self.point, self.direction, self.channel)
        return lambda response, times: np.nan_to_num(seen(response, times))


@dataclass(frozen=True, eq=False)
class ReactionAt(Sensor):
    """The force of supports or springs on a body, for ``simulate(quantity=ReactionAt(...))``.

    Parameters
    ----------
    nodes : str, callable or array_like
        Supported nodes as for `BodyResult.reaction`, such as the name of a node set.
    direction : array_like, shape (3,)
        Direction of the force, of any length but zero.
    body : FEModel or ContactPoint, optional
        Body of the impact; by default the only finite-element body, or the target if both bodies
        have finite elements.

    Raises
    ------
    InputError, InputTypeError
        If none of the nodes is supported, or the body was not made from a mesh.

    Examples
    --------
    >>> ReactionAt("edge", (0, 0, 1)).nodes
    'edge'
    """

    nodes: Any
    direction: FloatArray
    body: Any = None
    named, unit = "reaction", "N"

    def __post_init__(self) -> None:
        checked(self, direction=unit_vector)
        super().__post_init__()

    def check(self, body: FEModel) -> None:
        """Raise InputError if the quantity is not defined for a body.

        :meta private:
        """
        body.grounding.nodes("nodes", self.nodes)

    def measured(self, body: FEModel) -> Any:
        """See `Sensor`.

        :meta private:
        """
        held = body.grounding.nodes("nodes", self.nodes)
        work = Work(held, np.zeros(3), np.pad(self.direction, (0, 3))[:, None])
        return lambda response, times: work(response, times).T
