"""Checks that an impact and a scene share: durations, speeds, known centres of mass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import HUGE, InputError, plain, positive, real, warn
from ..fem import ContactPoint
from ..results import Run
from ..scene import Plan, SceneBody

__all__ = [
    "checked_duration",
    "checked_gravity",
    "checked_speed",
    "warn_of_centres",
    "warn_of_exchange",
    "warn_of_places",
]

# m/s; squares and energies of speeds beyond these overflow, or vanish.
_SLOWEST, _FASTEST = 1e-60, 1e60

# s; their cubes are numbers, and so is the distance that the fastest body covers.
_SHORTEST, _LONGEST = 1.0 / HUGE, HUGE

# m/s², the most on a neutron star. Above ten times as much, depths of contacts are no more than the
# rounding of the ways that bodies fall, and drawn scenes were wrong by 1e-7 to 1e-4.
_HEAVIEST = 1e12

# Directions more than 10° off the normal are warned of; facets of coarse meshes are that far off.
_OBLIQUE = math.cos(math.radians(10.0))

# Points of two bodies closer than this share of the first body's size count as one.
_SHARED = 1e-3


def checked_duration(duration: Any) -> float:
    """Return the length of a record, s, over which displacements do not overflow."""
    length = positive("duration", duration, unit="s")
    if not _SHORTEST <= length <= _LONGEST:
        raise InputError(
            f"duration={length:g} s is beyond what can be computed: {_SHORTEST:g} to {_LONGEST:g} s"
        )
    return length


def checked_speed(name: str, value: Any) -> float:
    """Return a speed, m/s, whose square neither overflows nor vanishes.

    Raises
    ------
    InputError
    """
    speed = real(name, value, unit="m/s")
    if speed != 0.0 and not _SLOWEST <= abs(speed) <= _FASTEST:
        raise InputError(
            f"{name}={speed:g} m/s: its square is beyond the range of numbers; give a speed from "
            f"{_SLOWEST:g} to {_FASTEST:g} m/s"
        )
    return speed


def checked_gravity(value: Any) -> float:
    """Return an acceleration, m/s², beside which contacts are still resolved.

    Raises
    ------
    InputError
    """
    pull = real("gravity", value, unit="m/s²")
    if abs(pull) > _HEAVIEST:
        raise InputError(
            f"gravity={pull:g} m/s² is beyond what contacts can be resolved beside: give up to "
            f"{_HEAVIEST:g} m/s²"
        )
    return pull


def warn_of_centres(plan: Plan, names: Sequence[str]) -> None:
    """Warn of bodies whose rebound is not known.

    Parameters
    ----------
    plan : Plan
    names : sequence of str
        Of the bodies, for messages.
    """
    for body, velocity, name in zip(plan.bodies, plan.velocities, names, strict=True):
        if not body.centre_known and (velocity != 0.0 or not body.constrained):
            warn(
                f"{name}: the centre of mass of a body given by K and M alone is known only where "
                "it is free and struck through it; the centre's displacement, its velocity and "
                "what follows from it (rebound_velocity, restitution) are NaN: give the nodes as "
                "well, FEModel(K=, M=, nodes=)"
            )


def warn_of_exchange(projectile: SceneBody, target: SceneBody) -> None:
    """Warn of a finite-element projectile with supports, where the target is free.

    A projectile on springs only is not warned of: it may move as a tup on its guide does.
    """
    tip = projectile.model.touched_at()
    if tip is None or not projectile.constrained or target.fixed or tip.body.nodes is None:
        return
    if tip.body.free is not None and len(tip.body.free) < tip.body.nodes.size:
        warn(
            "projectile moves though supports hold it, and nothing holds the target: it moves as "
            "it would deflect under a force at the contact, and swings back. If it is what is "
            "struck, exchange projectile and target; if it flies, leave its supports (fixed=) out"
        )


def warn_of_places(run: Run, names: Sequence[str]) -> None:
    """Warn of contact points outside the range of the law or the method.

    Single nodes under a law like Hertz's, patches as wide as the body is thick, directions oblique
    to the surface, and bodies on the same side of a point that they share.

    Parameters
    ----------
    run : Run
    names : sequence of str
        Of the bodies, for messages.
    """
    checked = set()
    for contact in run.plan.contacts:
        models = [run.plan.bodies[body].model for body, _ in contact.ports]
        tips = [
            model.touched_at(port) for model, (_, port) in zip(models, contact.ports, strict=True)
        ]
        for tip, (body, _) in zip(tips, contact.ports, strict=True):
            if tip is None or (body, tip) in checked:
                continue
            checked.add((body, tip))
            _warn_of_direction(tip, names[body])
        first, second = tips
        if first is not None and second is not None:
            _warn_of_side(first, second, [names[body] for body, _ in contact.ports])


def _warn_of_direction(tip: ContactPoint, name: str) -> None:
    """Warn of a direction off the normal: only the normal velocity takes part in the contact."""
    if tip.normal is None or tip.direction is None or tip.point is None:
        return
    cosine = min(1.0, abs(float(tip.normal @ tip.direction)))
    if cosine < _OBLIQUE:
        angle = math.degrees(math.acos(cosine))
        warn(
            f"{name} is touched along {plain(tip.direction)}, {angle:.0f}° off the normal of its "
            f"surface at {plain(tip.point)} m: contact is along the normal and without friction, "
            "so this is the impact of bodies that are guided along that direction; if they are "
            "not, leave direction out and give the speed along the normal, "
            f"{cosine:.3g} of it"
        )


def _warn_of_side(first: ContactPoint, second: ContactPoint, names: Sequence[str]) -> None:
    """Warn of bodies on the same side of a common point, if they share coordinates."""
    if first.body is second.body or first.point is None or second.point is None:
        return
    if first.direction is None or second.direction is None or first.body.nodes is None:
        return
    near = _SHARED * float(np.ptp(first.body.nodes, axis=0).max())
    opposite = float(first.direction @ second.direction) < 0.0
    if opposite and np.linalg.norm(first.point - second.point) <= near:
        warn(
            f"{names[0]} and {names[1]} touch at {plain(first.point)} m with outward normals on "
            "the same side: if their coordinates are the same, they are inside each other, and one "
            "is touched on its far side; choose the point that faces the other body"
        )
