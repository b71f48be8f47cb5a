"""Coordinate systems, arcs and rotations of Abaqus decks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy

from ...base import FloatArray
from .inpfile import Keyword

__all__ = ["Frame", "arc", "in_system", "moved"]

# Sine of an angle below which two directions are the same.
_PARALLEL = 1e-9

# Share of a radius by which two nodes of one arc may differ.
_ROUND = 1e-3


@dataclass(frozen=True, eq=False)
class Frame:
    """Rectangular axes: local coordinates x become origin + axes @ x."""

    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    axes: FloatArray = field(default_factory=lambda: np.eye(3))

    @classmethod
    def of(cls, keyword: Keyword) -> Frame:
        """Return the axes of *SYSTEM.

        They are given by their origin, a point on x, and one in the plane of x and y. Without the
        last one z stays as it is, and x is projected; without any, the axes are global again.
        """
        rows = [keyword.reals(i, texts) for i, texts in enumerate(keyword.rows())]
        if len(rows) > 2 or any(len(row) > 6 - 3 * i for i, row in enumerate(rows)):
            raise keyword.error("give the points a and b in one line, and c in the next")
        if not rows:
            return cls()
        first, second = ([*row, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] for row in [*rows, []][:2])
        origin = np.array(first[:3])
        if len(rows[0]) <= 3:
            return cls(origin)
        x, beside = np.array(first[3:6]) - origin, np.array(second[:3]) - origin
        if len(rows) == 1:
            x[2] = 0.0
            beside = np.array([-x[1], x[0], 0.0])
        z = np.cross(x, beside)
        if not np.linalg.norm(z) > _PARALLEL * np.linalg.norm(x) * np.linalg.norm(beside):
            raise keyword.error("the points a, b and c are on one line")
        x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
        return cls(origin, np.column_stack([x, np.cross(z, x), z]))

    def to_global(self, places: FloatArray) -> FloatArray:
        """Return global coordinates, shape (n, 3)."""
        moved: FloatArray = places @ self.axes.T + self.origin
        return moved


def in_system(system: str, places: FloatArray) -> FloatArray:
    """Return rectangular coordinates of nodes.

    Parameters
    ----------
    system : {"R", "C", "S"}
        Rectangular, cylindrical (r, θ, z), or spherical (r, θ, φ).
    places : ndarray, shape (n, 3)
        Angles in degrees; φ is counted from the plane of x and y.
    """
    if system == "R":
        return places
    radius, turn, height = places.T
    turn = np.radians(turn)
    if system == "S":
        rise = np.radians(height)
        radius, height = radius * np.cos(rise), radius * np.sin(rise)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def arc(
    start: FloatArray,
    end: FloatArray,
    share: FloatArray,
    centre: FloatArray | None,
    numbers: Sequence[float],
    frame: Frame,
) -> FloatArray | None:
    """Return places on an arc, shape (n, 3), or None if there is no such arc.

    Parameters
    ----------
    start, end : ndarray, shape (3,)
    share : ndarray, shape (n, 1)
        Of the way from start to end.
    centre : ndarray, shape (3,), or None
        None: it is the first three of `numbers`, in the axes of `frame`.
    numbers : sequence of float
        Coordinates of the centre, and a normal of the arc, needed from 180° on.
    """
    given = [*numbers, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    if centre is None:
        if not numbers:
            return None
        centre = frame.to_global(np.array([given[:3]]))[0]
    arms = start - centre, end - centre
    radii = [float(np.linalg.norm(arm)) for arm in arms]
    normal = frame.axes @ given[3:6] if len(numbers) > 3 else np.cross(*arms)
    size = float(np.linalg.norm(normal))
    least = 0.0 if len(numbers) > 3 else _PARALLEL * radii[0] * radii[1]
    if not (size > least and abs(radii[0] - radii[1]) <= _ROUND * radii[0]):
        return None
    across = np.cross(normal / size, arms[0])
    angle = math.atan2(float(arms[1] @ across), float(arms[1] @ arms[0])) % (2.0 * math.pi)
    if angle < _PARALLEL:
        return None
    places: FloatArray = centre + np.cos(share * angle) * arms[0] + np.sin(share * angle) * across
    return places


def moved(keyword: Keyword, places: FloatArray) -> FloatArray:
    """Return coordinates of an instance by the data lines of *INSTANCE.

    The first is a translation. The second, two points and an angle, turns what has been moved.
    """
    rows = [keyword.reals(i, texts) for i, texts in enumerate(keyword.rows())]
    if len(rows) > 2 or any(len(row) > (3, 7)[i] for i, row in enumerate(rows)):
        raise keyword.error("give a translation, and a rotation by two points and an angle")
    for row in rows[:1]:
        places = places + np.array([*row, 0.0, 0.0, 0.0][:3])
    for row in rows[1:]:
        points = np.array([*row, *[0.0] * 7][:7])
        start, axis = points[:3], points[3:6] - points[:3]
        if not axis.any():
            raise keyword.error("the two points of the axis of rotation are the same")
        turn = scipy.spatial.transform.Rotation.from_rotvec(
            points[6] * axis / np.linalg.norm(axis), degrees=True
        )
        places = turn.apply(places - start) + start
    return places
