"""Sensors on a body: motion, strain and stress of a place, gauges, filtered motion, reactions.

Each measures a function of the whole body's motion over time (`Response`), as a `History`, so that
its error is judged where it measures.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from ..base import (
    HUGE,
    FloatArray,
    Found,
    InputError,
    IntArray,
    finite_array,
    plain,
    unit_vector,
    warn,
    with_unit,
)
from ..contact import to_nodes
from ..fem import FEModel, Layer, Strain, Stress, VirtualMotion, selected_nodes
from .channel import Channel, filtered_acceleration
from .history import History, Sensed
from .response import Response
from .rows import motion_rows, place_rows, shell_gauge_rows, tensor_rows

# sin of the angle between a gauge and the surface beyond which it does not lie on it.
_OFF = 0.1

# Distance of an end from the surface, over the gauge's length, beyond which it is off the body; the
# same of its middle; and by how much of it an end may move along the gauge to its place on the
# surface, which on a curved one is (length/radius)²/16 of it.
_BEYOND, _BESIDE, _SHORTER = 0.25, 0.1, 0.01


class At(NamedTuple):
    """Places and axes of a measured motion; see `Response.motion_at`."""

    places: FloatArray
    axes: FloatArray
    rows: Any


@dataclass(frozen=True, eq=False)
class Filtered(Sensed[Response]):
    """Acceleration behind the filter of a channel.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    channel : Channel
        Its frequency class or corner, Hz.
    """

    channel: Channel

    @property
    def acceleration(self) -> FloatArray:
        """Acceleration, m/s², in the shape of `Probe.displacement`; warns where it may be wrong.

        It and its error are NaN over the filter's settling time before the end of the record; see
        `Probe.filtered`.
        """
        return self._history.told()


@dataclass(frozen=True, eq=False)
class Gauge(Sensed[Response]):
    """Strain of a gauge over time: the mean along its length.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    ends : ndarray, shape (2, 3)
        On the undeformed body, m; of a shell on the surface of its nodes.
    """

    ends: FloatArray

    @property
    def strain(self) -> FloatArray:
        """Strain, shape (n,), positive in tension; warns where it may be wrong, see `error`."""
        return self._history.told()


@dataclass(frozen=True, eq=False)
class Probe:
    """Motion, strain and stress of one place of a body over time.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    points : ndarray, shape (3,) or (p, 3)
        Where, on the undeformed body, m.
    """

    t: FloatArray
    points: FloatArray
    _response: Response = field(repr=False)
    _at: At = field(repr=False)
    _along: bool = field(repr=False)  # True of motion along one direction
    _weights: sp.csr_array = field(repr=False)  # of the nodes at the points
    _layer: Layer = field(repr=False)

    @cached_property
    def _histories(self) -> dict[str, History[Response]]:
        made = partial(_history, self._response, self.t)
        moved = partial(_moved, self._at, self._shape)
        return {
            "displacement": made("displacement", moved),
            "velocity": made("velocity", partial(moved, rates=True), displacement=moved),
            "stress": made("stress", self._tensor),
            "strain": made("strain", partial(self._tensor, strain=True)),
        }

    def _tensor(self, response: Response, times: FloatArray, *, strain: bool = False) -> FloatArray:
        """Stress, Pa, or strain in a run of the body."""
        rows = tensor_rows(response.body, self._weights, self._layer, strain=strain)
        return response.stress(rows, times).reshape(-1, *self._places, 6)

    @property
    def _places(self) -> tuple[int, ...]:
        return self.points.shape[:-1]

    @property
    def _shape(self) -> tuple[int, ...]:
        """Shape of a motion at each time."""
        return self._places if self._along else (*self._places, 3)

    @property
    def displacement(self) -> FloatArray:
        """Displacement, m, shape (n, p, 3).

        Without the axis p for a single point, and without the last one for a given direction, along
        which it is then measured. Warns where it may be badly wrong; see `error`.
        """
        return self._histories["displacement"].told()

    @property
    def velocity(self) -> FloatArray:
        """Velocity, m/s, in the shape of `displacement`."""
        return self._histories["velocity"].told()

    @property
    def doubt(self) -> FloatArray:
        """Signed bound of the error of `velocity`, m/s, in its shape.

        :meta private:
        """
        return self._histories["velocity"].doubt

    @cached_property
    def acceleration(self) -> FloatArray:
        """Acceleration, m/s², in the shape of `displacement`, as the body's model has it.

        By central differences over a thousandth of the shortest contact, or over two fixed steps.

        Warns
        -----
        AOImpactWarning
            It has no finite bandwidth, and no error that could be known: an impact excites modes up
            to any frequency, each with as much acceleration. `filtered` converges.
        """
        warn(
            "acceleration has no finite bandwidth after an impact: it grows with the number of "
            "modes of the model, and has no error; take probe.filtered(cfc=1000), or "
            "quantity=AccelerationAt(point, direction, cfc=1000)"
        )
        motion = self._response.motion
        after = np.minimum(self.t + motion.resolution, motion.duration)
        before = np.maximum(self.t - motion.resolution, 0.0)
        speeds = (self._response.motion_at(*self._at, times)[1] for times in (after, before))
        change = np.subtract(*speeds) / (after - before)[:, None]
        return np.asarray(change.reshape(-1, *self._shape))

    def filtered(self, cfc: float | None = None, *, corner: float | None = None) -> Filtered:
        """Return the acceleration behind a filter.

        SAE J211-1, appendix C: a Butterworth filter of two poles, forward and backward, so that no
        phase is shifted. Before the record the body is at rest or moves steadily. What follows the
        record is not known, so that the acceleration is NaN over the filter's settling time before
        the end, the class's period: 1 ms for CFC 1000. Take a `duration` longer by that.

        Parameters
        ----------
        cfc : float, optional
            Channel frequency class, Hz: 60, 180, 600 or 1000 in the standard; any other by the same
            formula. The signal is 3 dB down at 1.65 times the class.
        corner : float, optional
            In place of the class, the frequency where the signal is 3 dB down, Hz.

        Raises
        ------
        InputError
            If neither or both are given, or the record is shorter than the settling time.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(mass=0.01), ao.full(tip), velocity=0.1,
        ...     law=ao.Linear(k=1e5), duration=2e-3, solver=ao.Newmark(dt=5e-6))
        >>> probe = hit.target.probe((0.05, 0.005, 0.0), (0, 0, 1), dt=1e-5)
        >>> probe.filtered(cfc=1000).acceleration.shape == probe.t.shape
        True
        """
        channel, response = Channel(cfc=cfc, corner=corner), self._response
        seen = partial(_filtered, self._at, self._shape, channel)
        found = Filtered(_history(response, self.t, "filtered acceleration", seen), channel)
        _ = found._history.values  # which refuses a record that is too short
        return found

    @cached_property
    def error(self) -> Mapping[str, FloatArray]:
        """Errors by the body's model at this place, relative to the largest value, of shape (n,).

        ``error["displacement"]``, "velocity", "stress" and "strain", each of the largest of its
        components; see `BodyResult.error`. It is empty of a full model.
        """
        of_motion = {name: self._histories[name] for name in ("displacement", "velocity")}
        solid = self._response.body.material is not None
        return _errors(self._response, self._histories if solid else of_motion)

    @property
    def stress(self) -> Stress:
        """The stress over time, of shape (n, p, 6), or (n, 6) for a single point.

        Averaged at the nodes as `Field.stress`, between them by the elements' shape functions.

        Raises
        ------
        InputError
            If the body has no elements and material: it was given by K and M.
        """
        return Stress(self._histories["stress"].told(), self.points)

    @property
    def strain(self) -> Strain:
        """The strain over time, in the shape of `stress`; shears are those of the tensor.

        Raises
        ------
        InputError
            If the body has no elements and material: it was given by K and M.
        """
        return Strain(self._histories["strain"].told(), self.points)


@dataclass(frozen=True, eq=False)
class Reaction:
    """The force of supports and springs on a body over time.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    centre : ndarray, shape (3,)
        Mean of the points, m.
    points : ndarray, shape (p, 3)
        The held nodes, m.
    """

    t: FloatArray
    centre: FloatArray
    points: FloatArray
    _response: Response = field(repr=False)
    _nodes: IntArray = field(repr=False)

    @cached_property
    def _histories(self) -> dict[str, History[Response]]:
        grounding = self._response.body.grounding
        ways = grounding.resultants(self._nodes, self.centre)
        names = {"force": "reaction", "moment": "moment of the reaction"}
        return {
            key: _history(self._response, self.t, name, partial(_work, grounding.virtual(of)))
            for (key, name), of in zip(names.items(), np.hsplit(ways, 2), strict=True)
        }

    @property
    def force(self) -> FloatArray:
        """Force on the body, N, shape (n, 3); warns where it may be badly wrong, see `error`."""
        return self._histories["force"].told()

    @property
    def moment(self) -> FloatArray:
        """Moment on the body about the `centre`, N m, shape (n, 3)."""
        return self._histories["moment"].told()

    @cached_property
    def nodal_force(self) -> FloatArray:
        """Forces on the nodes, N, shape (n, p, 3); they add up to `force`."""
        return self._response.held.at_nodes(self._nodes, self.t)

    @cached_property
    def error(self) -> Mapping[str, FloatArray]:
        """Errors by the body's model, relative to the largest value, of shape (n,).

        ``error["force"]`` and ``error["moment"]``; see `BodyResult.error`. It is empty of a full
        model.
        """
        return _errors(self._response, self._histories)


def probe_at(
    response: Response, point: Any, direction: Any, nodes: Any, times: Any, layer: Layer
) -> Probe:
    """See `BodyResult.probe`."""
    wanted, body = response.within(times), response.body
    if (point is None) == (nodes is None):
        raise InputError("probe needs either point or nodes, and not both")
    _ = response.free
    assert body.nodes is not None
    if nodes is not None:
        sets = {} if body.mesh is None else body.mesh.node_sets
        chosen = selected_nodes("nodes", nodes, body.nodes, sets, body.node_labels)
        places, weights = body.nodes[chosen], sp.eye_array(len(body.nodes), format="csr")[chosen]
    else:
        places = finite_array("point", point, unit="m", most=HUGE)
        if places.shape[-1:] != (3,) or places.ndim > 2 or places.size == 0:
            raise InputError(f"point must have shape (3,) or (p, 3), got {places.shape}")
        weights = place_rows(body, places.reshape(-1, 3))
    axes = np.eye(3) if direction is None else unit_vector("direction", direction)[None]
    at = At(np.atleast_2d(places), axes, motion_rows(body, weights, axes))
    return Probe(wanted, places, response, at, direction is not None, weights, layer)


def gauge_at(
    response: Response, point: Any, direction: Any, length: float, times: Any, layer: Layer
) -> Gauge:
    """See `BodyResult.gauge`."""
    wanted, body = response.within(times), response.body
    place = finite_array("point", point, shape=(3,), unit="m", most=HUGE)
    ends, along = gauge_ends(body, place, unit_vector("direction", direction), length)
    seen = gauge_strain(body, ends, along, layer)
    return Gauge(_history(response, wanted, "strain of a gauge", seen), ends)


def gauge_strain(body: FEModel, ends: FloatArray, along: FloatArray, layer: Layer) -> Any:
    """Return what gives the strain between two ends from a response and times, s."""
    rows = shell_gauge_rows(body, ends, along, layer)
    if rows is not None:
        return partial(_functional, rows)
    axes = along[None]
    return partial(_elongation, At(ends, axes, motion_rows(body, place_rows(body, ends), axes)))


def acceleration_of(body: FEModel, point: FloatArray, axis: FloatArray, channel: Channel) -> Any:
    """Return what gives the acceleration of a point behind a filter."""
    places, axes = point[None], axis[None]
    at = At(places, axes, motion_rows(body, place_rows(body, places), axes))
    return partial(_filtered, at, (), channel)


def reaction_of(response: Response, nodes: Any, times: Any) -> Reaction:
    """See `BodyResult.reaction`."""
    wanted = response.within(times)
    held = response.body.grounding.nodes("nodes", nodes)
    assert response.body.nodes is not None
    points = response.body.nodes[held]
    return Reaction(wanted, points.mean(axis=0), points, response, held)


def _history(
    response: Response, times: FloatArray, name: str, seen: Any, displacement: Any = None
) -> History[Response]:
    duration = response.motion.duration
    return History(name, response, response.compared, seen, times, duration, displacement)


def _errors(
    response: Response, histories: Mapping[str, History[Response]]
) -> Mapping[str, FloatArray]:
    """The errors of histories by name; none of a full model."""
    if response.compared() is None:
        return {}
    return Found(lambda: histories, lambda name: histories[name].error)


# Readings of a response at times, s: each returns values of shape (times, ...).


def _moved(
    at: At,
    shape: tuple[int, ...],
    response: Response,
    times: FloatArray,
    *,
    rates: bool = False,
) -> FloatArray:
    """Displacement, m, or velocity, m/s, of places."""
    return response.motion_at(*at, times, rates=rates)[int(rates)].reshape(-1, *shape)


def _filtered(
    at: At, shape: tuple[int, ...], channel: Channel, response: Response, times: FloatArray
) -> FloatArray:
    """Acceleration of places behind a filter, m/s²."""
    motion = partial(response.motion_at, *at)
    found = filtered_acceleration(motion, response.motion.duration, channel, times)
    return found.reshape(-1, *shape)


def _functional(rows: sp.csr_array, response: Response, times: FloatArray) -> FloatArray:
    return np.asarray(response.functionals(rows, times)[0])


def _elongation(at: At, response: Response, times: FloatArray) -> FloatArray:
    """Elongation between two places over their distance."""
    first, second = response.motion_at(*at, times, rates=False)[0].T
    return np.asarray((second - first) / np.linalg.norm(at.places[1] - at.places[0]))


def _work(moved: VirtualMotion, response: Response, times: FloatArray) -> FloatArray:
    """Forces of the ground along some motions of it, N or N m, shape (times, m)."""
    return response.held.work(moved, times).T


def gauge_ends(
    body: FEModel, point: FloatArray, direction: FloatArray, length: float, name: str = "direction"
) -> tuple[FloatArray, FloatArray]:
    """Return both ends of a gauge, shape (2, 3), m, and the unit vector from one to the other.

    The ends lie on the surface: the mean strain along a chord is the change of its length. On a
    curved surface that differs from the mean along the arc by (length/radius)²/24.
    """
    if body.nodes is None:
        raise InputError(
            "this body has no nodes, between which a gauge measures: give nodes= with K and M"
        )
    if body.mesh is not None and body.surface is None:
        raise InputError(
            "a gauge sits on a surface, and beams have only an axis; take the strain of a side, "
            "probe(point, layer=).strain"
        )
    point = to_nodes(body, point)
    where = f"the gauge of length={with_unit(length, 'm')} at point {plain(point)} m"
    if length > float(np.ptp(body.nodes, axis=0).max()):
        raise InputError(f"{where} is longer than the body: give a shorter one, in metres")
    half = 0.5 * length * direction
    ends = np.stack([point - half, point + half])
    if body.surface is not None:
        surface = body.surface
        under = surface.nearest(point)
        if (off := float(under.distance[0])) > _BESIDE * length:
            raise InputError(
                f"{where} is {with_unit(off, 'm', 2)} off the surface; give a point on it"
            )
        normals = surface.normal(under.face, under.uv)
        if np.abs(normals @ direction).min() > _OFF:
            raise InputError(
                f"{name} {plain(direction)} does not lie in the surface at point {plain(point)} m, "
                f"whose normal is {plain(normals[0])}: give one along the surface"
            )
        found = [surface.nearest(end) for end in ends]
        off = max(float(place.distance[0]) for place in found)
        places = np.stack([place.x[0] for place in found])
        if off > _BEYOND * length or np.abs((places - ends) @ direction).max() > _SHORTER * length:
            raise InputError(
                f"{where} along {name} {plain(direction)} reaches {with_unit(off, 'm', 2)} beyond "
                "the surface; give a shorter one, or move it from the edge"
            )
        ends = places
    along = ends[1] - ends[0]
    size = float(np.linalg.norm(along))
    if size == 0.0:
        raise InputError(f"{where}: both ends are one point of the surface")
    return ends, along / size
