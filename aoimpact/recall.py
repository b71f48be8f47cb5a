"""A run recalled: the response of each of its bodies, from the plan and what was recorded."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .adaptive import Track
from .driven import Driven, equations_of
from .events import find_peak
from .interface import InterfaceModel
from .newmark import Newmark, Record
from .plan import CONTACT_ROWS, Plan
from .players import FullPlayer
from .recovery import PACE, Recovery
from .reduced import Reduced, reduced_interface, reduced_star
from .response import Flight, Motion, Response
from .tracked import Tracked

__all__ = ["recall_stepped", "recall_tracked"]

FloatArray = npt.NDArray[np.float64]
Span = tuple[float, float]


def recall_tracked(plan: Plan, body: int, track: Track) -> Response | None:
    """Return the response of a body of an adaptive run; None without finite elements."""
    ours = [of for of, joint in zip(track.events, plan.joints, strict=True) if joint.touches(body)]
    peak = max(ours, key=lambda of: of.peak_force, default=None)
    peak_time, blow = 0.0, (0.0, track.duration)
    if peak is not None and peak.contacts:
        peak_time = peak.peak_time
        blow = next(span for span in peak.contacts if peak_time <= span[1])
    return _response(plan, body, Tracked(track, plan, body), blow, peak_time)


def recall_stepped(plan: Plan, body: int, rule: Newmark, record: Record) -> Response | None:
    """Return the response of a body of a run with steps; None without finite elements."""
    player = plan.players[body]
    full = isinstance(player, FullPlayer)
    if not full and _reduced(plan, body) is None:
        return None
    core = player.for_core(rule, record.dt, gravity=plan.weight_of(body), state=plan.start_of(body))
    forces = plan.port_forces(body, record.t, record.rows)
    motion = Driven(equations_of(core), rule, record.dt, forces, player.coordinates)
    blow, peak_time = _largest(plan, body, record)
    if isinstance(player, FullPlayer):
        return Response(player.tip.body, motion, None, None, peak_time)
    return _response(plan, body, motion, blow, peak_time)


def _largest(plan: Plan, body: int, record: Record) -> tuple[Span, float]:
    """The contact with the largest force on a body, from when to when, and when it is largest."""
    ours = [i for i, joint in enumerate(plan.joints) if joint.touches(body)]
    forces = record.rows[[CONTACT_ROWS * i for i in ours]]
    if not forces.any():
        return (0.0, float(record.t[-1])), 0.0
    force = forces[int(forces.max(axis=1).argmax())]
    top = int(force.argmax())
    free = np.flatnonzero(force == 0.0)
    before, after = free[free < top], free[free > top]
    first = int(before[-1]) if len(before) else 0
    last = int(after[0]) if len(after) else len(force) - 1
    return (float(record.t[first]), float(record.t[last])), find_peak(record.t, force)[1]


def _reduced(plan: Plan, body: int) -> Reduced | None:
    modes = plan.modal[body].modes
    if isinstance(modes, InterfaceModel):
        return reduced_interface(modes, plan.gravity)
    return None if modes.star.origin is None else reduced_star(modes.star, plan.gravity)


def _response(
    plan: Plan, body: int, motion: Motion, blow: Span, peak_time: float
) -> Response | None:
    reduced = _reduced(plan, body)
    if reduced is None:
        return None
    recovery = Recovery(reduced, PACE / (blow[1] - blow[0]))
    return Response(reduced.body, motion, recovery, _flight(plan, body), peak_time, blow[1])


def _flight(plan: Plan, body: int) -> Flight | None:
    """What a free body struck off its centre does beside the motion that its star contains."""
    modes = plan.modal[body].modes
    velocity = plan.velocities[body]
    if isinstance(modes, InterfaceModel) or (velocity == 0.0 and plan.gravity == 0.0):
        return None
    origin = modes.star.origin
    if origin is None or not origin.translates:
        return None
    rest = origin.tip.body.translation(origin.tip.direction) - origin.static_mode
    return Flight(rest, velocity, plan.gravity)
