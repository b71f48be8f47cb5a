"""Response of a whole body in a run: the motion of all dofs, recomputed from recorded forces.

A contact force F on a patch deforms the elements about it as far as their shape functions allow. F
times `Compliance.mesh_field` is the part of this deformation that approximates the field u_B of a
half-space under Hertz's pressure. The closed form of u_B for the current contact radius replaces
this part, so that displacement and stress are right under the contact, however large the elements
are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..base import ArrayPair, FloatArray, InputError, IntArray, finite_array, in_batches
from ..contact import DIFFERENCE, SHIFT_TIMES_DURATION, Compliance
from ..fem import SIX, Damping, FEModel, Rayleigh, VirtualMotion
from ..integrate import Motion
from ..reduction import FullModel, Recovery
from ..scene import extraction_of
from .field import LOOKS, Field

# Number of values per octave to which the shift s of the recovery is rounded, so that similar runs
# share factorisations.
_SHIFTS = 4

# Smallest contact radius in closed forms, relative to `Compliance.radius`, which belongs to the
# largest force. Closed forms lose digits in proportion to the squared ratio of distance to contact
# radius.
_NARROWEST = 1e-2


def times_within(times: Any, end: float) -> FloatArray:
    """Return checked `times`, s, shape (n,), which ascend from 0 or later to `end` at most."""
    wanted = np.atleast_1d(finite_array("times", times, unit="s"))
    if wanted.ndim != 1 or (np.diff(wanted) < 0.0).any():
        raise InputError("times must be a flat list that ascends; ravel and sort them")
    if wanted.size and (wanted[0] < 0.0 or wanted[-1] > end * (1.0 + 1e-12)):
        raise InputError(
            f"times must lie within the record, 0 to {end:g} s, got {wanted[0]:g} to "
            f"{wanted[-1]:g} s; take a longer duration"
        )
    return wanted


@dataclass(frozen=True, eq=False)
class Indentation:
    """Field of a half-space under Hertz's pressure at one contact point of a body.

    Attributes
    ----------
    port : int
        Number of the contact point.
    extraction : Compliance
    inward : float
        1 if a positive force on the port pushes into the body, else -1.
    width : callable
        Function of forces, N, shape (n,), that returns the radius of the contact, m.
    """

    port: int
    extraction: Compliance
    inward: float
    width: Callable[[FloatArray], FloatArray]

    def pressing(self, motion: Motion, times: FloatArray) -> ArrayPair:
        """Return the force pressing into the body, N, and its rate, N/s, shape (n,) each."""
        force = np.maximum(self.inward * motion.force(times)[self.port], 0.0)
        rate = self.inward * motion.force_rate(times)[self.port]
        return force, np.where(force > 0.0, rate, 0.0)

    def at(self, x: FloatArray, force: FloatArray) -> ArrayPair:
        """Return displacement, m, (n, p, 3), and stress, Pa, (n, p, 6), at places (p, 3)."""
        u, stress = np.zeros((len(force), len(x), 3)), np.zeros((len(force), len(x), 6))
        pressed = np.flatnonzero(force > 0.0)
        for some in in_batches(len(pressed), 72.0 * len(x)):
            i = pressed[some]
            width = np.maximum(self.width(force[i]), _NARROWEST * self.extraction.radius)
            moved, tensor = self.extraction.splitting.half_space_field(x, width)
            u[i] = force[i, None, None] * moved
            stress[i] = force[i, None, None] * tensor[..., *SIX]
        return u, stress

    def rate(self, x: FloatArray, force: FloatArray, rate: FloatArray) -> FloatArray:
        """Return the rate of displacement, m/s, (n, p, 3), for a force, N, and its rate, N/s."""
        more, less = (self.at(x, (1.0 + step) * force)[0] for step in (DIFFERENCE, -DIFFERENCE))
        change = np.divide(
            rate, 2.0 * DIFFERENCE * force, out=np.zeros_like(rate), where=force > 0.0
        )
        return (more - less) * change[:, None, None]


@dataclass(frozen=True, eq=False)
class Response:
    """Motion of a whole body at any time of a run.

    Attributes
    ----------
    body : FEModel
    motion : Motion
        Motion of the body's own dofs, or of its reduced model's coordinates.
    recovery : Recovery or None
        Map from the reduced model's coordinates to the dofs; None if `motion` is of the dofs.
    peak_time : float
        Time of the largest force, s.
    static_deflection : ndarray, shape (n_dofs,), or None
        Part of the deflection at rest under load that `recovery` misses, m.
    indentations : sequence of Indentation
        Half-space fields at the body's contacts, which replace the mesh's approximations.
    damping : Damping or None
        Damping of the body's model; modal damping acts on the free dofs alone.
    gravity : ndarray, shape (3,)
        Acceleration of gravity, m/s².
    run : Run
    number : int
        Number of the body in the run.
    """

    body: FEModel
    motion: Motion
    recovery: Recovery | None
    peak_time: float
    static_deflection: FloatArray | None
    indentations: Sequence[Indentation]
    damping: Damping | None
    gravity: FloatArray
    run: Any = field(repr=False)
    number: int

    @property
    def duration(self) -> float:
        """Length of the record, s."""
        return self.motion.duration

    @cached_property
    def others(self) -> list[Response]:
        """Responses of the body in the runs with other elements; none for a full model."""
        others = self.run.others if self.recovery is not None else []
        found = [response_of(of, self.number) for of in others]
        return [of for of in found if of is not None] if all(found) else []

    def work(self, times: FloatArray, of: VirtualMotion) -> FloatArray:
        """Return the ground's virtual work per unit of the k motions in `of`, (n_times, k).

        The work is in N for a translation and in N m for a rotation; see `fem.Grounding`. If
        `motion` has the dofs as coordinates, the forces of the ground are K X + C Ẋ + M Ẍ at
        constrained dofs.
        """
        motion, known = self.motion, self.body.grounding
        alpha, beta = 0.0, 0.0
        if isinstance(self.damping, Rayleigh):
            alpha, beta = self.damping.alpha, self.damping.beta
        if self.recovery is None:
            stiffness = np.asarray(of.ground.T @ known.K - of.springs.T)
            mass = np.asarray(of.ground.T @ known.M[:, self.body.free])
            u, v = motion.observed(stiffness, times)
            drag = alpha * motion.observed(mass, times)[1]
            found = u + motion.acceleration(mass, times) + beta * v + drag
        else:
            model, loads = self.recovery.model, self.recovery.loads
            q, rates = motion.observed(None, times)
            # The ground's forces include M Ẍ + C Ẋ. C is that of Rayleigh damping; modal damping
            # acts on free dofs.
            inertia = (model.modes.T @ loads) @ motion.force(times)
            inertia = inertia - model.omega[:, None] ** 2 * (q + beta * rates)
            found = (of.inertia.T @ model.modes) @ inertia
            found = found - (of.phi.T @ loads) @ motion.force(times)
        return (found - (of.weight @ self.gravity)[:, None]).T

    def field(self, times: Any = None) -> Field:
        """See `BodyResult.field`."""
        wanted = self.within(self.peak_time if times is None else times)
        free, nodes, body = self.free, self.body.nodes, self.body.given
        own = slice(len(body.nodes))
        u, v = self.functionals(None, wanted)
        everywhere = np.zeros((2, len(wanted), 2 * nodes.size))  # zeros at constrained dofs
        everywhere[0][:, free], everywhere[1][:, free] = u.T, v.T
        (moved, turned), (speeds, _) = (
            of.reshape(len(wanted), 2, -1, 3).swapaxes(0, 1)[:, :, own] for of in everywhere
        )
        more, faster, _ = self.half_space(body.nodes, wanted)
        moves = moved + more, speeds + faster, turned
        return Field(body, wanted, *moves, self, everywhere[0])

    def half_space(
        self, places: FloatArray, times: FloatArray, *, rates: bool = True
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return displacement, rate and stress of half-spaces under contacts, at places (p, 3).

        Displacement and rate have the shape (times, p, 3), stress (times, p, 6). Without `rates`,
        which take twice as long, the rate is zero.
        """
        u, v, stress = (np.zeros((len(times), len(places), count)) for count in (3, 3, 6))
        for of in self.indentations:
            force, rate = of.pressing(self.motion, times)
            moved, tensor = of.at(places, force)
            u, stress = u + moved, stress + tensor
            if rates:
                v = v + of.rate(places, force, rate)
        return u, v, stress

    def displacement_of(self, functional: FloatArray, times: FloatArray) -> FloatArray:
        """Return functionalᵀX from the model's own shapes, without the correction of `recovery`.

        Parameters
        ----------
        functional : ndarray, shape (n_dofs,)
            Functional on the dofs of the body as it was given.
        times : ndarray, shape (k,)
            Times, s.
        """
        functional = self.body.functional(functional)
        row = functional if self.recovery is None else self.recovery.model.seen(functional)
        return np.asarray(self.motion.observed(row[None], times)[0][0])

    def field_error(self, times: FloatArray) -> FloatArray | None:
        """Return the field's relative error in strain-energy norm, (k,); None if not known."""
        if not self.others:
            return None
        looks, found = np.union1d(times, np.linspace(0.0, self.duration, LOOKS)), np.zeros(1)
        ours, mine, _ = zip(*self._parts(times), strict=True)
        most = np.vstack([amounts for _, amounts, _ in self._parts(looks)])
        for other in self.others:
            theirs, right, _ = zip(*other._parts(times), strict=True)
            body = max(self.body, other.body, key=lambda body: body.n_dofs)
            shapes, K = body.alike(np.hstack(ours), np.hstack(theirs))
            product = shapes.T @ (K @ shapes)
            largest = _energy(product[: len(most), : len(most)], most).max(initial=0.0)
            apart = _energy(product, np.vstack([*mine, *(-amounts for amounts in right)]))
            found = found + np.sqrt(apart / (largest if largest > 0.0 else 1.0))
        return found

    def _parts(self, times: FloatArray) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
        """Return shapes of the motion, (n_dofs, k), their coefficients and the rates, (k, times).

        The rates are those of the coefficients. The motion of a full model's own dofs is not
        included.
        """
        parts, motion, recovery = [], self.motion, self.recovery
        if recovery is not None:
            q, rates = motion.observed(None, times)
            force, change = motion.force(times), motion.force_rate(times)
            parts.append((recovery.basis, np.vstack([q, force]), np.vstack([rates, change])))
            added = recovery.amounts(q, force), recovery.amounts(rates, change)
            parts.append((recovery.shapes, *added))
        for of in self.indentations:  # subtracts the mesh's approximation of u_B
            force, rate = of.pressing(motion, times)
            shape = -of.extraction.mesh_field.reshape(-1, 1)[self.free]
            parts.append((shape, force[None], rate[None]))
        if self.static_deflection is not None:
            still = np.zeros((1, len(times)))
            parts.append((self.static_deflection[:, None], still + 1.0, still))
        return parts

    @property
    def free(self) -> IntArray:
        """Indices of the body's dofs among all dofs of its nodes; refuses a body without nodes."""
        if self.body.free is None:
            raise InputError(
                "the body has no nodes, so no place on it has coordinates: make it with "
                "FEModel.from_mesh(...) or FEModel(K=, M=, nodes=)"
            )
        return self.body.free

    def within(self, times: Any) -> FloatArray:
        """Return checked times within the record, s; at least one."""
        wanted = times_within(times, self.duration)
        if not wanted.size:
            raise InputError("times must have at least one, got none")
        return wanted

    def functionals(self, rows: Any, times: FloatArray) -> ArrayPair:
        """Return rows @ X and its rate, (p, times), for `rows` (p, n_dofs); X itself for None."""
        found: Any = (0.0, 0.0) if self.recovery else self.motion.observed(rows, times)
        u, v = found
        for shapes, amounts, rates in self._parts(times):
            seen = shapes if rows is None else rows @ shapes
            u, v = u + seen @ amounts, v + seen @ rates
        return u, v


