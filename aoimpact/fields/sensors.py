"""Sensors on a body: motion, strain and stress of a place, gauges, filtered motion, reactions.

A sensor evaluates a function of the whole body's motion over time (`Response`) as a `History`,
whose error is estimated for that function.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    HUGE,
    PRINTED,
    ROUNDING,
    ArrayPair,
    FilePath,
    FloatArray,
    Found,
    InputError,
    IntArray,
    finite_array,
    plain,
    positive,
    sp,
    unit_vector,
    warn,
    with_unit,
)
from ..contact import motion_between, to_nodes
from ..fem import (
    FEModel,
    Layer,
    Strain,
    Stress,
    StressRows,
    VirtualMotion,
    body_stress_rows,
    checked_layer,
    compliances,
    selected_nodes,
)
from ..mesh import node_at, weights_at
from .channel import MOST_SAMPLES, Channel, filtered_acceleration
from .field import LOOKS, Field, solid, warn_if_wrong
from .response import Response, response_of

# Ratio of the estimated error to the difference from the run with other elements. With 2, 99 % of
# 458 histories on solids and shells had a smaller error than estimated, half of them eight times
# smaller. With 1, 88 % had a smaller error than estimated, and 57 % on 20-node hexahedra: if these
# are long, elements of the next degree reduce their error least.
_DIFFERENCES = 2.0

# Number of Gauss points along a gauge on a shell, for its mean strain.
_ALONG = 8

# For a gauge on a surface, in its lengths. _OFF: largest distance of its middle from the surface,
# and largest sine of its angle with it; _BEYOND: largest distance of an end from the surface;
# _SHORTER: largest shift of an end along the gauge when it is projected onto the surface,
# (length/radius)²/16 if the surface is curved.
_OFF, _BEYOND, _SHORTER = 0.1, 0.25, 0.01


T = TypeVar("T")

# Function of a source (`History.source`) and times, s, that returns values of shape (n, ...).
Seen = Callable[[Any, FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class History:
    """A quantity over time and its error, each computed when it is first read.

    Attributes
    ----------
    name : str
        Name of the quantity in messages.
    source : Response or Run
        Source of the values; the values of its `others` give the error.
    seen : callable
        Returns the values, shape (n, ...), of a source at times, s.
    t : ndarray, shape (n,)
        Times, s.
    displacement : callable, optional
        For a velocity: the function, like `seen`, that returns the displacement.
    """

    name: str
    source: Any
    seen: Seen = field(repr=False)
    t: FloatArray
    displacement: Seen | None = field(default=None, repr=False)

    @cached_property
    def values(self) -> FloatArray:
        """The values, shape (n, ...)."""
        return self.seen(self.source, self.t)

    @cached_property
    def error(self) -> FloatArray | None:
        """Error due to the body's model, relative to the largest value, (n,).

        The error is twice the sum of the differences from the runs with other elements, in the
        worst component; None for a full model.
        """
        if not self.source.others:
            return None
        looks = np.union1d(self.t, np.linspace(0.0, self.source.duration, LOOKS))
        own, least = self.seen(self.source, looks), 0.0
        if self.displacement is not None:  # smaller velocities are rounding errors
            most = float(np.abs(self.displacement(self.source, looks)).max())
            least = PRINTED * most / self.source.duration
        largest = np.nanmax(np.abs(own), initial=least)
        apart = sum(np.abs(self.values - self.seen(of, self.t)) for of in self.source.others)
        worst = np.reshape(apart, (len(self.t), -1)).max(axis=1)
        return np.asarray(_DIFFERENCES * worst / (largest if largest > 0.0 else 1.0))

    @property
    def doubt(self) -> FloatArray:
        """Bound of the values' error, with the sign of the largest difference; NaN if unknown."""
        apart = [self.seen(of, self.t) - self.values for of in self.source.others]
        if not apart:
            return np.full_like(self.values, np.nan)
        # Not the sum but the largest difference is taken: differences would cancel if other runs
        # lie on both sides of this run.
        return _DIFFERENCES * len(apart) * max(apart, key=lambda of: float(np.abs(of).max()))

    def told(self) -> FloatArray:
        """Return the values, and warn if they may be badly wrong."""
        warn_if_wrong(self.name, self.t, self.error)
        return self.values


