"""The response of a whole body in a run, from its recorded coordinates and the force on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import HUGE, FloatArray, InputError, IntArray, finite_array, unit_vector
from ..fem import (
    Damping,
    FEModel,
    Layer,
    Strain,
    StressRows,
    VirtualMotion,
    body_stress_rows,
    compliances,
    motion_between,
    selected_nodes,
    to_nodes,
)
from ..integrate import Motion
from ..mesh import node_at, weights_at
from ..reduction import Recovery
from .channel import Channel, filtered_acceleration
from .fields import At, Field, Filtered, Probe, solid
from .gauge import Gauge, gauge_ends
from .historyerror import relative_error, rest
from .indentation import Indentation
from .reaction import Held, Reaction

# s ↦ rows (K + s²M)⁻¹, of the rows that are asked for.
Dual = Callable[[float], FloatArray]

# Places along a gauge on a shell at which its strain is taken.
_ALONG = 8

# The error of a sensor is so many times the difference to a finer model, whose own error is taken
# to be half as large: 98 % of them are then within it, see tools/sensor_errors.py.
_DIFFERENCES = 2.0

# Times of the record at which the largest motion is looked for.
_LOOKS = 200


def times_within(times: Any, end: float) -> FloatArray:
    """Return ascending times within a record, s, shape (n,), which may be its end to rounding."""
    wanted = np.atleast_1d(finite_array("times", times, unit="s"))
    if wanted.ndim != 1:
        raise InputError(f"times must be a flat list, got shape {wanted.shape}; ravel it")
    falls = np.flatnonzero(np.diff(wanted) < 0.0)
    if len(falls):
        before, after = wanted[falls[0] : falls[0] + 2]
        raise InputError(f"times must ascend, got {before:g} s before {after:g} s; sort them")
    if wanted.size and (wanted[0] < 0.0 or wanted[-1] > end * (1.0 + 1e-12)):
        raise InputError(
            f"times must lie within the record, 0 to {end:g} s, got {wanted[0]:g} to "
            f"{wanted[-1]:g} s; take a longer duration"
        )
    return wanted


def stress_rows_at(body: FEModel, point: FloatArray, layer: Layer) -> StressRows:
    """Return the stress at a point of a body by its dofs."""
    solid(body, "stress")
    assert body.free is not None
    return _stress_rows(body, place_rows(body, point[None]), body.free, layer)


def strain_rows_at(body: FEModel, point: FloatArray, layer: Layer) -> tuple[StressRows, FloatArray]:
    """Return the strain at a point by a body's dofs, and by stress, 1/Pa, (6, 6)."""
    assert body.free is not None
    weights = place_rows(body, point[None])
    rows = _stress_rows(body, weights, body.free, layer, strain=True)
    return rows, _compliance(body, weights)[0]


def shell_gauge_rows(
    body: FEModel, ends: FloatArray, along: FloatArray, layer: Layer
) -> sp.csr_array | None:
    """Return the strain of a gauge on a layer of a shell by a body's dofs, (1, n_dofs).

    It is the mean along the gauge. None of a body of solids, whose gauge is the change of distance
    between its ends.
    """
    assert body.free is not None
    if body.mesh is None or not body.mesh.thin:
        return None
    x, w = np.polynomial.legendre.leggauss(_ALONG)
    places = ends[0] + np.outer(0.5 + 0.5 * x, ends[1] - ends[0])
    rows = _stress_rows(body, place_rows(body, places), body.free, layer, strain=True)
    if not rows.linear:
        raise InputError(
            "a gauge sits on a surface, and beams have only an axis; take the strain of a side, "
            "probe(point, layer=, part=).strain"
        )
    component = Strain(np.eye(6), places).along(along)
    return sp.csr_array(sp.kron(0.5 * w[None], component[None]) @ rows.rows)


def place_rows(body: FEModel, places: FloatArray) -> sp.csr_array:
    """Return the nodes' weights at places (p, 3), m, of a body, shape (p, n_nodes)."""
    assert body.nodes is not None
    weights = sp.lil_array((len(places), len(body.nodes)))
    for i, place in enumerate(places):
        if body.mesh is None:
            weights[i, node_at(body.nodes, place)] = 1.0
        else:
            where, shares = weights_at(body.mesh, to_nodes(body, place))
            weights[i, where] = shares
    return weights.tocsr()


