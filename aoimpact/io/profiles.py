"""Beam cross-sections of decks, from their dimensions: outlines and section properties.

Dimensions are those of the figures in Abaqus' beam cross-section library and of Nastran's PBARL.
In the figures, axis h points to the right (Abaqus' axis 1, Nastran's z) and axis v upwards (axis 2,
y).
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..base import PRINTED, FloatArray, InputError, record
from ..fem import CircularSection, RectangularSection, TubularSection
from ..mesh import AT_NODE

# `_PLACES`, `_WEIGHTS`: Gauss rule on a panel of the outline. `_COARSER`: factor by which panels
# grow away from a corner. The panels at corners have an eighth of the shortest edge's length, or
# more on very long edges, where `_LEVELS` limits the number of panels. J is then accurate to 1e-4,
# compared with eight points on smaller panels. `_FAR`: distance from a panel's middle, in
# half-lengths, beyond which the rule is exact to 1e-9.
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_COARSER, _LEVELS, _FAR = 4.0, 7, 4.0


@record
class Profile:
    """Properties of a cross-section.

    Axes: h to the right and v upwards in the section's figure in the manual of Abaqus or Nastran.

    Attributes
    ----------
    area, J : float
        Area, m², and torsion constant, m⁴.
    second : ndarray, shape (2, 2)
        Second moments of area ∫r rᵀ dA about the centroid, m⁴.
    compliance : ndarray, shape (2, 2)
        Inverse of the matrix of shear factors; 0 in directions that are rigid in shear.
    points : ndarray, shape (n, 2)
        Points at which stress is evaluated, relative to the centroid, m.
    centre : ndarray, shape (2,)
        Centroid relative to the line of nodes, m.
    skewed : bool
        True if a rotation by 180° changes the section: its shear centre is not the centroid.
    """

    area: float
    second: FloatArray
    J: float
    compliance: FloatArray
    points: FloatArray
    centre: FloatArray
    skewed: bool = False

    def at(self, h: float, v: float) -> Profile:
        """Return the section with the beam's line of nodes through (h, v) of the figure."""
        return replace(self, centre=self.centre - (h, v))


def outlined(start: Any, end: Any, compliance: FloatArray, J: float | None = None) -> Profile:
    """Return the section bounded by straight edges from `start` to `end`, complex h + iv.

    Outer edges run counterclockwise, edges of holes clockwise. Moments of area are integrals of
    polynomials along the outline. J is Saint-Venant's torsion constant unless given.
    """
    length = np.abs(end - start)
    kept = length > PRINTED * length.max()
    start, edge = start[kept, None], (end - start)[kept, None]
    levels = math.ceil(math.log(length.max() / length[kept].min(), _COARSER))
    half = 0.5 * np.append(0.0, _COARSER ** -np.arange(1.0 + min(levels, _LEVELS), -0.5, -1.0))
    ends = start + edge * np.append(half, 1.0 - half[-2::-1])
    first, last = ends[:, :-1].ravel(), ends[:, 1:].ravel()
    step = 0.5 * (last - first)[:, None]
    z = first[:, None] + step * (1.0 + _PLACES)
    flux = (z.conj() * step).imag * _WEIGHTS
    area = 0.5 * float(flux.sum())
    centre = (flux * z).sum() / (3.0 * area)
    z, corners = z - centre, np.unique(start - centre)
    r, flux = np.stack([z.real, z.imag]), (z.conj() * step).imag * _WEIGHTS
    second = np.einsum("pg,ipg,jpg->ij", flux, r, r) / 4.0
    third = np.einsum("pg,ipg,jpg,kpg->ijk", flux, r, r, r) / 5.0
    return Profile(
        area,
        second,
        float(np.trace(second)) - _warped(z, step) if J is None else J,
        compliance,
        np.column_stack([corners.real, corners.imag]),
        np.array([centre.real, centre.imag]),
        bool(np.abs(third).max() > PRINTED * area**2.5),
    )