@dataclass(frozen=True, eq=False)
class Sensed:
    """Several histories of one sensor.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times, s.
    points : ndarray
        Places of the sensor on the undeformed body, m.
    """

    t: FloatArray
    points: FloatArray
    _response: Response = field(repr=False)
    _histories: Mapping[str, History] = field(repr=False)

    @cached_property
    def error(self) -> Mapping[str, FloatArray]:
        """Errors due to the body's model, each relative to the largest value, shape (n,), by name.

        The names are "displacement", "velocity", "stress" and "strain" for a probe, "force" and
        "moment" for a reaction; the worst component counts. See `BodyResult.error`.
        A full model has no errors.
        """
        return errors_of(self._response, self._histories)


@dataclass(frozen=True, eq=False)
class SensedOnce:
    """The only history of a sensor; its error is computed when it is first read."""

    _history: History = field(repr=False)

    @property
    def t(self) -> FloatArray:
        """Times, s, shape (n,)."""
        return self._history.t

    @property
    def error(self) -> FloatArray | None:
        """Error due to the body's model, relative to the largest value, (n,).

        The error is twice the difference from the run with other elements; None for a full model.
        """
        return self._history.error


class Each(Generic[T]):
    """Base class of objects that prepare data, such as rows on the dofs, once for each body."""

    def __getstate__(self) -> dict[str, Any]:
        """Pickle without the prepared data."""
        return {one.name: vars(self)[one.name] for one in fields(self)}  # type: ignore[arg-type]

    @cached_property
    def of(self) -> Callable[[FEModel], T]:
        """Cached function that returns the data that `_make` prepares for a body."""
        return cache(self._make)

    def _make(self, body: FEModel) -> T:
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class At(Each[sp.csr_array]):
    """Motion at p places of a body along k axes; `of` returns rows on its dofs, (p k, n_dofs).

    Attributes
    ----------
    places, axes : ndarrays, shapes (p, 3), (k, 3)
        Coordinates, m, and unit vectors.
    shape : tuple of int
        Shape of the motion at one time.
    nodes : ndarray of int, shape (p,), optional
        Numbers of the nodes, if the places are nodes.
    """

    places: FloatArray
    axes: FloatArray
    shape: tuple[int, ...]
    nodes: IntArray | None = None

    def _make(self, body: FEModel) -> sp.csr_array:
        return motion_rows(body, place_rows(body, self.places, self.nodes), self.axes)

    def motion(self, response: Response, times: FloatArray, *, rates: bool = True) -> ArrayPair:
        """Return displacement, m, and velocity, m/s; without `rates`, less exact under contacts."""
        motion = response.functionals(self.of(response.body), times)
        added = response.half_space(self.places, times, rates=rates)
        u, v = (
            of.T.reshape(-1, *self.shape) + (more @ self.axes.T).reshape(-1, *self.shape)
            for of, more in zip(motion, added[:2], strict=True)
        )
        return u, v

    def displacement(self, response: Response, times: FloatArray) -> FloatArray:
        """Return the displacement, m."""
        return self.motion(response, times, rates=False)[0]

    def velocity(self, response: Response, times: FloatArray) -> FloatArray:
        """Return the velocity, m/s."""
        return self.motion(response, times)[1]

    def filtered(self, channel: Channel, response: Response, times: FloatArray) -> FloatArray:
        """Return the filtered acceleration, m/s²."""
        motion = partial(self.motion, response)
        return filtered_acceleration(motion, response.duration, channel, times)

    def elongation(self, response: Response, times: FloatArray) -> FloatArray:
        """Return the change of the distance between the two places, relative to that distance."""
        first, second = self.displacement(response, times).T
        return np.asarray((second - first) / np.linalg.norm(self.places[1] - self.places[0]))