def _stress_rows(
    body: FEModel,
    weights: sp.csr_array,
    free: IntArray,
    layer: Layer,
    *,
    strain: bool = False,
) -> StressRows:
    """The stress, or strain, at places with the nodes' `weights`, shape (p, n_nodes)."""
    mesh, material = solid(body, "stress")
    rows = body_stress_rows(mesh, material, weights, layer, strain=strain)
    if not rows.known.all():
        raise InputError(
            f"{layer}: the body has no such place at the point (of a beam without orientation the "
            "sides are not known)"
        )
    return rows.of_dofs(free)


def _compliance(body: FEModel, weights: sp.csr_array) -> FloatArray:
    """Strain by stress at places with the nodes' `weights`, 1/Pa, shape (p, 6, 6)."""
    mesh, material = solid(body, "strain")
    if mesh.thin:  # under whose contacts there is no half-space
        return np.zeros((weights.shape[0], 6, 6))
    near = np.unique(weights.indices)
    found: FloatArray = weights[:, near].toarray() @ compliances(mesh, material, near).reshape(
        -1, 36
    )
    return found.reshape(-1, 6, 6)


def motion_rows(body: FEModel, weights: sp.csr_array, axes: FloatArray) -> sp.csr_array:
    """Return the motion along axes (k, 3) at places with the nodes' weights, (p k, n_dofs)."""
    assert body.free is not None
    rows = sp.csr_array(sp.kron(weights, axes))
    if body.mesh is None or not body.mesh.thin:
        return rows[:, body.free]
    n, own = rows.shape[1], np.arange(len(axes))
    rows.resize((rows.shape[0], 2 * n))  # rotations move no node, but places between nodes
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


def _filtered(
    at: At, channel: Channel, duration: float, response: Response, times: FloatArray
) -> FloatArray:
    """Acceleration behind a filter, shape (p k, times)."""
    motion = partial(response.motion_at, *at)
    return filtered_acceleration(motion, duration, channel, times).T


def _shell_gauge_strain(rows: sp.csr_array, response: Response, times: FloatArray) -> FloatArray:
    """Strain of a gauge on a shell, shape (times,)."""
    found: FloatArray = response.functionals(rows, times)[0]
    return found


def _gauge_strain(at: At, response: Response, times: FloatArray) -> FloatArray:
    """Elongation between two places over their distance, shape (times,)."""
    first, second = response.motion_at(*at, times, rates=False)[0].T
    return np.asarray((second - first) / np.linalg.norm(at.places[1] - at.places[0]))


def _work(moved: VirtualMotion, part: slice, response: Response, times: FloatArray) -> FloatArray:
    """Some components of a reaction, shape (3, times)."""
    return response.held.work(moved, times)[part]


