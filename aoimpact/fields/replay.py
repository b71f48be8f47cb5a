"""The response of a whole body in a run: its motion replayed, and recovered on all dofs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ..base import FloatArray
from ..integrate import Events, Motion, Recorder
from ..linalg import LinearSolver
from ..reduction import PACE, BodyModel, FullModel, Recovery
from ..scene import Plan
from .indentation import indentations
from .response import Response

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
    recovery, deflection = None, None
    if not isinstance(model, FullModel) or recorder.dense or model.in_modes:
        if not model.tips:
            return None
        paces = math.log2(PACE / (largest[1] - largest[0]))
        modal, shift = model.modal, math.exp2(round(_SHIFTS * paces) / _SHIFTS)
        recovery = Recovery(modal, modal.loads(plan.pull), shift, inverse)
    motion = recorder.motion(body)
    if recovery is not None and plan.preload:
        deflection = _static_deflection(motion, recovery)
    return Response(
        model.tips[0].body,
        motion,
        recovery,
        peak_time,
        static_deflection=deflection,
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
    body = recovery.model.body
    if body.rigid_modes.shape[1] > 0:
        return None
    start = np.zeros(1)
    forces = motion.force(start)
    rest = body.inverse().solve(np.ascontiguousarray(recovery.loads @ forces))
    found = recovery.displacement(motion.observed(None, start)[0], forces)
    return np.asarray((rest - found)[:, 0])