@dataclass(frozen=True, eq=False)
class TensorAt(Each[tuple[StressRows, FloatArray]]):
    """Stress, Pa, or strain at places of a body, from its dofs and from half-spaces' fields.

    `of` returns the rows on the body's dofs, and the compliances, (p, 6, 6), 1/Pa, that turn the
    stress of half-spaces under contacts into strain; zero for shells, which have no half-spaces.

    Attributes
    ----------
    places : ndarray, shape (p, 3)
        Coordinates, m.
    layer : Layer
        Place within shells and beams.
    strain : bool, optional
        True to return strain instead of stress.
    nodes : ndarray of int, shape (p,), optional
        Numbers of the nodes, if the places are nodes.
    """

    places: FloatArray
    layer: Layer
    strain: bool = False
    nodes: IntArray | None = None

    def _make(self, body: FEModel) -> tuple[StressRows, FloatArray]:
        mesh, material = solid(body, "stress")
        weights = place_rows(body, self.places, self.nodes)[:, : mesh.n_nodes]
        found = body_stress_rows(body.shapes, material, weights, self.layer, strain=self.strain)
        if not found.known.all():
            raise InputError(
                f"{self.layer}: the body has no such place at the point (of a beam without "
                "orientation the sides are not known)"
            )
        near, by_stress = np.unique(weights.indices), np.zeros((len(self.places), 36))
        if not mesh.thin:
            of_nodes = compliances(mesh, material, near).reshape(-1, 36)
            by_stress = np.asarray(weights[:, near].toarray() @ of_nodes)
        return found.of_dofs(body.free), by_stress.reshape(-1, 6, 6)

    def __call__(self, response: Response, times: FloatArray) -> FloatArray:
        """Return the stress or strain of a response of the body, shape (times, p, 6)."""
        rows, by_stress = self.of(response.body)
        found = rows.components(response.functionals(rows.rows, times)[0])
        added = response.half_space(self.places, times, rates=False)[2]
        if self.strain:
            added = np.einsum("pij,tpj->tpi", by_stress, added)
        return found + added


@dataclass(frozen=True, eq=False)
class Filtered(SensedOnce):
    """Filtered acceleration over time.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times, s.
    channel : Channel
        The filter: its frequency class or corner, Hz.
    """

    channel: Channel

    @property
    def acceleration(self) -> FloatArray:
        """Acceleration, m/s², in the shape of `Probe.displacement`; warns if it may be wrong.

        The acceleration and its error are NaN over the filter's settling time before the end of the
        record; see `Probe.filtered`.
        """
        return self._history.told()


@dataclass(frozen=True, eq=False)
class Gauge(SensedOnce):
    """Strain of a gauge over time: the mean along its length.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times, s.
    ends : ndarray, shape (2, 3)
        Ends of the gauge on the undeformed body, m; on a shell, on the surface of its nodes.
    """

    ends: FloatArray

    @property
    def strain(self) -> FloatArray:
        """Strain, shape (n,), positive in tension; warns if it may be wrong, see `error`."""
        return self._history.told()


