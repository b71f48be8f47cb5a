"""Cross-sections of decks by their dimensions: polygons, and what they add up to.

Dimensions are those of the figures in Abaqus' beam cross-section library and of Nastran's PBARL.
Their axes: h is Abaqus' axis 1 and Nastran's z, drawn to the right; v is axis 2 and y, upwards.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base import FloatArray, InputError
from ..fem import CircularSection, RectangularSection, TubularSection

# Distance between the ends of a closed ARBITRARY section, over its size, that is rounding; and the
# third moment of an area A, over A^2.5, that is.
_CLOSED, _ROUND = 1e-6, 1e-9


@dataclass(frozen=True, eq=False)
class Profile:
    """A cross-section in its figure's axes h and v.

    Attributes
    ----------
    area, J : float
        m² and m⁴.
    second : ndarray, shape (2, 2)
        ∫r rᵀ dA about the centroid, m⁴.
    compliance : ndarray, shape (2, 2)
        Inverse of the shear factors; 0 where the section is rigid in shear.
    points : ndarray, shape (n, 2)
        Places at which stress is given, from the centroid, m.
    centre : ndarray, shape (2,)
        The centroid, m.
    skewed : bool
        Walls that lie otherwise when turned by 180°: the shear centre is not the centroid.
    """

    area: float
    second: FloatArray
    J: float
    compliance: FloatArray
    points: FloatArray
    centre: FloatArray
    skewed: bool = False

    def at(self, h: float, v: float) -> Profile:
        """Return it as seen from a line of nodes at a place of its figure."""
        return replace(self, centre=self.centre - (h, v))


def filled(polygons: Any, J: float | None = None, compliance: Any = None) -> Profile:
    """Return the section of polygons, shape (n, corners, 2), counted counterclockwise.

    Without J it is compact: J = A⁴/(40 Ip) (A. E. H. Love, Mathematical Theory of Elasticity,
    section 224), and the shear factors are 5/6.
    """
    p = np.array(polygons)
    q = np.roll(p, -1, axis=1)
    double = p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]
    area = 0.5 * float(double.sum())
    centre = np.einsum("nk,nki->i", double, p + q) / (6.0 * area)
    second = sum(np.einsum("nk,nki,nkj->ij", double, of, of) / 24.0 for of in (p, q, p + q))
    second = second - area * np.outer(centre, centre)
    if J is None:
        J, compliance = area**4 / (40.0 * float(np.trace(second))), 1.2 * np.eye(2)
    points = np.unique((p - centre).reshape(-1, 2), axis=0)
    return Profile(area, second, J, compliance, points, centre)


def walls(of: Any, cell: Any = None) -> Profile:
    """Return the section of straight walls.

    The shear factor along an axis is the share of the walls that lie along it. The torsion constant
    is Σ b t³/3, and 4 A²/∮ds/t of a cell (S. P. Timoshenko and J. N. Goodier, Theory of Elasticity,
    sections 112 and 115).

    Parameters
    ----------
    of : array_like, shape (n, 5)
        Ends h, v of the middle line, and thickness.
    cell : (float, float array_like), optional
        Area within the middle line of a closed section, and b/t of the walls about it.
    """
    table = np.reshape([one for one in of if one[4] > 0.0 and one[:2] != one[2:4]], (-1, 5))
    start, end, t = table[:, :2], table[:, 2:4], table[:, 4]
    b = np.linalg.norm(end - start, axis=1)
    e = (end - start) / b[:, None]
    side = 0.5 * t[:, None] * e @ [[0.0, 1.0], [-1.0, 0.0]]
    along = np.einsum("w,wi,wj->ij", b * t, e, e) / (b @ t)
    J = float(b @ t**3) / 3.0 + (4.0 * cell[0] ** 2 / float(sum(cell[1])) if cell else 0.0)
    corners = np.stack([start - side, end - side, end + side, start + side], axis=1)
    found = filled(corners, J, np.linalg.pinv(along))
    r = 0.5 * (start + end) - found.centre
    third = np.einsum("w,wi,wj,wk->ijk", b * t, r, r, r)
    return replace(found, skewed=bool(np.abs(third).max() > _ROUND * found.area**2.5))


def rows(*of: tuple[float, ...], cell: Any = None) -> Profile:
    """Return the section of rectangles: rows from v = 0 upwards, of a height and pairs of h."""
    found, v = [], 0.0
    for height, *sides in of:
        for left, right in zip(sides[::2], sides[1::2], strict=True):
            width, h, middle = right - left, 0.5 * (left + right), v + 0.5 * height
            if height < 0.0 or sides != sorted(sides):
                raise InputError("its walls are thicker than there is room for")
            lying, upright = (left, middle, right, middle, height), (h, v, h, v + height, width)
            found.append(lying if width >= height else upright)
        v += height
    return walls(found, cell)


def between(outer: tuple[float, ...], inner: tuple[float, ...]) -> Profile:
    """Return the section of a row between two equal ones."""
    return rows(outer, inner, outer)


def flanged(h: float, b1: float, b2: float, t: float, t1: float, t2: float) -> Profile:
    """Return an I, or a T if one of the flanges, 1 below and 2 above, is 0."""
    web = (h - t1 - t2, -0.5 * t, 0.5 * t)
    return rows((t1, -0.5 * b1, 0.5 * b1), web, (t2, -0.5 * b2, 0.5 * b2))


def box(b: float, h: float, right: float, top: float, left: float, bottom: float) -> Profile:
    """Return a box by its sides and the thickness of its walls."""
    web = (h - top - bottom, 0.0, left, b - right, b)
    mid_b, mid_h = b - 0.5 * (left + right), h - 0.5 * (top + bottom)
    around = (mid_h / right, mid_b / top, mid_h / left, mid_b / bottom)
    return rows((bottom, 0.0, b), web, (top, 0.0, b), cell=(mid_b * mid_h, around))


def hat(h: float, t: float, top: float, brim: float, base: float = 0.0) -> Profile:
    """Return a hat, on a base or without."""
    b, cell = top + 2.0 * brim, None
    wall = (brim, brim + t, b - brim - t, b - brim)
    if base:
        mid_b, mid_h = top - t, h - 0.5 * (base + t)
        cell = mid_b * mid_h, (2.0 * mid_h / t, mid_b / t, mid_b / base)
    brims, webs = (t, 0.0, *wall[1:3], b), (h - base - 2.0 * t, *wall)
    return rows((base, 0.0, b), brims, webs, (t, brim, b - brim), cell=cell)


def arbitrary(n: float, *of: float) -> Profile:
    """Return Abaqus' ARBITRARY: n, two points and a thickness, then a point and one each."""
    ends = np.array([of[:2], of[2:4], *zip(of[5::3], of[6::3], strict=True)])
    t, steps = np.array(of[4::3]), np.diff(ends, axis=0)
    cell = None
    if np.abs(ends[-1] - ends[0]).max() <= _CLOSED * np.ptp(ends):
        twice = float((ends[:-1, 0] * steps[:, 1] - ends[:-1, 1] * steps[:, 0]).sum())
        cell = 0.5 * twice, np.linalg.norm(steps, axis=1) / t
    return walls(np.column_stack([ends[:-1], ends[1:], t]).tolist(), cell)


