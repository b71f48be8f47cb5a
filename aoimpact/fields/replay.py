"""The response of a whole body in a run: its motion replayed, and recovered on all dofs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ..base import FloatArray
from ..integrate import Events, Motion, Recorder
from ..linalg import LinearSolver
from ..reduction import PACE, BodyModel, FullModel, Recovery, ReducedModel
from ..scene import FreeMotion, Plan
from .indentation import indentations
from .response import OmittedMotion, Response

Span = tuple[float, float]

# Steps of the correction's shift in a doubling of it: runs that differ little share factors.
_SHIFTS = 4


def response_of(
    plan: Plan,
    recorder: Recorder,
    events: Sequence[Events],
    body: int,
    inverse: Callable[[float], LinearSolver] | None = None,
) -> Response | None:
    """Return the response of a whole body in a run; None without finite elements.

    Parameters
    ----------
    plan : Plan
        What was run.
    recorder : Recorder
        The run.
    events : sequence of Events
        Of its contacts.
    body : int
        Its number in the plan.
    inverse : callable, optional
        s² ↦ the solver of K + s²M, where runs of several models of the body share it.
    """
    model = plan.bodies[body]
    largest, peak_time = _largest_contact(plan, events, recorder.duration, body)
    if isinstance(model, FullModel) and not recorder.dense:
        motion = recorder.motion(body)
        return Response(
            model.body,
            motion,
            None,
            None,
            peak_time,
            indentations=indentations(plan, body),
            damping=model.damping,
            gravity=_gravity(plan, model),
        )
    reduced = _reduced(model).coordinates(plan.pull)
    if reduced is None:
        return None
    motion = recorder.motion(body)
    recovery = Recovery(reduced, _shift(largest[1] - largest[0]), inverse)
    return Response(
        reduced.body,
        motion,
        recovery,
        _omitted_motion(plan, body),
        peak_time,
        static_deflection=_static_deflection(motion, recovery) if plan.preload else None,
        indentations=indentations(plan, body),
        damping=model.damping,
        gravity=_gravity(plan, model),
    )


def _gravity(plan: Plan, model: BodyModel) -> FloatArray:
    """Acceleration of gravity along the direction of travel, m/s², shape (3,)."""
    tip = model.touched_at()
    if isinstance(plan.pull, np.ndarray):
        return plan.pull
    if not plan.gravity or tip is None or tip.direction is None or model.weightless:
        return np.zeros(3)
    return plan.gravity * tip.direction


def _reduced(model: BodyModel) -> ReducedModel:
    """The model whose modes a dense run is recorded in."""
    found = model.whole if isinstance(model, FullModel) else model
    assert isinstance(found, ReducedModel)
    return found


def _shift(contact_time: float) -> float:
    return math.exp2(round(_SHIFTS * math.log2(PACE / contact_time)) / _SHIFTS)


def _largest_contact(
    plan: Plan, events: Sequence[Events], duration: float, body: int
) -> tuple[Span, float]:
    """The contact of the largest force on a body, and when this is largest, s.

    The whole record stands for the contact of a body without one.
    """
    ours = [of for of, contact in zip(events, plan.contacts, strict=True) if contact.touches(body)]
    peak = max(ours, key=lambda of: of.peak_force, default=None)
    if peak is None or peak.peak_contact is None:
        return (0.0, duration), 0.0
    return peak.peak_contact, peak.peak_time


def _static_deflection(motion: Motion, recovery: Recovery) -> FloatArray | None:
    """The part of the deflection at rest that the correction misses; None of a free body.

    At rest all modes follow the forces, the slow ones too: X = K⁻¹ B f.
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


def _omitted_motion(plan: Plan, body: int) -> OmittedMotion | None:
    """The motion of a free body struck off its centre that its AO model does not contain."""
    velocity = plan.velocities[body]
    if velocity == 0.0 and plan.gravity == 0.0:
        return None
    omitted = _reduced(plan.bodies[body]).omitted_translation
    return None if omitted is None else OmittedMotion(omitted, FreeMotion(velocity, plan.gravity))