@dataclass(frozen=True, eq=False)
class Probe(Sensed):
    """Motion, strain and stress of one place of a body over time.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times, s.
    points : ndarray, shape (3,) or (p, 3)
        The place, or several, on the undeformed body, m.
    """

    _at: At = field(repr=False)

    @property
    def displacement(self) -> FloatArray:
        """Displacement, m, shape (n, p, 3).

        A single point has no axis p. If a direction was given, the displacement is along it, and
        the last axis is missing. Warns if it may be badly wrong; see `error`.
        """
        return self._histories["displacement"].told()

    @property
    def velocity(self) -> FloatArray:
        """Velocity, m/s, in the shape of `displacement`."""
        return self._histories["velocity"].told()

    @property
    def doubt(self) -> FloatArray:
        """Bound of the error of `velocity`, m/s, with the sign of the largest difference.

        :meta private:
        """
        return self._histories["velocity"].doubt

    @cached_property
    def acceleration(self) -> FloatArray:
        """Unfiltered acceleration of the body's model, m/s², in the shape of `displacement`.

        The acceleration is computed by central differences of the velocity over a thousandth of the
        shortest contact, or over two fixed steps.

        Warns
        -----
        AOImpactWarning
            Always: the acceleration has no finite bandwidth and no error estimate, since an impact
            excites modes up to any frequency with the same acceleration. `filtered` converges.
        """
        warn(
            "acceleration after an impact grows with the number of modes, and has no error; take "
            "probe.filtered(cfc=1000), or quantity=AccelerationAt(point, direction, cfc=1000)"
        )
        response, apart = self._response, self._response.motion.resolution
        after = np.minimum(self.t + apart, response.duration)
        before = np.maximum(self.t - apart, 0.0)
        change = self._at.velocity(response, after) - self._at.velocity(response, before)
        return np.asarray((change.T / (after - before)).T)

    def filtered(self, cfc: float | None = None, *, corner: float | None = None) -> Filtered:
        """Return the filtered acceleration.

        SAE J211-1, appendix C: a Butterworth filter of two poles, run forward and backward for zero
        phase shift. Before the record the body is at rest or moves steadily. The motion after the
        record is not known, so that the acceleration is NaN over the filter's settling time before
        the end, one period of the class: 1 ms for CFC 1000. Take a `duration` that is longer by
        this time.

        Parameters
        ----------
        cfc : float, optional
            Channel frequency class, Hz: 60, 180, 600 or 1000 in the standard; any other by the same
            formula. The filter attenuates by 3 dB at 1.65 times the class.
        corner : float, optional
            In place of the class, the frequency at which the filter attenuates by 3 dB, Hz.

        Raises
        ------
        InputError
            If neither or both are given, or the record is shorter than the settling time.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(mass=0.01), ao.antioscillators(tip, 4), velocity=0.1,
        ...     law=ao.Linear(k=1e5), duration=2e-3)
        >>> probe = hit.target.probe((0.05, 0.005, 0.0), (0, 0, 1), dt=1e-5)
        >>> probe.filtered(cfc=1000).acceleration.shape == probe.t.shape
        True
        """
        channel = Channel(cfc=cfc, corner=corner)
        seen = partial(self._at.filtered, channel)
        history = History("filtered acceleration", self._response, seen, self.t)
        _ = history.values  # refuses a record that is too short
        return Filtered(history, channel)

    def _tensor(self, name: str) -> FloatArray:
        solid(self._response.body, name)  # refuses bodies without elements and material
        return self._histories[name].told().reshape(len(self.t), *self.points.shape[:-1], 6)

    @property
    def stress(self) -> Stress:
        """The stress over time, of shape (n, p, 6), or (n, 6) for a single point.

        The stress is averaged at the nodes as in `Field.stress`, and interpolated between them by
        the elements' shape functions.

        Raises
        ------
        InputError
            If the body has no elements and material: it was given by K and M.
        """
        return Stress(self._tensor("stress"), self.points)

    @property
    def strain(self) -> Strain:
        """The strain tensor over time, in the shape of `stress`; shear components are γ/2.

        Raises
        ------
        InputError
            If the body has no elements and material: it was given by K and M.
        """
        return Strain(self._tensor("strain"), self.points)


@dataclass(frozen=True, eq=False)
class Reaction(Sensed):
    """The force of supports and springs on a body over time.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times, s.
    centre : ndarray, shape (3,)
        Mean of the points, m.
    points : ndarray, shape (p, 3)
        Coordinates of the held nodes, m.
    """

    centre: FloatArray
    _nodes: IntArray = field(repr=False)

    @property
    def force(self) -> FloatArray:
        """Force on the body, N, shape (n, 3); warns if it may be badly wrong, see `error`."""
        return self._histories["force"].told()

    @property
    def moment(self) -> FloatArray:
        """Moment on the body about the `centre`, N m, shape (n, 3)."""
        return self._histories["moment"].told()

    @cached_property
    def nodal_force(self) -> FloatArray:
        """Forces on the nodes, N, shape (n, p, 3); they add up to `force`.

        The computation takes three static solutions of the body per node.
        """
        ways = np.eye(6)[:, :3]
        each = (Work(self._nodes[[i]], place, ways) for i, place in enumerate(self.points))
        return np.stack([work(self._response, self.t) for work in each], axis=1)


@dataclass(frozen=True, eq=False)
class Work(Each[VirtualMotion]):
    """Virtual work of the ground's forces on some nodes, per unit of each of k virtual motions.

    The work is in N for a translation and in N m for a rotation. A call returns it with the shape
    (n_times, k).

    Attributes
    ----------
    nodes : ndarray of int
    centre : ndarray, shape (3,)
        Centre of rotation, m.
    ways : ndarray, shape (6, k)
        The motions, as columns: translation, and rotation about the centre.
    """

    nodes: IntArray
    centre: FloatArray
    ways: FloatArray

    def _make(self, body: FEModel) -> VirtualMotion:
        grounding = body.grounding
        return grounding.virtual(grounding.resultants(self.nodes, self.centre) @ self.ways)

    def __call__(self, response: Response, times: FloatArray) -> FloatArray:
        """Return the virtual work of the ground's forces in a response of the body."""
        return response.work(times, self.of(response.body))


