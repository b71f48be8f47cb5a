"""Both bodies of an impact as they meet, to be drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import FloatArray, InputError
from ..fields import Shown
from ..mesh import sphere_mesh

if TYPE_CHECKING:
    from .run import Result

# Shown before and after the contact, as shares of its length.
_BEFORE, _AFTER = 0.1, 0.4

# Elements of a rigid ball's picture, over its radius.
_SIZE = 0.35


def times_of_contact(hit: Result, count: int) -> FloatArray:
    """Return times from shortly before the first contact to shortly after the last one, s."""
    if hit.touching is None:
        return np.linspace(0.0, hit.duration, count)
    start, end = hit.touching
    length = end - start
    first, last = max(0.0, start - _BEFORE * length), min(hit.duration, end + _AFTER * length)
    return np.linspace(first, last, count)


def shown_bodies(hit: Result, times: FloatArray) -> tuple[list[Shown], FloatArray]:
    """Return the bodies that can be drawn, and the direction of travel.

    The target stands where its mesh is; the projectile is turned and moved to where it touches it.
    A round projectile without a mesh is drawn as a ball.
    """
    from scipy.spatial.transform import Rotation

    tips: list[Any] = [model.touched_at() for model in hit.plan.bodies]
    meshed = [
        tip if tip is not None and tip.point is not None and tip.body.mesh is not None else None
        for tip in tips
    ]
    main = meshed[1] or meshed[0]
    if main is None:
        raise InputError(
            "movie needs a body of finite elements: make it with FEModel.from_mesh(...), and its "
            "model with antioscillators(tip, n) or leave that to simulate"
        )
    down, place = main.direction, main.point
    bodies = []
    for body, tip in ((hit.target, meshed[1]), (hit.projectile, meshed[0])):
        if tip is None:
            continue
        field = body.field(times)
        points, moved = tip.body.mesh.nodes, field.displacement
        if tip is not main:
            turn = Rotation.align_vectors(down, tip.direction)[0].as_matrix()
            points = (points - tip.point) @ turn.T + place - hit.gap * down
            moved = moved @ turn.T
        bodies.append(Shown(tip.body.mesh, points, moved, field.stress().von_mises))
    surface = hit.plan.bodies[0].surface_at()
    if meshed[0] is None and surface is not None and 0.0 < surface.radii[0] < np.inf:
        radius = surface.radii[0]
        mesh = sphere_mesh(radius, _SIZE * radius)
        way = np.interp(times, hit.t, hit.projectile.centre_displacement)
        if hit.recorder.dense:
            way = hit.at(times).projectile.centre_displacement
        moved = np.repeat((way[:, None] * down)[:, None], mesh.n_nodes, axis=1)
        middle = place - (radius + hit.gap) * down
        bodies.append(Shown(mesh, mesh.nodes + middle, moved, None))
    return bodies, down