def _warped(z: Any, step: Any) -> float:
    """Return ∫|∇ω|² dA, m⁴, of the warping function ω: the torsion constant is J = Ip − ∫|∇ω|² dA.

    On the outline ∂ω/∂n = ∂ψ/∂s with ψ = r²/2, so ω + iψ is analytic within, up to a constant at
    each hole, and its Cauchy integral over the outline is πi (ω + iψ) on it. The imaginary part is
    an integral equation for ω, a polynomial on each panel (J. Helsing and R. Ojala, J. Comput.
    Phys. 227, 2899, 2008). The result is ∮ω dψ.

    Parameters
    ----------
    z : ndarray, shape (panels, points)
        Gauss points relative to the centroid, complex.
    step : ndarray, shape (panels, 1)
        Vector from the middle to the end of each panel, complex.
    """
    at = (z[..., None] - z.mean(axis=1)) / step[:, 0]
    own = np.arange(len(z))
    at[own, :, own] = _PLACES
    moments = [np.log((1.0 - at) / (-1.0 - at))]
    moments[0][own, :, own] = moments[0][own, :, own].real  # the principal value
    for k in range(1, len(_PLACES)):
        moments.append(at * moments[-1] + (1.0 - (-1.0) ** k) / k)
    near = np.stack(moments, axis=-1) @ np.linalg.inv(np.vander(_PLACES, increasing=True))
    with np.errstate(divide="ignore", invalid="ignore"):
        far = _WEIGHTS / (_PLACES - at[..., None])
    cauchy = np.where(np.abs(at[..., None]) > _FAR, far, near).reshape(z.size, z.size)
    psi, change = 0.5 * np.abs(z) ** 2, (z.conj() * step).real * _WEIGHTS
    # ω is determined up to a constant; the added matrix makes its mean over all points 0.
    matrix = np.pi * np.eye(z.size) - cauchy.imag + 1.0 / z.size
    return float(np.linalg.solve(matrix, cauchy.real @ psi.ravel()) @ change.ravel())


def filled(*corners: complex) -> Profile:
    """Return a solid convex polygon with shear factors 5/6; corners h + iv, counterclockwise."""
    start, end = np.array(corners), np.roll(corners, -1)
    if ((end - start).conj() * np.roll(end - start, -1)).imag.min() < 0.0:
        raise InputError("its sides must not cross each other")
    return outlined(start, end, 1.2 * np.eye(2))


def rows(*of: tuple[float, ...]) -> Profile:
    """Return a section of rectangles in rows, stacked upwards from v = 0.

    A row is given by its height, then the left and right end h of each rectangle. The shear factor
    along an axis is the ratio of the area of the walls along this axis to the whole area.
    """
    if any(row[0] <= 0.0 or [*row[1:]] != sorted({*row[1:]}) for row in of):
        raise InputError("its walls must have a thickness, and must not overlap")
    cuts = np.unique([h for row in of for h in row[1:]])
    inside = np.array([np.searchsorted(row[1:], 0.5 * (cuts[1:] + cuts[:-1])) % 2 for row in of])
    corners, start, end = cuts + 1j * np.cumsum([0.0, *(row[0] for row in of)])[:, None], [], []
    for axis, first, last in ((0, corners[:, :-1], corners[:, 1:]), (1, corners[1:], corners[:-1])):
        # +1: the section lies above or to the right of the edge; -1: below or to the left.
        change = np.diff(inside, axis=axis, prepend=0, append=0)
        start += [first[change > 0], last[change < 0]]
        end += [last[change > 0], first[change < 0]]
    b, h = np.array([(x, row[0]) for row in of for x in np.diff(row[1:])[::2]]).T
    share = np.bincount(b < h, b * h, 2) / (b @ h)
    return outlined(np.concatenate(start), np.concatenate(end), np.linalg.pinv(np.diag(share)))


def between(outer: tuple[float, ...], inner: tuple[float, ...]) -> Profile:
    """Return the section of three rows of rectangles: `outer`, `inner`, `outer`."""
    return rows(outer, inner, outer)


