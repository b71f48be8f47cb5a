"""The response of a whole body in a run: its motion replayed, and recovered on all dofs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, IntArray, finite_array
from ..fem import Damping, FEModel
from ..integrate import Events, Motion, Recorder
from ..reduction import PACE, FullModel, Recovery, SharedSolutions
from ..scene import Scenario
from .fields import Field
from .held import Held
from .history import LOOKS
from .indentation import Indentation, indentations
from .rows import TensorRows

# Steps of the correction's shift in a doubling of it: runs that differ little share factors.
_SHIFTS = 4


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

    def motion_at(
        self,
        places: FloatArray,
        axes: FloatArray,
        rows: Any,
        times: FloatArray,
        *,
        rates: bool = True,
    ) -> tuple[FloatArray, FloatArray]:
        """Return displacement and velocity at places (p, 3) along axes (k, 3), (times, p k).

        rows: of the dofs, shape (p k, n_dofs), by `place_rows` and the axes. Without `rates` the
        velocity lacks the half-space's.
        """
        u, v = (values.T for values in self._functionals(rows, times))
        added = self._half_space(places, times, rates=rates)
        u = u + (added[0] @ axes.T).reshape(u.shape)
        return u, v + (added[1] @ axes.T).reshape(v.shape)

    @property
    def held(self) -> Held:
        """The body as it is held, for the forces of its supports."""
        return Held(self.body.grounding, self.motion, self.recovery, self.damping, self.gravity)

    def field(self, times: Any = None) -> Field:
        """See `BodyResult.field`."""
        wanted = self.within(self.peak_time if times is None else times)
        u, v = self.motion.observed(None, wanted)
        if self.recovery is not None:
            u = self.recovery.displacement(u, self.motion.force(wanted))
            v = self.recovery.displacement(v, self.motion.force_rate(wanted))
        u, v = self._completed(None, u, v, wanted)
        moved, speeds = self._at_nodes(u), self._at_nodes(v)
        turned = self._at_nodes(u, rotations=True) if self._rotates else None
        assert self.body.nodes is not None
        added = self._half_space(self.body.nodes, wanted)
        return Field(
            self.body,
            wanted,
            moved + added[0],
            speeds + added[1],
            moved,
            partial(self.half_space_stress, wanted),
            turned,
            _error=partial(self._error, wanted),
        )

    def half_space_stress(self, times: FloatArray, places: FloatArray) -> FloatArray:
        """Return what contacts add to the elements' stress at places (p, 3), (times, p, 6)."""
        return self._half_space(places, times, rates=False)[2]

    def _half_space(
        self, places: FloatArray, times: FloatArray, *, rates: bool = True
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The half-space's displacement, its rate and stress at places; 0 without contacts.

        Without the rates, which take twice as long, zeros.
        """
        u, v, stress = (np.zeros((len(times), len(places), count)) for count in (3, 3, 6))
        for of in self.indentations:
            force = of.pressing(self.motion.force(times))
            moved, tensor = of.at(places, force)
            u, stress = u + moved, stress + tensor
            if rates:
                rate = of.inward * self.motion.force_rate(times)[of.port]
                v = v + of.rate(places, force, rate)
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

    def _error(self, times: FloatArray) -> FloatArray | None:
        """Relative error of the field at `times` in the norm of strain energy; None if unknown."""
        if (finer := self._finer) is None:
            return None
        ours, theirs = self._shapes, finer._shapes
        shapes, n = np.hstack([ours, theirs]), ours.shape[1]
        product = shapes.T @ (self.body.K @ shapes)
        apart = np.vstack([self._amounts(times), -finer._amounts(times)])
        looks = np.union1d(times, np.linspace(0.0, self.motion.duration, LOOKS))
        largest = _energy(product[n:, n:], finer._amounts(looks)).max(initial=0.0)
        return np.sqrt(_energy(product, apart) / (largest if largest > 0.0 else 1.0))

    def compared(self) -> Response | None:
        """Return the response with a finer model; None of a full model."""
        return self._finer

    @cached_property
    def _finer(self) -> Response | None:
        return None if self.finer is None or self.recovery is None else self.finer()

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
    def free(self) -> IntArray:
        """The body's dofs among those of its nodes, whose places are known."""
        if self.body.free is None:
            raise InputError(
                "the body has no nodes, so no place on it has coordinates: make it with "
                "FEModel.from_mesh(...) or FEModel(K=, M=, nodes=)"
            )
        return self.body.free

    def within(self, times: Any) -> FloatArray:
        """Return checked times within the record, s; at least one."""
        wanted = times_within(times, self.motion.duration)
        if not wanted.size:
            raise InputError("times must have at least one, got none")
        return wanted

    def stress(self, of: TensorRows, times: FloatArray) -> FloatArray:
        """Return stress or strain at places, shape (times, p, 6)."""
        found = of.elements.components(self.functionals(of.elements.rows, times))
        added = self.half_space_stress(times, of.places)
        if of.compliance is not None:
            added = np.einsum("pij,tpj->tpi", of.compliance, added)
        return np.asarray(found + added)

    def functionals(self, rows: Any, times: FloatArray) -> FloatArray:
        """Return rows @ X for `rows` of shape (p, n_dofs), shape (p, times)."""
        return self._functionals(rows, times)[0]

    def _functionals(self, rows: Any, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """rows @ X and its rate, each shape (p, times)."""
        if self.recovery is None:
            u, v = self.motion.observed(rows, times)
        else:
            of_coordinates, of_forces = self.recovery.functionals(rows)
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
            field = of.mesh_field(self.free)
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
        return bool(self.free.max() >= self.body.nodes.size)

    def _at_nodes(self, dofs: FloatArray, *, rotations: bool = False) -> FloatArray:
        """Dofs (n_dofs, k) as vectors at all nodes, zero where they are constrained."""
        free, nodes = self.free, self.body.nodes
        assert nodes is not None
        n = nodes.size
        own = (free >= n) == rotations
        full = np.zeros((dofs.shape[1], n))
        full[:, free[own] % n] = dofs[own].T
        return full.reshape(-1, len(nodes), 3)


def _energy(product: FloatArray, amounts: FloatArray) -> FloatArray:
    """xᵀ `product` x of each column x of `amounts`; not below 0 by rounding."""
    energy: FloatArray = np.einsum("it,it->t", amounts, product @ amounts)
    return np.maximum(energy, 0.0)


def response_of(
    plan: Scenario,
    recorder: Recorder,
    events: Sequence[Events],
    body: int,
    shared: SharedSolutions | None = None,
) -> Response | None:
    """Return the response of a whole body in a run; None without finite elements.

    Parameters
    ----------
    plan : Scenario
        What was run.
    recorder : Recorder
        The run.
    events : sequence of Events
        Of its contacts.
    body : int
        Its number in the plan.
    shared : SharedSolutions, optional
        Of the runs of several models of the body.
    """
    model = plan.bodies[body]
    ours = [of for of, contact in zip(events, plan.contacts, strict=True) if contact.touches(body)]
    peak = max(ours, key=lambda of: of.peak_force, default=None)
    (start, end), peak_time = (0.0, recorder.duration), 0.0  # of a body that was not touched
    if peak is not None and peak.peak_contact is not None:
        (start, end), peak_time = peak.peak_contact, peak.peak_time
    recovery = at_rest = None
    motion = recorder.motion(body)
    if not isinstance(model, FullModel) or recorder.dense or model.in_modes:
        if not model.tips:
            return None
        pace = math.exp2(round(_SHIFTS * math.log2(PACE / (end - start))) / _SHIFTS)
        recovery = Recovery(model.modal, model.modal.loads(plan.pull), pace, shared)
        held = not model.modal.body.rigid_modes.shape[1]
        if plan.preload and held:  # at rest all modes follow, the slow ones too: X = K⁻¹ B f
            q, forces = motion.observed(None, np.zeros(1))[0], motion.force(np.zeros(1))
            load = np.ascontiguousarray(recovery.loads @ forces)
            rest = recovery.model.body.inverse().solve(load)
            at_rest = (rest - recovery.displacement(q, forces))[:, 0]
    tip, gravity = model.touched_at(), plan.pull
    if not isinstance(gravity, np.ndarray):
        down = None if tip is None or model.weightless else tip.direction
        gravity = np.zeros(3) if down is None else plan.gravity * down
    return Response(
        model.tips[0].body,
        motion,
        recovery,
        peak_time,
        static_deflection=at_rest,
        indentations=indentations(plan, body),
        damping=model.damping,
        gravity=gravity,
    )