def hexagon(radius: float, t: float) -> Profile:
    """Return Abaqus' HEX, a regular ring by its circumscribed circle and its thickness."""
    middle = radius - t / math.sqrt(3.0)
    h, v = middle * np.array([np.cos(of := np.arange(7) * math.pi / 3.0), np.sin(of)])
    return arbitrary(6, h[0], v[0], *np.column_stack([h[1:], v[1:], np.full(6, t)]).ravel())


# Sections by the names of each program. RECT begins with the length along axis 1, which is our z.
# The line of nodes of L is where the middle lines of its legs meet.
ABAQUS: dict[str, Callable[..., Any]] = {
    "ARBITRARY": arbitrary,
    "BOX": lambda a, b, t1, t2, t3, t4: box(a, b, t1, t2, t3, t4).at(0.5 * a, 0.5 * b),
    "CIRC": CircularSection,
    "HEX": hexagon,
    "I": lambda node, h, b1, b2, t1, t2, t: flanged(h, b1, b2, t, t1, t2).at(0.0, node),
    "L": lambda a, b, t, s: rows((t, 0.0, a), (b - t, 0.0, s)).at(0.5 * s, 0.5 * t),
    **dict.fromkeys(("PIPE", "THICKPIPE"), TubularSection),
    **dict.fromkeys(("RECT", "RECTANGULAR"), lambda z, y: RectangularSection(y, z)),
    "TRAPEZOID": lambda a, b, c, node: filled(
        [[(-0.5 * a, 0.0), (0.5 * a, 0.0), (0.5 * c, b), (-0.5 * c, b)]]
    ).at(0.0, node),
}
NASTRAN: dict[str, Callable[..., Any]] = {
    "BAR": RectangularSection,
    "BOX": lambda b, h, t, s: box(b, h, s, t, s, t),
    "BOX1": lambda b, h, top, bottom, right, left: box(b, h, right, top, left, bottom),
    "CHAN": lambda b, h, t, s: between((s, 0.0, b), (h - 2.0 * s, 0.0, t)),
    "CHAN1": lambda b, t, web, h: between((0.5 * (h - web), 0.0, b + t), (web, 0.0, t)),
    "CHAN2": lambda t, s, h, b: rows((s, 0.0, b), (h - s, 0.0, t, b - t, b)),
    "CROSS": lambda b, t, h, s: between((0.5 * (h - s), 0.5 * b, 0.5 * b + t), (s, 0.0, b + t)),
    "H": lambda b, legs, h, s: between(
        (0.5 * (h - s), 0.0, 0.5 * legs, b + 0.5 * legs, b + legs), (s, 0.0, b + legs)
    ),
    "HAT": lambda h, t, top, brim: hat(h, t, top, brim),
    "HAT1": lambda b, h, top, t, base: hat(h, t, top, 0.5 * (b - top), base),
    "HEXA": lambda a, b, h: filled(
        [[(a, 0.0), (b - a, 0.0), (b, 0.5 * h), (b - a, h), (a, h), (0.0, 0.5 * h)]]
    ),
    "I": lambda h, b1, b2, t, t1, t2: flanged(h, b1, b2, t, t1, t2),
    "I1": lambda b, t, web, h: between((0.5 * (h - web), 0.0, b + t), (web, 0.5 * b, 0.5 * b + t)),
    "L": lambda b, h, t, s: rows((t, 0.0, b), (h - t, 0.0, s)),
    "ROD": CircularSection,
    "T": lambda b, h, s, t: flanged(h, 0.0, b, t, 0.0, s),
    "T1": lambda h, b, s, t: between((0.5 * (h - t), b, b + s), (t, 0.0, b + s)),
    "T2": lambda b, h, s, t: flanged(h, b, 0.0, t, s, 0.0),
    "TUBE": lambda outer, inner: TubularSection(outer, outer - inner),
    "TUBE2": TubularSection,
    "Z": lambda b, t, web, h: rows(
        (0.5 * (h - web), 0.0, b + t), (web, 0.0, t), (0.5 * (h - web), -b, t)
    ),
}


def named(table: dict[str, Callable[..., Any]], name: str) -> tuple[int, Callable[..., Any]]:
    """Return the number of a section's dimensions, and how these make it."""
    if name not in table:
        known = ", ".join(table)
        raise InputError(f"{name!r} is none of {known}; give its Beam by read_sections(given=)")
    return len(inspect.signature(table[name]).parameters), table[name]
