"""Scenes in three directions: their axes, and bodies with tangential contact functionals.

The axes are those of the meshes, which must be parallel; without a mesh z is the outward normal of
the second body. All contacts must have one direction of travel, within 5°.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ..base import FloatArray, InputError, plain
from ..contact import ContactPoint
from ..laws import ONE_FRAME
from ..mesh import plane_of
from ..reduction import Body, BodyModel, FullModel, turning

# Smallest cosine of the angle between the direction of travel at a contact point and the normal
# there.
_ALONG = math.cos(math.radians(1.0))

# Sign of the side on which a body is touched: ROLES[0] for the first body of a contact, ROLES[1]
# for the second.
ROLES = (1.0, -1.0)

# Direction of travel if no body has a mesh: against the outward normal of the second body, z.
_DOWN = np.array([0.0, 0.0, -1.0])


def axes_of(ends: Iterable[Sequence[tuple[str, BodyModel, int]]]) -> FloatArray:
    """Return the direction of travel and two tangents, as rows, shape (3, 3).

    The tangents are the mesh's axes projected on the plane of the contact.

    Parameters
    ----------
    ends : iterable of (name, model, port)
        First and second body of each contact.

    Raises
    ------
    InputError
        If contacts differ in their direction of travel, or two bodies are touched on the same side.
    """
    found: FloatArray | None = None
    for both in ends:
        first, second = both
        tips = [model.touched_at(port) for _, model, port in both]
        normals = [tip.normal for tip in tips if tip is not None and tip.normal is not None]
        if len(normals) == 2 and normals[0] @ normals[1] > 0.0:
            raise InputError(
                f"{first[0]} and {second[0]} are touched on the same side, with the normals "
                f"{plain(normals[0])} and {plain(normals[1])}; turn the mesh of one"
            )
        for name, model, port in reversed(both):
            tip = model.touched_at(port)
            if tip is None:
                continue
            along = _direction(name, tip)
            if found is None:
                found = along
                if both[-1][0] != name and tip.normal is not None:  # points out of the first body
                    found = math.copysign(1.0, along @ tip.normal) * along
            elif abs(float(along @ found)) < ONE_FRAME:
                raise InputError(
                    f"{name}: its direction of travel {plain(along)} is not that of the other "
                    f"bodies, {plain(found)}; turn its mesh, or give the speed alone"
                )
    along = _DOWN if found is None else found
    tangents = plane_of(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    return np.vstack([along, tangents])


def _direction(name: str, tip: ContactPoint) -> FloatArray:
    """Return a contact point's direction; raise InputError if it is not along the normal."""
    if tip.direction is None or tip.thin is not None:
        why = (
            "it has none" if tip.direction is None else "shells and beams have no such contact yet"
        )
        raise InputError(
            f"{name}: friction needs the directions along the surface, and {why}; make the body of "
            "solid elements, by FEModel.from_mesh(...).contact(point=...)"
        )
    if tip.normal is not None and abs(float(tip.direction @ tip.normal)) < _ALONG:
        raise InputError(
            f"{name}: direction {plain(tip.direction)} is not along the normal "
            f"{plain(tip.normal)}; with friction leave direction out, and give velocity as a vector"
        )
    return tip.direction


def with_tangents(model: BodyModel, axes: FloatArray) -> BodyModel:
    """Return a finite-element body whose contact points have tangents, the directions of friction.

    The two unit tangents are aligned with rows 1 and 2 of `axes`. Other models are returned
    unchanged.
    """
    if not isinstance(model, FullModel):
        return model
    tips = []
    for tip in model.tips:
        tangents = plane_of(tip.direction, axes[1])
        tangents[1] *= math.copysign(1.0, tangents[1] @ axes[2])
        tips.append(replace(tip, tangents=tangents))
    return replace(model, tips=tuple(tips))


def with_functionals(
    name: str, model: BodyModel, axes: FloatArray, roles: Sequence[float]
) -> BodyModel:
    """Return a body with three ports, a normal and two tangents, for each contact point.

    Parameters
    ----------
    name : str
        Name of the body, for messages.
    model : BodyModel
        Model whose contact points, if any, have tangents.
    axes : ndarray, shape (3, 3)
        Direction of travel and two tangents, as rows.
    roles : sequence of float
        Sides on which a rigid body is touched: a value of `ROLES` for each contact point.
    """
    if isinstance(model, FullModel):
        tips = [one for tip in model.tips for one in tip.functionals]
        return replace(model, tips=tuple(tips))
    assert isinstance(model, Body)
    if model.numbers is not None and model.kind in ("rigid", "wall"):
        return turning(model.numbers, axes, roles or ROLES[:1])
    given = [tip.tangents for tip in model.tips[::3]]  # set by an earlier oblique impact
    if given and all(one is not None and np.allclose(one, axes[1:], atol=0.1) for one in given):
        return model
    raise InputError(
        f"{name}: {model!r} moves along one direction only; for friction give its contact point "
        "(body.contact(point=...)), full(...) of it, ball(...) or rigid(mass, inertia=)"
    )