def gauge_strain(body: FEModel, ends: FloatArray, along: FloatArray, layer: Layer) -> Any:
    """Return the function of a response and times, s, that returns the strain between two ends.

    On a shell, the strain is the mean along the gauge on a layer; on solids, it is the relative
    change of the ends' distance.
    """
    if body.mesh is None or not body.mesh.thin:
        gauge = At(ends, along[None], (2,))
        gauge.of(body)  # checks the ends
        return gauge.elongation
    x, w = np.polynomial.legendre.leggauss(_ALONG)
    places = ends[0] + np.outer(0.5 + 0.5 * x, ends[1] - ends[0])
    tensor = TensorAt(places, layer, strain=True)
    if not tensor.of(body)[0].linear:
        raise InputError(
            "a gauge sits on a surface, and beams have only an axis; take the strain of a side, "
            "probe(point, layer=, part=).strain"
        )
    component = Strain(np.eye(6), places).along(along)
    return partial(_mean_strain, tensor, np.asarray(np.kron(0.5 * w, component)))


def _mean_strain(
    tensor: TensorAt, mean: FloatArray, response: Response, times: FloatArray
) -> FloatArray:
    return tensor(response, times).reshape(len(times), -1) @ mean


def acceleration_of(point: FloatArray, axis: FloatArray, channel: Channel) -> Any:
    """Return the function of a response and times, s, for a point's filtered acceleration."""
    return partial(At(point[None], axis[None], ()).filtered, channel)


def errors_of(source: Any, histories: Mapping[str, History]) -> Mapping[str, FloatArray]:
    """Return the errors of histories by name; none for a full model."""
    if not source.others:
        return {}
    return Found(lambda: histories, lambda name: histories[name].error)


def gauge_ends(
    body: FEModel, point: FloatArray, direction: FloatArray, length: float, name: str = "direction"
) -> ArrayPair:
    """Return both ends of a gauge, shape (2, 3), m, and the unit vector from one to the other.

    The ends lie on the surface, and the strain is that of the chord between them. On a curved
    surface the strain of the chord differs from the mean along the arc by (length/radius)²/24.
    """
    if body.nodes is None:
        raise InputError(
            "this body has no nodes, between which a gauge measures: give nodes= with K and M"
        )
    point = to_nodes(body, point)
    where = f"the gauge of length={with_unit(length, 'm')} at point {plain(point)} m"
    extent = float(np.ptp(body.nodes, axis=0).max())
    if not ROUNDING * extent < length <= extent:
        raise InputError(f"{where}: give a length, in metres, up to the body's {extent:.3g}")
    ends = point + 0.5 * length * np.outer([-1.0, 1.0], direction)
    if body.surface is not None:
        surface = body.surface
        under = surface.nearest(point)
        if (off := float(under.distance[0])) > _OFF * length:
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
    return ends, along / np.linalg.norm(along)


def place_rows(body: FEModel, places: FloatArray, nodes: IntArray | None = None) -> sp.csr_array:
    """Return the weights of a body's nodes at places (p, 3), m, shape (p, n_nodes).

    `nodes`: numbers of the nodes, if the places are nodes.
    """
    if nodes is not None:
        return sp.eye_array(len(body.nodes), format="csr")[nodes]
    weights = sp.lil_array((len(places), len(body.nodes)))
    for i, place in enumerate(places):
        if body.mesh is None:
            weights[i, node_at(body.nodes, place)] = 1.0
        else:
            where, shares = weights_at(body.mesh, to_nodes(body, place), body.shapes)
            weights[i, where] = shares
    return weights.tocsr()


def motion_rows(body: FEModel, weights: sp.csr_array, axes: FloatArray) -> sp.csr_array:
    """Return rows (p k, n_dofs) of the motion along axes (k, 3), from nodes' weights at places."""
    rows = sp.csr_array(sp.kron(weights, axes))
    if body.mesh is None or not body.mesh.thin:
        return rows[:, body.free]
    n, own = rows.shape[1], np.arange(len(axes))
    rows.resize((rows.shape[0], 2 * n))  # rotations displace places between nodes, not nodes
    rows = rows.tolil()
    for place in np.flatnonzero(np.diff(weights.indptr) > 1):
        held = slice(*weights.indptr[place : place + 2])
        known = motion_between(body, weights.indices[held], weights.data[held])
        if known is not None:
            nodes, motion = known
            dofs = 3 * nodes[:, None, None] + np.array([[0], [n]]) + np.arange(3)
            at = np.ix_(place * len(axes) + own, dofs.ravel())
            rows[at] = np.tensordot(axes, motion, 1).reshape(len(axes), -1)
    return rows.tocsr()[:, body.free]