def _energy(product: FloatArray, amounts: FloatArray) -> FloatArray:
    """Return xᵀ `product` x for each column x of `amounts`; negative rounding errors become 0."""
    return np.asarray(np.maximum(np.einsum("it,it->t", amounts, product @ amounts), 0.0))


def response_of(run: Any, body: int) -> Response | None:
    """Return the response of body number `body` in a run; None without finite elements."""
    plan, recorder = run.plan, run.recorder
    both, model = zip(run.events, plan.contacts, strict=True), plan.bodies[body]
    ours = [events for events, contact in both if contact.touches(body)]
    peak = max(ours, key=lambda of: of.peak_force, default=None)
    (start, end), peak_time = (0.0, recorder.duration), 0.0  # for a body that was not touched
    if peak is not None and peak.peak_contact is not None:
        (start, end), peak_time = peak.peak_contact, peak.peak_time
    recovery = at_rest = None
    motion = recorder.motion(body)
    if not isinstance(model, FullModel) or recorder.dense or model.in_modes:
        if not model.tips:
            return None
        pace = math.exp2(round(_SHIFTS * math.log2(SHIFT_TIMES_DURATION / (end - start))) / _SHIFTS)
        recovery = Recovery(model.modal, model.modal.loads(plan.pull), pace)
        held = not model.modal.body.rigid_modes.shape[1]
        if plan.preload and held:  # at rest slow modes deflect, too: X = K⁻¹ B f
            q, forces = motion.observed(None, np.zeros(1))[0], motion.force(np.zeros(1))
            load = np.ascontiguousarray(recovery.loads @ forces)
            rest = recovery.model.body.inverse().solve(load)
            at_rest = (rest - recovery.displacement(q, forces))[:, 0]
    tip, gravity = model.touched_at(), plan.pull
    if not isinstance(gravity, np.ndarray):
        down = None if tip is None or model.weightless else tip.direction
        gravity = np.zeros(3) if down is None else plan.gravity * down
    fields = dict[int, Indentation]()
    for contact in plan.contacts:
        port = contact.port_of(body)
        if not contact.touches(body) or port in fields:
            continue
        known, touched = extraction_of(contact.law, model, port), model.touched_at(port)
        if touched is None or touched.direction is None or not (known and known.splitting):
            continue  # for a shell only the mesh's own field is known
        if touched.body.mesh is None or touched.body.mesh.thin:
            continue  # shells next to solids keep the mesh's field, too
        inward = float(np.sign(known.splitting.frame[2] @ touched.direction))
        between = plan.round_contact(contact)
        width = partial(np.full_like, fill_value=known.radius)
        fields[port] = Indentation(port, known, inward, between.width if between else width)
    found = model.tips[0].body, motion, recovery, peak_time, at_rest, (*fields.values(),)
    return Response(*found, model.damping, gravity, run, body)
