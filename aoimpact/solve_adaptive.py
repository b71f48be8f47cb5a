"""A scene to a tolerance, read where and when it is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from .adaptive import TIGHTEST, Adaptive, FloatArray, Track, adaptive_run
from .errors import warn
from .events import Events
from .plan import Plan
from .recall import recall_tracked
from .run import Run

__all__ = ["Sampled", "solve_adaptive"]

# A contact need not be more exact than this share of the largest: the core's own rule (step.c).
_LESSER_SHARE = 0.01


@dataclass(frozen=True, eq=False)
class Sampled:
    """An adaptive run, to be read at any times."""

    track: Track
    dense: bool = True

    @property
    def times(self) -> FloatArray:
        return self.track.times

    @property
    def marks(self) -> FloatArray:
        return self.track.marks

    @property
    def events(self) -> tuple[Events, ...]:
        return self.track.events

    def rows(self, times: FloatArray, energies: bool) -> FloatArray:
        return self.track.sample(times, energies=energies)


def solve_adaptive(plan: Plan, rule: Adaptive) -> Run:
    """Run a scene to a tolerance.

    From the second touch of a contact on, errors grow with each; then a tighter run tells how far.

    Raises
    ------
    ConvergenceError
        If the tolerance cannot be met; with the time.

    Warns
    -----
    AOImpactWarning
        If the tighter run differs by more than the tolerance.
    """
    track, error = _track(plan, rule.rtol), rule.rtol
    contacts = max((len(events.contacts) for events in track.events), default=0)
    if contacts > 1 and rule.rtol > 10.0 * TIGHTEST:
        first, tighter = track, 0.1 * rule.rtol
        track = _track(plan, tighter)
        error = max(error, _difference(first.events, track.events))
        if error > rule.rtol:
            warn(
                f"rtol={rule.rtol:g} is not kept over {contacts} contacts, each of which enlarges "
                f"the errors before: with rtol={tighter:g} the run differs by {error:.2g}; take a "
                "smaller rtol, or trust the first contacts only"
            )
    return Run(
        infos=plan.infos(
            [partial(_state, plan, track, i) for i in range(len(plan.players))],
            [partial(recall_tracked, plan, i, track) for i in range(len(plan.players))],
        ),
        ends=plan.ends,
        duration=plan.duration,
        solver=f"Adaptive(rtol={rule.rtol:g}), {track.steps} steps in contact",
        energies=plan.energies,
        time_error=error,
        recorder=Sampled(track),
        drifts=plan.drifts,
        scene=plan.scene,
    )


def _state(plan: Plan, track: Track, body: int) -> tuple[FloatArray, FloatArray]:
    """A body's coordinates and rates at the end."""
    modal = plan.modal[body]
    first = sum(other.n for other in plan.modal[:body])
    ours = slice(first, first + modal.n)
    return modal.coordinates(track.x[ours]), modal.coordinates(track.v[ours])


def _track(plan: Plan, rtol: float) -> Track:
    laws = {id(joint.law): joint.law.for_core() for joint in plan.joints}
    moving = [body.moving * speed for body, speed in zip(plan.modal, plan.velocities, strict=True)]
    v = np.concatenate(moving)
    return adaptive_run(
        [body.for_core(plan.gravity, plan.load_on(i)) for i, body in enumerate(plan.modal)],
        [
            (j.first, j.first_port, j.second, j.second_port, j.gap, laws[id(j.law)])
            for j in plan.joints
        ],
        np.concatenate(plan.at_rest) if plan.preload else np.zeros(len(v)),
        v,
        rtol=rtol,
        duration=plan.duration,
    )


def _difference(ones: tuple[Events, ...], others: tuple[Events, ...]) -> float:
    """Relative difference of peak forces and impulses.

    Numbers of touches are not compared: whether bodies that go on side by side graze each other is
    rounding, and what matters of a touch is in its impulse.
    """
    largest = 0.0
    for of in (_peaks, _impulses):
        mine, its = of(ones), of(others)
        scale = np.maximum(np.abs(its), _LESSER_SHARE * np.abs(its).max(initial=0.0))
        apart = np.divide(np.abs(mine - its), scale, out=np.zeros(len(its)), where=scale > 0.0)
        largest = max(largest, float(apart.max(initial=0.0)))
    return largest


def _peaks(events: tuple[Events, ...]) -> FloatArray:
    return np.array([event.peak_force for event in events])


def _impulses(events: tuple[Events, ...]) -> FloatArray:
    return np.array([event.impulse for event in events])
