"""A run replayed: the response of each of its bodies, from the plan and what was recorded."""

from __future__ import annotations

import numpy as np

from ..base import FloatArray
from ..integrate import Newmark, Record, Recorded, Recorder, Sampled, Track, find_peak
from ..reduction import InterfaceModel
from ..scene import CONTACT_ROWS, FullBody, Plan
from .motion import DenseMotion, ForcedMotion, Motion
from .recovery import PACE, Recovery
from .reduced import Reduced, reduced_interface, reduced_star
from .response import FreeMotion, Response

__all__ = ["response_of"]

Span = tuple[float, float]

# The share of a blow after which the body is left to itself: its force fades.
_FADING = 0.75


def response_of(plan: Plan, recorder: Recorder, body: int) -> Response | None:
    """Return what all of a body did in a run; None without finite elements.

    Parameters
    ----------
    plan : Plan
        What was run.
    recorder : Recorder
        The run.
    body : int
        Its number in the plan.
    """
    if isinstance(recorder, Sampled):
        return _of_track(plan, body, recorder.track)
    assert isinstance(recorder, Recorded)
    ports = recorder.ports[body] if recorder.ports else None
    return _of_steps(plan, body, recorder.rule, recorder.record, ports)


def _of_track(plan: Plan, body: int, track: Track) -> Response | None:
    ours = [of for of, joint in zip(track.events, plan.joints, strict=True) if joint.touches(body)]
    peak = max(ours, key=lambda of: of.peak_force, default=None)
    motion = DenseMotion(track, plan, body)
    if peak is None or not peak.contacts:
        whole = (0.0, track.duration)
        return _response(plan, body, motion, (whole, whole), 0.0)
    first = min(of.contacts[0] for of in ours if of.contacts)
    blow = next(span for span in peak.contacts if peak.peak_time <= span[1])
    return _response(plan, body, motion, (first, blow), peak.peak_time)


def _of_steps(
    plan: Plan, body: int, rule: Newmark, record: Record, ports: FloatArray | None = None
) -> Response | None:
    """Of a run with fixed steps; `ports`: where these were just after the start."""
    model = plan.bodies[body]
    full = isinstance(model, FullBody)
    if not full and _reduced(plan, body) is None:
        return None
    gravity, state = plan.weight_of(body), plan.start_of(body)
    equations = model.stepped(gravity=gravity, state=state, ports=ports).equations
    forces = plan.port_forces(body, record.t, record.rows)
    motion = ForcedMotion(equations, rule, record.dt, forces, model.coordinates)
    contacts, peak_time = _contacts_of(plan, body, record)
    if isinstance(model, FullBody):
        return Response(model.tip.body, motion, None, None, peak_time)
    return _response(plan, body, motion, contacts, peak_time)


def _contacts_of(plan: Plan, body: int, record: Record) -> tuple[tuple[Span, Span], float]:
    """From when to when a body is touched first, and with the largest force; and when it is that.

    Of what is touched by nobody, the whole record.
    """
    ours = [i for i, joint in enumerate(plan.joints) if joint.touches(body)]
    forces = record.rows[[CONTACT_ROWS * i for i in ours]]
    if not forces.any():
        whole = (0.0, float(record.t[-1]))
        return (whole, whole), 0.0
    force = forces[int(forces.max(axis=1).argmax())]
    begin = int(forces.any(axis=0).argmax())
    early = forces[int(forces[:, begin].argmax())]
    first, largest = _span(record.t, early, begin), _span(record.t, force, int(force.argmax()))
    return (first, largest), find_peak(record.t, force)[1]


def _span(t: FloatArray, force: FloatArray, at: int) -> Span:
    """From when to when a force acts that does so at a step."""
    free = np.flatnonzero(force == 0.0)
    before, after = free[free < at], free[free > at]
    first = int(before[-1]) if len(before) else 0
    last = int(after[0]) if len(after) else len(force) - 1
    return float(t[first]), float(t[last])


def _reduced(plan: Plan, body: int) -> Reduced | None:
    modes = plan.modal[body].modes
    if isinstance(modes, InterfaceModel):
        return reduced_interface(modes, plan.gravity)
    return None if modes.star.origin is None else reduced_star(modes.star, plan.gravity)


def _response(
    plan: Plan, body: int, motion: Motion, contacts: tuple[Span, Span], peak_time: float
) -> Response | None:
    reduced = _reduced(plan, body)
    if reduced is None:
        return None
    first, largest = contacts
    recovery = Recovery(reduced, PACE / (largest[1] - largest[0]))
    loaded = plan.gravity != 0.0 or plan.load_on(body) is not None
    free_from = 0.0 if loaded else first[0] + _FADING * (first[1] - first[0])
    return Response(
        reduced.body,
        motion,
        recovery,
        _free_motion(plan, body),
        peak_time,
        tuple(contacts),
        free_from,
        _static_deflection(motion, recovery) if plan.preload else None,
    )


def _static_deflection(motion: Motion, recovery: Recovery) -> FloatArray | None:
    """What the correction for the blow misses of the rest before it; None of a free body.

    There all modes follow the forces, the slow ones too: X = K⁻¹ B f.
    """
    reduced = recovery.reduced
    if reduced.body.rigid_modes.shape[1] > 0:
        return None
    start = np.zeros(1)
    forces = motion.force(start)
    rest = reduced.body.inverse().solve(np.ascontiguousarray(reduced.loads @ forces))
    found = recovery.displacement(motion.observed(None, start)[0], forces)
    deflection: FloatArray = (rest - found)[:, 0]
    return deflection


def _free_motion(plan: Plan, body: int) -> FreeMotion | None:
    """What a free body struck off its centre does beside the motion that its star contains."""
    modes = plan.modal[body].modes
    velocity = plan.velocities[body]
    if isinstance(modes, InterfaceModel) or (velocity == 0.0 and plan.gravity == 0.0):
        return None
    origin = modes.star.origin
    if origin is None or not origin.translates:
        return None
    rest = origin.tip.body.translation(origin.tip.direction) - origin.static_mode
    return FreeMotion(rest, velocity, plan.gravity)