@dataclass(frozen=True, eq=False)
class Response:
    """A whole body at any time of a run.

    Attributes
    ----------
    body : FEModel
    motion : Motion
        Of the body's own dofs, or of its reduced model's coordinates.
    recovery : Recovery or None
        From the reduced model's coordinates to the dofs; None where `motion` has these.
    peak_time : float
        When the largest force acts, s.
    static_deflection : ndarray, shape (n_dofs,), or None
        The part of the deflection at rest under load that `recovery` misses, m.
    finer : callable, optional
        Returns the response in the run with finer models; None where there is none.
    indentations : tuple of Indentation
        The half-space's fields at its contacts, in place of what the mesh makes of them.
    damping : Damping or None
        That of the body's model.
    gravity : ndarray, shape (3,)
        m/s².
    """

    body: FEModel
    motion: Motion
    recovery: Recovery | None
    peak_time: float
    static_deflection: FloatArray | None = None
    finer: Callable[[], Response | None] | None = field(default=None, repr=False)
    indentations: tuple[Indentation, ...] = ()
    damping: Damping | None = None
    gravity: FloatArray = field(default_factory=lambda: np.zeros(3))

    def probe(
        self,
        point: Any,
        direction: Any,
        nodes: Any,
        times: Any,
        follows: Callable[[], bool],
        layer: Layer,
    ) -> Probe:
        """See `BodyResult.probe`; follows() is true if displacements are known to be right."""
        wanted = self._times(times)
        places, weights = self._places(point, nodes)
        axes = np.eye(3) if direction is None else unit_vector("direction", direction)[None]
        along = () if direction is not None else (3,)
        rows = motion_rows(self.body, weights, axes)
        at, shape = At(np.atleast_2d(places), axes, rows), (-1, *places.shape[:-1], *along)
        u, v = (of.reshape(shape) for of in self.motion_at(*at, wanted))
        return Probe(wanted, places, u, v, follows, self, at, weights, layer)

    def acceleration(self, at: At, times: FloatArray) -> FloatArray:
        """Return the acceleration at places, by central differences, m/s², (times, p k)."""
        step, end = self.motion.resolution, self.motion.duration
        after, before = np.minimum(times + step, end), np.maximum(times - step, 0.0)
        change = self.motion_at(*at, after)[1] - self.motion_at(*at, before)[1]
        return np.asarray(change / (after - before)[:, None])

    def filtered(
        self, at: At, times: FloatArray, shape: tuple[int, ...], channel: Channel
    ) -> Filtered:
        """Return the acceleration at places behind a filter, in that shape."""
        rate = partial(_filtered, at, channel, self.motion.duration)
        error = partial(self._compared_with, rate, times)
        return Filtered(times, channel, rate(self, times).T.reshape(shape), _error=error)

    def motion_at(
        self,
        places: FloatArray,
        axes: FloatArray,
        rows: Any,
        times: FloatArray,
        dual: Dual | None = None,
        *,
        rates: bool = True,
    ) -> tuple[FloatArray, FloatArray]:
        """Return displacement and velocity at places (p, 3) along axes (k, 3), (times, p k).

        rows: of the dofs, shape (p k, n_dofs), by `place_rows` and the axes. Without `rates` the
        velocity lacks the half-space's.
        """
        u, v = (values.T for values in self._functionals(rows, times, dual))
        added = self._half_space(places, times, rates=rates)
        if added is None:
            return u, v
        return (
            u + (added[0] @ axes.T).reshape(u.shape),
            v + (added[1] @ axes.T).reshape(v.shape),
        )

    def gauge(self, point: Any, direction: Any, length: float, times: Any, layer: Layer) -> Gauge:
        """See `BodyResult.gauge`."""
        wanted = self._times(times)
        place = finite_array("point", point, shape=(3,), unit="m", most=HUGE)
        along = unit_vector("direction", direction)
        ends, along = gauge_ends(self.body, place, along, length)
        axes = along[None]
        of_shell = shell_gauge_rows(self.body, ends, along, layer)
        if of_shell is None:
            rows = motion_rows(self.body, place_rows(self.body, ends), axes)
            strain = partial(_gauge_strain, At(ends, axes, rows))
        else:
            strain = partial(_shell_gauge_strain, of_shell)
        error = partial(self._compared_with, strain, wanted)
        return Gauge(wanted, ends, strain(self, wanted), _error=error)

    def reaction(self, nodes: Any, times: Any) -> Reaction:
        """See `BodyResult.reaction`."""
        wanted = self._times(times)
        grounding = self.body.grounding
        held = grounding.nodes("nodes", nodes)
        assert self.body.nodes is not None
        points = self.body.nodes[held]
        centre = points.mean(axis=0)
        moved = grounding.virtual(grounding.resultants(held, centre))

        return Reaction(
            wanted,
            centre,
            points,
            self.held.work(moved, wanted).T,
            partial(self.held.at_nodes, held, wanted),
            partial(self._reaction_errors, moved, wanted),
        )

    def _reaction_errors(self, moved: VirtualMotion, times: FloatArray) -> dict[str, FloatArray]:
        parts = {"force": slice(None, 3), "moment": slice(3, None)}
        errors = {
            name: self._compared_with(partial(_work, moved, part), times)
            for name, part in parts.items()
        }
        return {name: error for name, error in errors.items() if error is not None}

    @property
    def held(self) -> Held:
        """The body as it is held, for the forces of its supports."""
        return Held(self.body.grounding, self.motion, self.recovery, self.damping, self.gravity)

    def _compared_with(
        self, history: Callable[[Response, FloatArray], FloatArray], times: FloatArray
    ) -> FloatArray | None:
        """Relative error of a history by the finer response, (times,); None without it."""
        if (finer := self._finer) is None:
            return None
        looks = np.union1d(times, self._looks)
        right = history(finer, looks)
        same = right[..., np.searchsorted(looks, times)]
        return _DIFFERENCES * relative_error(history(self, times), same, right)

    def field(self, times: Any = None) -> Field:
        """See `BodyResult.field`."""
        wanted = self._times(self.peak_time if times is None else times)
        u, v = self.motion.observed(None, wanted)
        if self.recovery is not None:
            u = self.recovery.displacement(u, self.motion.force(wanted))
            v = self.recovery.displacement(v, self.motion.force_rate(wanted))
        u, v = self._completed(None, u, v, wanted)
        moved, speeds = self._at_nodes(u), self._at_nodes(v)
        error = partial(self._error, wanted)
        if self._rotates:
            turned = self._at_nodes(u, rotations=True)
            return Field(self.body, wanted, moved, speeds, _rotation=turned, _error=error)
        if not self.indentations:
            return Field(self.body, wanted, moved, speeds, _error=error)
        assert self.body.nodes is not None
        added = self._half_space(self.body.nodes, wanted)
        assert added is not None
        whole, stress = (
            (moved + added[0], speeds + added[1]),
            partial(self.half_space_stress, wanted),
        )
        return Field(self.body, wanted, *whole, moved, stress, _error=error)

    def half_space_stress(self, times: FloatArray, places: FloatArray) -> FloatArray:
        """Return what contacts add to the elements' stress at places (p, 3), (times, p, 6)."""
        added = self._half_space(places, times, rates=False)
        return np.zeros((len(times), len(places), 6)) if added is None else added[2]

    def _half_space(
        self, places: FloatArray, times: FloatArray, *, rates: bool = True
    ) -> tuple[FloatArray, FloatArray, FloatArray] | None:
        """The half-space's displacement, its rate and stress at places; None without contacts.

        Without the rates, which take twice as long, zeros.
        """
        if not self.indentations:
            return None
        forces = self.motion.force(times)
        changes = self.motion.force_rate(times) if rates else np.zeros_like(forces)
        fields = []
        for of in self.indentations:
            force, rate = of.pressing(forces), of.inward * changes[of.port]
            u, stress = of.at(places, force)
            v = of.rate(places, force, rate) if rates else np.zeros_like(u)
            fields.append((u, v, stress))
        u, v, stress = (np.sum(parts, axis=0) for parts in zip(*fields, strict=True))
        return u, v, stress

    def displacement_of(self, functional: FloatArray, times: FloatArray) -> FloatArray:
        """Return functionalᵀX by the model's own shapes, without what recovery adds to them.

        Parameters
        ----------
        functional : ndarray, shape (n_dofs,)
        times : ndarray, shape (k,)
            s.
        """
        row = functional if self.recovery is None else self.recovery.model.seen(functional)
        return np.asarray(self.motion.observed(row[None], times)[0][0])

    def errors(self, rows: Any, times: FloatArray) -> dict[str, FloatArray]:
        """Return relative errors of rows @ X, its rate and the stress anywhere, each (times,)."""
        if (finer := self._finer) is None:
            return {}
        looks = np.union1d(times, self._looks)
        right, at = finer._functionals(rows, looks), np.searchsorted(looks, times)
        least = 0.0, rest(right[0], self.motion.duration)
        u, v = (
            relative_error(ours, theirs[:, at], theirs, slowest)
            for ours, theirs, slowest in zip(
                self._functionals(rows, times), right, least, strict=True
            )
        )
        error = self._error(times)
        found = {"displacement": u, "velocity": v}
        return found if error is None else found | {"stress": error, "strain": error}

    def _error(self, times: FloatArray) -> FloatArray | None:
        """Relative error of the field at `times` in the norm of strain energy; None if unknown."""
        if (finer := self._finer) is None:
            return None
        ours, theirs = self._shapes, finer._shapes
        shapes, n = np.hstack([ours, theirs]), ours.shape[1]
        product = shapes.T @ (self.body.K @ shapes)
        apart = np.vstack([self._amounts(times), -finer._amounts(times)])
        looks = finer._amounts(np.union1d(times, self._looks))
        largest = _energy(product[n:, n:], looks).max(initial=0.0)
        return np.sqrt(_energy(product, apart) / (largest if largest > 0.0 else 1.0))

    @cached_property
    def _finer(self) -> Response | None:
        return None if self.finer is None or self.recovery is None else self.finer()

    @property
    def _looks(self) -> FloatArray:
        return np.linspace(0.0, self.motion.duration, _LOOKS)

    @cached_property
    def _shapes(self) -> FloatArray:
        """The shapes that deform the body, (n_dofs, k)."""
        assert self.recovery is not None
        at_rest = [] if self.static_deflection is None else [self.static_deflection[:, None]]
        return np.hstack([self.recovery.basis, self.recovery.shapes, *at_rest])

    def _amounts(self, times: FloatArray) -> FloatArray:
        """How much of each of the `_shapes` there is, (k, times)."""
        assert self.recovery is not None
        coordinates = self.motion.observed(None, times)[0]
        forces = self.motion.force(times)
        added = self.recovery.amounts(coordinates, forces)
        at_rest = [] if self.static_deflection is None else [np.ones((1, len(times)))]
        return np.vstack([coordinates, forces, added, *at_rest])

    @cached_property
    def _free(self) -> IntArray:
        if self.body.free is None:
            raise InputError(
                "the body has no nodes, so no place on it has coordinates: make it with "
                "FEModel.from_mesh(...) or FEModel(K=, M=, nodes=)"
            )
        return self.body.free

    def _times(self, times: Any) -> FloatArray:
        wanted = times_within(times, self.motion.duration)
        if not wanted.size:
            raise InputError("times must have at least one, got none")
        return wanted

    def stress(
        self, weights: sp.csr_array, times: FloatArray, layer: Layer, *, strain: bool = False
    ) -> FloatArray:
        """Return stress or strain at places with the nodes' `weights`, shape (times, p, 6)."""
        rows = _stress_rows(self.body, weights, self._free, layer, strain=strain)
        found = rows.components(self._functionals(rows.rows, times)[0])
        assert self.body.nodes is not None
        added = self.half_space_stress(times, weights @ self.body.nodes)
        if strain:
            added = np.einsum("pij,tpj->tpi", _compliance(self.body, weights), added)
        return np.asarray(found + added)

    def functionals(self, rows: Any, times: FloatArray, dual: Dual | None = None) -> FloatArray:
        """Return rows @ X for `rows` of shape (p, n_dofs), shape (p, times)."""
        return self._functionals(rows, times, dual)[0]

    def _functionals(
        self, rows: Any, times: FloatArray, dual: Dual | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """rows @ X and its rate, each shape (p, times)."""
        if self.recovery is None:
            u, v = self.motion.observed(rows, times)
        else:
            of_coordinates, of_forces = self.recovery.functionals(
                rows, None if dual is None else dual(self.recovery.s)
            )
            u, v = self.motion.observed(of_coordinates, times)
            u = u + of_forces @ self.motion.force(times)
            v = v + of_forces @ self.motion.force_rate(times)
        return self._completed(rows, u, v, times)

    def _completed(
        self, rows: Any, u: FloatArray, v: FloatArray, times: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Add to rows @ X, or to X where rows is None, what neither model nor recovery contain."""
        for of in self.indentations:
            forces, rates = self.motion.force(times), self.motion.force_rate(times)
            force = of.pressing(forces)
            field = of.mesh_field(self._free)
            field = field if rows is None else rows @ field
            u = u - np.outer(field, force)
            v = v - np.outer(field, np.where(force > 0.0, of.inward * rates[of.port], 0.0))
        if self.static_deflection is not None:
            at_rest = self.static_deflection if rows is None else rows @ self.static_deflection
            u = u + at_rest[:, None]
        return u, v

    @cached_property
    def _rotates(self) -> bool:
        """True if dofs of the body are rotations."""
        assert self.body.nodes is not None
        return bool(self._free.max() >= self.body.nodes.size)

    def _at_nodes(self, dofs: FloatArray, *, rotations: bool = False) -> FloatArray:
        """Dofs (n_dofs, k) as vectors at all nodes, zero where they are constrained."""
        free, nodes = self._free, self.body.nodes
        assert nodes is not None
        n = nodes.size
        own = (free >= n) == rotations
        full = np.zeros((dofs.shape[1], n))
        full[:, free[own] % n] = dofs[own].T
        return full.reshape(-1, len(nodes), 3)

    def _places(self, point: Any, nodes: Any) -> tuple[FloatArray, sp.csr_array]:
        """Places, (3,) for a single point or (p, 3), and the nodes' weights there, (p, n_nodes)."""
        if (point is None) == (nodes is None):
            raise InputError("probe needs either point or nodes, and not both")
        _ = self._free
        coordinates = self.body.nodes
        assert coordinates is not None
        if nodes is not None:
            sets = {} if self.body.mesh is None else self.body.mesh.node_sets
            chosen = selected_nodes("nodes", nodes, coordinates, sets, self.body.node_labels)
            return coordinates[chosen], sp.eye_array(len(coordinates), format="csr")[chosen]
        places = finite_array("point", point, unit="m", most=HUGE)
        if places.shape[-1:] != (3,) or places.ndim > 2 or places.size == 0:
            raise InputError(f"point must have shape (3,) or (p, 3), got {places.shape}")
        return places, place_rows(self.body, places.reshape(-1, 3))


def _energy(product: FloatArray, amounts: FloatArray) -> FloatArray:
    """xᵀ `product` x of each column x of `amounts`; not below 0 by rounding."""
    energy: FloatArray = np.einsum("it,it->t", amounts, product @ amounts)
    return np.maximum(energy, 0.0)