def flanged(h: float, b1: float, b2: float, t: float, t1: float, t2: float) -> Profile:
    """Return an I section, with flange 1 below and 2 above; T if a flange has zero thickness."""
    web = (h - t1 - t2, -0.5 * t, 0.5 * t)
    flanges = [[(t, -0.5 * b, 0.5 * b)] if t else [] for b, t in ((b1, t1), (b2, t2))]
    return rows(*flanges[0], web, *flanges[1])


def box(b: float, h: float, right: float, top: float, left: float, bottom: float) -> Profile:
    """Return a box section of width b and height h with the given wall thicknesses."""
    web = (h - top - bottom, 0.0, left, b - right, b)
    return rows((bottom, 0.0, b), web, (top, 0.0, b))


def hat(h: float, t: float, top: float, brim: float, base: float = 0.0) -> Profile:
    """Return a hat section, closed by a base plate of thickness `base` if that is not 0."""
    b = top + 2.0 * brim
    wall = (brim, brim + t, b - brim - t, b - brim)
    brims, webs = (t, 0.0, *wall[1:3], b), (h - base - 2.0 * t, *wall)
    return rows(*[(base, 0.0, b)] if base else (), brims, webs, (t, brim, b - brim))


def arbitrary(n: float, *of: float) -> Profile:
    """Return Abaqus' ARBITRARY section of n thin walls.

    The arguments after n are both end points and the thickness of the first wall, then the end
    point and thickness of each further wall. The torsion constant is Σ b t³/3, plus 4 A²/∮ds/t if
    the section is closed (S. P. Timoshenko and J. N. Goodier, Theory of Elasticity, sections 112
    and 115).
    """
    ends = np.array([of[:2], of[2:4], *zip(of[5::3], of[6::3], strict=True)]) @ [1.0, 1.0j]
    start, end, steps, t = ends[:-1], ends[1:], np.diff(ends), np.array(of[4::3])
    b = np.abs(steps)
    J = float(b @ t**3) / 3.0
    if abs(ends[-1] - ends[0]) <= AT_NODE * b.max():  # a closed section
        J += float((start.conj() * steps).imag.sum()) ** 2 / float((b / t).sum())
    e = np.stack([steps.real, steps.imag]) / b
    side = 0.5j * t * steps / b
    corners = np.stack([start - side, end - side, end + side, start + side], axis=1)
    compliance = np.linalg.pinv(np.einsum("w,iw,jw->ij", b * t, e, e) / (b @ t))
    return outlined(corners.ravel(), np.roll(corners, -1, axis=1).ravel(), compliance, J)


def hexagon(radius: float, t: float) -> Profile:
    """Return Abaqus' HEX, a regular hexagonal tube of given circumradius and wall thickness."""
    inner = radius - 2.0 * t / math.sqrt(3.0)
    if not 0.0 <= inner < radius:
        raise InputError("its walls must have a thickness, and must not overlap")
    corners = np.exp(1j * math.pi / 3.0 * np.arange(7))
    start = np.append(radius * corners[:-1], inner * corners[1:])
    return outlined(start, np.append(radius * corners[1:], inner * corners[:-1]), 2.0 * np.eye(2))


# For each program's section names, the function that makes the section from its dimensions. The
# first dimension of RECT is along axis 1, z of `RectangularSection`. The line of nodes of Abaqus' L
# goes through the intersection of the middle lines of its legs.
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
        -0.5 * a, 0.5 * a, 0.5 * c + 1j * b, -0.5 * c + 1j * b
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
    "HEXA": lambda a, b, h: filled(a, b - a, b + 0.5j * h, b - a + 1j * h, a + 1j * h, 0.5j * h),
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
    """Return the number of dimensions of a named section, and the function that makes it."""
    if name not in table:
        known = ", ".join(table)
        raise InputError(f"{name!r} is none of {known}; give its Beam by read_sections(given=)")
    return len(inspect.signature(table[name]).parameters), table[name]
