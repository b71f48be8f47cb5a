"""Checks that an impact and a scene share: durations, speeds, known centres of mass."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from weakref import WeakKeyDictionary, WeakSet

from ..base import InputError, positive, real, warn
from ..fem import ContactPoint
from ..laws import HertzianLaw, own_law
from ..reduction import AOModel, touched
from ..results import Run
from ..scene import Plan

__all__ = ["checked_duration", "checked_speed", "warn_of_centres", "warn_of_nodes"]

# m/s; squares and energies of speeds beyond these overflow, or vanish.
_SLOWEST, _FASTEST = 1e-60, 1e60

# s; its cube is a number, and so is the distance that the fastest body covers.
_LONGEST = 1e100

# Contact points that have been warned of, once is enough for each, and what was found of them.
_told_of: WeakSet[ContactPoint] = WeakSet()
_node_errors: WeakKeyDictionary[ContactPoint, float | None] = WeakKeyDictionary()


def checked_duration(duration: Any) -> float:
    """Return the length of a record, s, over which displacements are numbers."""
    length = positive("duration", duration, unit="s")
    if length > _LONGEST:
        raise InputError(f"duration={length:g} s is beyond what can be computed: {_LONGEST:g} s")
    return length


def checked_speed(name: str, value: Any) -> float:
    """Return a speed, m/s, whose square is a number.

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


def warn_of_nodes(run: Run, names: Sequence[str]) -> None:
    """Warn of bodies that a Hertz-like law touches at a single node or point of their mesh.

    Parameters
    ----------
    run : Run
    names : sequence of str
        Of the bodies, for messages.
    """
    for contact in run.plan.contacts:
        if not isinstance(own_law(contact.law), HertzianLaw):
            continue
        for body, port in contact.ports:
            model = run.plan.bodies[body].model
            tip = touched(model, port)
            if isinstance(model, AOModel) and model.n == 0:
                continue  # it has no indentation of its own
            if tip is None or tip.patch or tip.body.mesh is None or tip in _told_of:
                continue
            if tip not in _node_errors:
                _node_errors[tip] = run.error.contact
            error = _node_errors[tip]
            off = "" if error is None else f", here by some {100.0 * error:.2g} %"
            told = warn(
                f"{names[body]} is touched at a single {'point' if tip.node is None else 'node'}: "
                "its own indentation follows the mesh, and the law contains that of the real body "
                f"already, so the force is too small{off}; leave radius out, or give the radius of "
                "a patch"
            )
            if told:
                _told_of.add(tip)
