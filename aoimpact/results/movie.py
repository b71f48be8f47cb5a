"""Both bodies of an impact, as they meet, in a moving picture."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, InputError, finite_array, integer, nonnegative, positive
from ..fem import ContactPoint
from ..fields import MovingBody, movie_path, write_movie
from ..mesh import sphere_mesh
from ..reduction import BodyModel

if TYPE_CHECKING:
    from .run import Result


# Shown before and after the contact, as shares of its length.
_BEFORE, _AFTER = 0.1, 0.4

# Elements of a rigid ball's picture, over its radius.
_SIZE = 0.35


def write_impact_movie(
    hit: Result,
    path: str | os.PathLike[str],
    *,
    times: npt.ArrayLike | None,
    frames: int,
    scale: float | None,
    fps: float,
) -> Path:
    """Write a movie of an impact; see `Result.movie`."""
    count = integer("frames", frames, low=2, high=10_000)
    enlarged = None if scale is None else nonnegative("scale", scale)
    speed = positive("fps", fps, unit="Hz")
    wanted = np.linspace(*_span(hit), count)
    if times is not None:
        wanted = np.atleast_1d(finite_array("times", times, unit="s"))
    movie_path(path)
    bodies, down = moving_bodies(hit, wanted)
    return write_movie(path, bodies, wanted, down=down, scale=enlarged, fps=speed)


def _span(hit: Result) -> tuple[float, float]:
    if not hit.contacts:
        return 0.0, hit.duration
    start, end = hit.contacts[0][0], hit.contacts[-1][1]
    length = end - start
    return max(0.0, start - _BEFORE * length), min(hit.duration, end + _AFTER * length)


def moving_bodies(hit: Result, times: FloatArray) -> tuple[list[MovingBody], FloatArray]:
    """Return the bodies that can be drawn, where they meet, and the direction of travel."""
    from scipy.spatial.transform import Rotation

    first, second = (_tip(body) for body in hit.plan.bodies)
    shown = [tip for tip in (second, first) if tip is not None]
    if not shown:
        raise InputError(
            "movie needs a body of finite elements: make it with FEModel.from_mesh(...), and its "
            "model with antioscillators(tip, n) or leave that to simulate"
        )
    down, place = shown[0].direction, shown[0].point
    bodies = []
    if second is not None:
        bodies.append(_body(hit.target, second, times))
    if first is not None:
        turn = Rotation.align_vectors(down, first.direction)[0].as_matrix()
        shift = place - first.point @ turn.T - (hit.gap * down if second is not None else 0.0)
        bodies.append(_body(hit.projectile, first, times, lambda v: v @ turn.T, shift))
    else:
        bodies.extend(_ball(hit, times, place, down))
    return bodies, down


def _tip(model: BodyModel) -> Any:
    """Contact point of a body of finite elements; None of one without a mesh."""
    tip = model.touched_at()
    if tip is None or tip.point is None or tip.direction is None or tip.body.mesh is None:
        return None
    return tip


def _body(
    body: Any,
    tip: ContactPoint,
    times: FloatArray,
    placed: Callable[[FloatArray], FloatArray] = lambda vectors: vectors,
    shift: FloatArray | float = 0.0,
) -> MovingBody:
    field, mesh = body.field(times), tip.body.mesh
    assert mesh is not None
    return MovingBody.of_mesh(mesh, field.displacement, field.stress().von_mises, placed, shift)


def _ball(hit: Result, times: FloatArray, place: FloatArray, down: FloatArray) -> list[MovingBody]:
    """A rigid projectile that is round, before the place where it touches; none of another."""
    surface = hit.plan.bodies[0].surface_at()
    if surface is None or not np.isfinite(surface.radii[0]) or surface.radii[0] <= 0.0:
        return []
    radius = surface.radii[0]
    mesh = sphere_mesh(radius, _SIZE * radius)
    moved = hit.at(times) if hit.recorder.dense else None
    way = (
        np.interp(times, hit.t, hit.projectile.centre_displacement)
        if moved is None
        else moved.projectile.centre_displacement
    )
    displacement = np.broadcast_to((way[:, None] * down)[:, None], (len(times), *mesh.nodes.shape))
    middle = place - (radius + hit.gap) * down
    return [MovingBody.of_mesh(mesh, np.array(displacement), None, shift=middle)]