class Measured:
    """A body of a run, with methods for its sensors and its whole field."""

    label: str
    _run: Any
    _number: int  # number of the body in the run

    @cached_property
    def _responding(self) -> Response:
        response = response_of(self._run, self._number)
        if response is None:
            raise InputError(
                f"the body {self.label!r} was given by numbers and has no finite elements: give "
                "tip = FEModel.from_mesh(...).contact(...), or a model of it"
            )
        return response

    def probe(
        self,
        point: ArrayLike | None = None,
        direction: ArrayLike | None = None,
        *,
        nodes: Any = None,
        times: ArrayLike | None = None,
        dt: float | None = None,
        layer: Any = None,
        part: str | None = None,
    ) -> Probe:
        """Return motion, strain and stress of a point or of a set of nodes over time.

        Parameters
        ----------
        point : array_like, shape (3,) or (p, 3), optional
            Coordinates in the undeformed body, m; anywhere in it or on its surface.
        direction : array_like, shape (3,), optional
            Direction of the measured motion, any length but zero; all three components if left out.
        nodes : str, callable or array_like, optional
            In place of `point`: the name of a node set, a function of all coordinates that returns
            one bool for each, or numbers: labels if the body's nodes have labels, else from 0.
        times : array_like, optional
            Times, s, ascending, within the record; those of the result if left out.
        dt : float, optional
            In place of `times`: step of even times from 0 on, s, as spectra and filters need.
        layer, part : optional
            Place within shells and beams, and group of elements, of stress and strain; see
            `Field.stress`.

        Raises
        ------
        InputError
            If the point is off the body, no node is selected, a time is outside the record, or the
            model was given by numbers.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(0.01), ao.antioscillators(tip, 4), 0.1, law=ao.Linear(k=1e5))
        >>> probe = hit.target.probe((0.05, 0.005, 0.0))
        >>> probe.stress["xx"].shape == probe.t.shape
        True
        """
        where, (response, wanted, body) = checked_layer(layer, part), self._sensed(times, dt)
        if (point is None) == (nodes is None):
            raise InputError("probe needs either point or nodes, and not both")
        _ = response.free
        chosen = None
        if nodes is not None:
            sets = {} if body.mesh is None else body.mesh.node_sets
            chosen = selected_nodes("nodes", nodes, body.nodes, sets, body.node_labels)
            places = body.nodes[chosen]
        else:
            places = finite_array("point", point, unit="m", most=HUGE)
            if places.shape[-1:] != (3,) or places.ndim > 2 or places.size == 0:
                raise InputError(f"point must have shape (3,) or (p, 3), got {places.shape}")
        axes = np.eye(3) if direction is None else unit_vector("direction", direction)[None]
        shape = places.shape if direction is None else places.shape[:-1]
        at = At(np.atleast_2d(places), axes, shape, chosen)
        at.of(response.body)  # checks the places
        tensor = partial(TensorAt, at.places, where, nodes=chosen)
        history = partial(History, source=response, t=wanted)
        histories: list[History] = [
            history("displacement", seen=at.displacement),
            history("velocity", seen=at.velocity, displacement=at.displacement),
        ]
        if body.material is not None:
            histories += [
                history("stress", seen=tensor(strain=False)),
                history("strain", seen=tensor(strain=True)),
            ]
        return Probe(wanted, places, response, {of.name: of for of in histories}, at)

    def gauge(
        self,
        point: ArrayLike,
        direction: ArrayLike,
        length: float,
        *,
        times: ArrayLike | None = None,
        dt: float | None = None,
        layer: Any = None,
        part: str | None = None,
    ) -> Gauge:
        """Return the strain of a gauge on the surface over time, the mean along its length.

        Parameters
        ----------
        point : array_like, shape (3,)
            Middle of the gauge on the undeformed body, m.
        direction : array_like, shape (3,)
            Direction of the gauge along the surface, any length but zero.
        length : float
            Length of the gauge, m.
        times, dt
            As in `probe`.
        layer, part : optional
            Face of a shell, "top" or "bottom", and group of elements; see `Field.stress`.

        Raises
        ------
        InputError
            If the gauge does not lie on the surface, a time is outside the record, or the model was
            given by numbers.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(0.01), ao.antioscillators(tip, 4), 0.1, law=ao.Linear(k=1e5))
        >>> gauge = hit.target.gauge((0.02, 0.005, 0.0), (1, 0, 0), length=3e-3)
        >>> gauge.strain.shape == hit.t.shape
        True
        """
        response, wanted, body = self._sensed(times, dt)
        size, way = positive("length", length, unit="m"), unit_vector("direction", direction)
        where = finite_array("point", point, shape=(3,), unit="m", most=HUGE)
        ends, along = gauge_ends(body, where, way, size)
        seen = gauge_strain(body, ends, along, checked_layer(layer, part))
        return Gauge(History("strain of a gauge", response, seen, wanted), ends)

    def reaction(
        self,
        nodes: Any = None,
        *,
        times: ArrayLike | None = None,
        dt: float | None = None,
    ) -> Reaction:
        """Return the force of supports and springs on the body over time.

        The reaction has the total force on the held nodes, its moment about their mean place, and
        the force on each node. Up to rounding, the sum of all reactions, contact forces and weight
        is the rate of the body's momentum p plus the drag α p of `Rayleigh` damping, an external
        force that is no reaction.

        Parameters
        ----------
        nodes : str, callable or array_like, optional
            As in `probe`, such as the name of a set in `fixed` or `springs`; by default all held
            nodes.
        times, dt
            As in `probe`.

        Raises
        ------
        InputError
            If none of the nodes is held, a time is outside the record, or the body was not made
            from a mesh.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(0.01), ao.antioscillators(tip, 4), 0.1, law=ao.Linear(k=1e5))
        >>> hit.target.reaction("xmin").force.shape == (len(hit.t), 3)
        True
        """
        response, wanted, body = self._sensed(times, dt)
        held = body.grounding.nodes("nodes", nodes)
        points = body.nodes[held]
        centre = points.mean(axis=0)
        force, moment = (Work(held, centre, ways) for ways in np.hsplit(np.eye(6), 2))
        histories = {
            "force": History("reaction", response, force, wanted),
            "moment": History("moment of the reaction", response, moment, wanted),
        }
        return Reaction(wanted, points, response, histories, centre, held)

    def _sensed(self, times: Any, dt: float | None) -> tuple[Response, FloatArray, FEModel]:
        """Return the response, the times that are asked for, s, and the body as it was given."""
        response = self._responding
        if dt is None:
            wanted = response.within(self._run.t if times is None else times)
            return response, wanted, response.body.given
        if times is not None:
            raise InputError("give either times or dt, not both")
        end, step = float(self._run.t[-1]), positive("dt", dt, unit="s")
        if not end / MOST_SAMPLES <= step <= end:
            raise InputError(
                f"dt={step:g} s must be from {end / MOST_SAMPLES:.2g} s to the record's {end:g} s"
            )
        count = math.floor(end / step * (1.0 + 1e-12)) + 1
        return response, np.minimum(step * np.arange(count), end), response.body.given

    def field(self, times: ArrayLike | None = None) -> Field:
        """Return the whole body at some times: displacement, velocity, stress, files, a picture.

        Parameters
        ----------
        times : float or array_like, optional
            Times, s, ascending, within the record; that of the largest force if left out.

        Raises
        ------
        InputError
            If a time is outside the record, or the model was given by numbers.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(0.01), ao.antioscillators(tip, 4), 0.1, law=ao.Linear(k=1e5))
        >>> hit.target.field([1e-4]).displacement.shape == (1, len(bar.nodes), 3)
        True
        """
        return self._responding.field(times)

    def to_vtu(self, path: FilePath, times: ArrayLike | None = None) -> Path:
        """Write the body at some times for ParaView; see `field` and `Field.to_vtu`.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(0.01), ao.antioscillators(tip, 4), 0.1, law=ao.Linear(k=1e5))
        >>> hit.target.to_vtu(folder / "bar", times=[1e-4]).name
        'bar.pvd'
        """
        return self.field(times).to_vtu(path)
