"""Beam elements of two nodes with six degrees of freedom at each, and their cross-sections.

The interpolation solves the equations of Timoshenko's beam without distributed load, so that nodal
displacements under static nodal loads are exact. The consistent mass includes rotary inertia
(Z. Friedman and J. B. Kosmatka, Computers & Structures 47, 473, 1993).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..base import (
    PRINTED,
    ArrayPair,
    FloatArray,
    InputError,
    checked,
    finite_array,
    positive,
    sequence,
    within,
)
from ..mesh import AT_NODE, unit
from .laminate import FAR_OFF, direction_or_none
from .material import Material

# Places, from -1 to 1, and weights of Gauss' rule along an element, exact for the square of
# displacements, which are cubic in x.
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(4)

_length = partial(positive, unit="m")

# Intervals n per half side of a rectangle between the points where stress is evaluated. The maximum
# of a parabola that falls to 0 within half a side is missed by at most 1/(2 n)² = 0.4 %.
_HALF_A_SIDE = 8

# Terms n of the series for the torsion of a rectangle. The last term is 1e-9 of the first one for
# the torsion constant J, and 6e-6 for the stress.
_TERMS = np.arange(1, 400, 2)


@dataclass(frozen=True)
class BeamSection:
    """A cross-section given by its area and moments, with principal axes y and z at its centroid.

    Parameters
    ----------
    area : float
        Cross-sectional area, m².
    Iy, Iz : float
        Second moments of area ∫z² dA and ∫y² dA, m⁴. Iy resists deflection along z.
    J : float
        Torsion constant, m⁴.
    shear_factors : (float, float), optional
        Ratios of the shear areas along y and along z to `area`. Infinity makes the section rigid in
        shear, as in Euler-Bernoulli theory, but with rotary inertia.
    points : array_like, shape (n, 2), optional
        Points (y, z) at which stress is evaluated, m.

    Examples
    --------
    An I-section, 100 mm high:

    >>> BeamSection(area=1.03e-3, Iy=1.71e-6, Iz=1.59e-7, J=1.2e-8, shear_factors=(0.55, 0.38)).area
    0.00103
    """

    area: float
    Iy: float
    Iz: float
    J: float
    shear_factors: tuple[float, float] = (5.0 / 6.0, 5.0 / 6.0)
    points: Any = ((0.0, 0.0),)

    def __post_init__(self) -> None:
        checked(self, area=positive, Iy=positive, Iz=positive, J=positive, points=_points)
        given = enumerate(sequence("shear_factors", self.shear_factors))
        factors = [positive(f"shear_factors[{i}]", one, infinite=True) for i, one in given]
        if len(factors) != 2 or any(1.0 < one < math.inf for one in factors):
            raise InputError(f"shear_factors must be two in (0, 1], or infinite, got {factors}")
        object.__setattr__(self, "shear_factors", tuple(factors))

    curvature = 0.0  # circumferential curvature of the outer surface, 1/m: taken as flat

    def extremes(self, strains: FloatArray) -> FloatArray:
        """Return the section's `points`, where stress may be largest.

        :meta private:
        """
        return np.array(self.points)

    def shear(self, points: FloatArray, nu: float) -> FloatArray:
        """Return zero shear stress, as the shape of the section is not known.

        :meta private:
        """
        return np.zeros((*points.shape, 3))

    def with_nu(self, nu: float) -> BeamSection:
        """Return the section's area, moments and shear factors for Poisson's ratio ν.

        :meta private:
        """
        return self


@dataclass(frozen=True)
class RectangularSection:
    """A full rectangular cross-section.

    Parameters
    ----------
    width, height : float
        Dimensions along y and z, m.

    Examples
    --------
    >>> RectangularSection(width=0.02, height=0.04).height
    0.04
    """

    width: float
    height: float

    def __post_init__(self) -> None:
        checked(self, width=_length, height=_length)

    curvature = 0.0  # circumferential curvature of the outer surface, 1/m

    def extremes(self, strains: FloatArray) -> FloatArray:
        """Return points (y, z) on the sides where stress may be largest, m, shape (n, 2).

        Combined bending and torsion may put the maximum anywhere on the sides.

        :meta private:
        """
        along = np.linspace(-1.0, 1.0, 2 * _HALF_A_SIDE + 1)
        one = np.ones_like(along)
        ways = [(along, -one), (along, one), (-one, along), (one, along)]
        return 0.5 * np.hstack(ways).T * (self.width, self.height)

    def shear(self, points: FloatArray, nu: float) -> FloatArray:
        """Return the shear stresses τxy and τxz at points (y, z), as an array (n, 2, 3).

        Last axis: stress due to Gθ' = 1, to a unit shear force along y, and to one along z.
        Torsion: Saint-Venant's series (S. P. Timoshenko and J. N. Goodier, Theory of Elasticity,
        section 109). Shear forces: Zhuravskii's parabolic distribution.

        :meta private:
        """
        b, h = self.width, self.height
        y, z = points.T
        found = np.zeros((len(points), 2, 3))
        if b <= h:
            found[:, 0, 0], found[:, 1, 0] = _rectangle_twisted(y, z, b, h)
        else:  # the series is for a short side along y
            along_z, along_y = _rectangle_twisted(z, -y, h, b)
            found[:, 0, 0], found[:, 1, 0] = -along_y, along_z
        found[:, 0, 1] = 1.5 * (1.0 - (2.0 * y / b) ** 2) / (b * h)
        found[:, 1, 2] = 1.5 * (1.0 - (2.0 * z / h) ** 2) / (b * h)
        return found

    def with_nu(self, nu: float) -> BeamSection:
        """Return area, moments and Cowper's shear factor (J. Appl. Mech. 33, 335, 1966).

        :meta private:
        """
        b, h = self.width, self.height
        long, short = max(b, h), min(b, h)
        series = float((np.tanh(0.5 * np.pi * _TERMS * long / short) / _TERMS**5).sum())
        J = long * short**3 / 3.0 * (1.0 - 192.0 / np.pi**5 * short / long * series)
        factor = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
        corners = [(y * b, z * h) for y, z in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
        return BeamSection(b * h, b * h**3 / 12.0, b**3 * h / 12.0, J, (factor, factor), corners)


@dataclass(frozen=True)
class TubularSection:
    """A round tubular cross-section.

    Parameters
    ----------
    radius : float
        Outer radius, m.
    thickness : float
        Wall thickness, m; at most the radius.

    Examples
    --------
    >>> TubularSection(radius=0.015, thickness=1e-3).thickness
    0.001
    """

    radius: float
    thickness: float

    def __post_init__(self) -> None:
        checked(self, radius=_length, thickness=_length)
        if self.thickness > self.radius:
            most = f"at most radius={self.radius:g} m"
            raise InputError(f"thickness must be {most}, got {self.thickness:g} m")

    @property
    def curvature(self) -> float:
        """Circumferential curvature of the outer surface, 1/m.

        :meta private:
        """
        return 1.0 / self.radius

    def extremes(self, strains: FloatArray) -> FloatArray:
        """Return points (y, z) where stress may be largest, m, shape (..., 6, 2).

        Two outer points lie in the plane of bending; four, outside and inside, on the neutral axis.
        The inner points of a full circle are its centre, where shear is largest.

        :meta private:
        """
        outwards = np.stack([-strains[..., 2], strains[..., 1]], axis=-1)
        bent = outwards.any(axis=-1, keepdims=True)
        outwards = np.where(bent, unit(outwards), [1.0, 0.0])
        across = np.stack([-outwards[..., 1], outwards[..., 0]], axis=-1)
        sides = self.radius * np.stack([outwards, -outwards, across, -across], axis=-2)
        inside = (self.radius - self.thickness) * np.stack([across, -across], axis=-2)
        return np.concatenate([sides, inside], axis=-2)

    def shear(self, points: FloatArray, nu: float) -> FloatArray:
        """Return the shear stresses τxy and τxz at points (y, z), as an array (..., 2, 3).

        Last axis: stress due to Gθ' = 1, to a unit shear force along y, and to one along z. Exact
        flexure of a hollow circle by Saint-Venant (A. E. H. Love, Mathematical Theory of
        Elasticity, section 231). In the bore: zero torsion, and the section's mean shear stress.

        :meta private:
        """
        R, r = self.radius, self.radius - self.thickness
        y, z = np.moveaxis(points, -1, 0)
        square = y**2 + z**2
        bore = square < (r * (1.0 - PRINTED)) ** 2
        inner = R * R * r * r / np.where(square > 0.0, square, 1.0) ** 2 if r else 0.0 * square
        kappa, second = 0.75 + 0.5 * nu, 0.25 * np.pi * (R**4 - r**4)
        found = np.zeros((*points.shape, 3))
        found[..., 0, 0], found[..., 1, 0] = -z, y
        for force, along, other in ((0, y, z), (1, z, y)):
            main = kappa * (R * R + r * r + inner * (other**2 - along**2))
            main -= kappa * along**2 + (0.25 - 0.5 * nu) * other**2
            found[..., force, 1 + force] = main
            found[..., 1 - force, 1 + force] = -(2.0 * kappa * inner + 0.5 + nu) * y * z
        found[..., 1:] /= 2.0 * (1.0 + nu) * second
        found[bore] = 0.0
        found[bore, :, 1:] = np.eye(2) / (np.pi * (R * R - r * r))
        return found

    def with_nu(self, nu: float) -> BeamSection:
        """Return area, moments and Cowper's shear factor (J. Appl. Mech. 33, 335, 1966).

        :meta private:
        """
        R, r = self.radius, self.radius - self.thickness
        m2 = (r / R) ** 2
        both = (1.0 + m2) ** 2
        factor = 6.0 * (1.0 + nu) * both / ((7.0 + 6.0 * nu) * both + (20.0 + 12.0 * nu) * m2)
        second = 0.25 * math.pi * (R**4 - r**4)
        points = ((R, 0.0), (0.0, R), (-R, 0.0), (0.0, -R))
        area = math.pi * (R**2 - r**2)
        return BeamSection(area, second, second, 2.0 * second, (factor, factor), points)


@dataclass(frozen=True)
class CircularSection(TubularSection):
    """A full circular cross-section.

    Parameters
    ----------
    radius : float
        Radius, m.

    Examples
    --------
    >>> CircularSection(radius=0.01)
    CircularSection(radius=0.01)
    """

    thickness: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness", self.radius)
        super().__post_init__()


Section = BeamSection | RectangularSection | TubularSection


@dataclass(frozen=True)
class Beam:
    """A cross-section and its material, for the line elements of a mesh.

    Parameters
    ----------
    section : RectangularSection, CircularSection, TubularSection or BeamSection
    material : Material
    orientation : array_like, shape (3,), optional
        Direction whose projection onto the cross-section is the section's z axis; y = z × x, with x
        from the first node to the second. Optional for round sections, and for a `BeamSection` with
        equal values along both axes and no points off the centroid.
    offset : (float, float), optional
        Position (y, z) of the section's centroid relative to the nodes, m. Example: for a stiffener
        on a shell, half the sum of both heights.

    Examples
    --------
    >>> from aoimpact.fem import Material
    >>> alu = Material(E=70e9, nu=0.33, rho=2700)
    >>> beam = Beam(RectangularSection(0.02, 0.01), alu, orientation=(0, 0, 1))
    >>> round(float(beam.inertia[0]), 3)  # kg/m
    0.54
    """

    section: Section
    material: Material
    orientation: Any = None
    offset: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        kinds = (BeamSection, RectangularSection, TubularSection)
        checked(self, section=kinds, material=(Material,), orientation=direction_or_none)
        along = finite_array("offset", self.offset, shape=(2,), unit="m").tolist()
        most = FAR_OFF * math.sqrt(self.section.with_nu(self.material.nu).area)
        offset = tuple(within(f"offset[{i}]", one, -most, most) for i, one in enumerate(along))
        object.__setattr__(self, "offset", offset)
        if self.orientation is None:
            of = self.section
            alike = isinstance(of, TubularSection)
            if isinstance(of, BeamSection):
                y, z = of.shear_factors
                alike = of.Iy == of.Iz and y == z and not np.any(of.points)
            if not alike or any(self.offset):
                raise InputError("orientation: the section needs the direction of its z axis")

    @property
    def rho(self) -> float:
        """Density, kg/m³."""
        return self.material.rho

    @cached_property
    def numbers(self) -> BeamSection:
        """Area, moments and shear factors of the section, for this material's Poisson's ratio."""
        return self.section.with_nu(self.material.nu)

    @property
    def stiffness(self) -> FloatArray:
        """EA, EIy, EIz, GJ and the shear stiffness along y and z, in N and N m², shape (6,).

        Shear stiffness is infinite where the section is rigid in shear.
        """
        of, E, G = self.numbers, self.material.E, self.material.shear_modulus
        y, z = of.shear_factors
        return np.array(
            [E * of.area, E * of.Iy, E * of.Iz, G * of.J, y * G * of.area, z * G * of.area]
        )

    @property
    def inertia(self) -> FloatArray:
        """Mass and moments of inertia about x, y, z, each per length, kg/m and kg m, shape (4,)."""
        of = self.numbers
        return self.material.rho * np.array([of.area, of.Iy + of.Iz, of.Iy, of.Iz])

    @property
    def hollow(self) -> bool:
        """True for a tube with a bore.

        :meta private:
        """
        of = self.section
        return isinstance(of, TubularSection) and of.thickness < of.radius

    @property
    def narrowest(self) -> float:
        """Wall thickness of a tube, otherwise the smallest dimension of the section, m.

        For a `BeamSection` the square root of its area.

        :meta private:
        """
        of = self.section
        if isinstance(of, TubularSection):
            return of.thickness if self.hollow else 2.0 * of.radius
        return min(of.width, of.height) if isinstance(of, RectangularSection) else of.area**0.5

    @property
    def reach(self) -> float:
        """Largest distance of the section's points from the nodes, m.

        :meta private:
        """
        return float(np.linalg.norm(np.add(self.numbers.points, self.offset), axis=1).max())

    def side(self, name: str) -> tuple[float, float]:
        """Return the outermost point (y, z) on an axis of the section, m, at a named side.

        "top" and "bottom" lie on z, "left" and "right" on y; other names give the centroid.

        :meta private:
        """
        low, high = (of(self.numbers.points, axis=0).tolist() for of in (np.min, np.max))
        along_z = {"bottom": low[1], "top": high[1]}
        along_y = {"right": low[0], "left": high[0]}
        return along_y.get(name, 0.0), along_z.get(name, 0.0)

    def holds(self, place: tuple[float, float]) -> bool:
        """Return whether a point (y, z), m, lies in the section.

        This is exact for round sections. Any other is replaced by the smallest box, symmetric about
        the axes y and z, that contains its `points`.

        :meta private:
        """
        most = np.abs(self.numbers.points).max(axis=0) * (1.0 + PRINTED)
        if isinstance(self.section, TubularSection):
            bore = self.section.radius - self.section.thickness
            away = math.hypot(*place)
            return bore * (1.0 - PRINTED) <= away <= self.section.radius * (1.0 + PRINTED)
        return bool((np.abs(place) <= most).all())

    def stress(self, strains: FloatArray, place: tuple[float, float] | None = None) -> FloatArray:
        """Return σxx = N/A + My z/Iy - Mz y/Iz, τxy and τxz; see `shear` of the section.

        Parameters
        ----------
        strains : ndarray, shape (..., 6)
            Generalised strains; see `beam_rows`.
        place : (float, float), optional
            Point (y, z), m; by default the point with the largest von Mises stress.

        Returns
        -------
        ndarray, shape (..., 3)
            Stress, Pa.

        :meta private:
        """
        points = self.section.extremes(strains) if place is None else np.array([place])
        y, z = np.moveaxis(points, -1, 0)
        stretch, bent_y, bent_z = (strains[..., i, None] for i in range(3))
        direct = self.material.E * (stretch + bent_y * z - bent_z * y)
        forces = strains[..., 3:] * [self.material.shear_modulus, *_finite(self.stiffness[4:])]
        sheared = np.einsum(
            "...ncl,...l->...nc", self.section.shear(points, self.material.nu), forces
        )
        stress = np.concatenate([direct[..., None], sheared], axis=-1)
        size = stress**2 @ [1.0, 3.0, 3.0]  # von Mises' stress squared
        largest = size.argmax(axis=-1)[..., None, None]
        return np.take_along_axis(stress, largest, axis=-2)[..., 0, :]


def beam_frames(ends: FloatArray, beam: Beam) -> ArrayPair:
    """Return the elements' axes x (along the beam), y, z as rows, (n, 3, 3), and their lengths."""
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    x = along / length[:, None]
    if beam.orientation is None:
        z = np.eye(3)[np.abs(x).argmin(axis=1)]
    else:
        axis = np.array(beam.orientation)
        z = np.broadcast_to(axis / np.linalg.norm(axis), x.shape)
    y = np.cross(z, x)
    size = np.linalg.norm(y, axis=1)
    if count := np.count_nonzero(size < AT_NODE):
        raise InputError(
            f"orientation={beam.orientation} is along {count} elements; take one across them"
        )
    y /= size[:, None]
    return np.stack([x, y, np.cross(x, y)], axis=1), length


def beam_matrices(ends: FloatArray, beam: Beam) -> list[FloatArray]:
    """Return stiffness and consistent mass of elements with ends (n, 2, 3), each (n, 12, 12)."""
    frames, length = beam_frames(ends, beam)
    of_strain, of_motion = beam.stiffness, beam.inertia[[0, 0, 0, 1, 2, 3]]
    found = []
    motions = _rows(frames, length, beam, 0.5 + 0.5 * _PLACES)
    for rows, density in zip(motions[::-1], (of_strain, of_motion), strict=True):
        scale = np.sqrt(0.5 * length[:, None, None] * _WEIGHTS[:, None] * _finite(density))
        scaled = (rows * scale[..., None]).reshape(len(rows), -1, 12)
        matrix = scaled.swapaxes(1, 2) @ scaled
        found.append(0.5 * (matrix + matrix.swapaxes(1, 2)))
    return found


def beam_rows(ends: FloatArray, beam: Beam, places: FloatArray) -> FloatArray:
    """Return the matrices from nodal (u, v, w, θx, θy, θz) to strains at places, 0 to 1 along x.

    Returns
    -------
    ndarray, shape (n, n_places, 6, 12)
        Rows: ε, the curvatures θy' and θz', the twist θx', and the shear strains γxy and γxz.
    """
    return _rows(*beam_frames(ends, beam), beam, places)[1]


def beam_motion(ends: FloatArray, beam: Beam, place: float) -> FloatArray:
    """Return the displacement of the axis at a place, 0 to 1 along an element, per nodal dof.

    Returns
    -------
    ndarray, shape (3, 2, 2, 3)
        Axes: component of the displacement; node; displacement (0) or rotation (1) of the node;
        component of the latter.
    """
    frames, length = beam_frames(ends, beam)
    rows = _rows(frames, length, beam, np.array([place]))[0][0, 0, :3]
    return np.asarray((frames[0].T @ rows).reshape(3, 2, 2, 3))


def _finite(stiffness: FloatArray) -> FloatArray:
    """Return the stiffness with infinite entries set to 0: their strains are 0, without energy."""
    return np.where(np.isinf(stiffness), 0.0, stiffness)


# Matrix from the coefficients of the cubic deflection v(x/L) to (v, θ L) at both ends of an element
# that is rigid in shear.
_AT_ENDS = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, 1, 1, 1], [0, 1, 2, 3]], dtype=np.float64)


def _rows(frames: FloatArray, length: FloatArray, beam: Beam, places: FloatArray) -> ArrayPair:
    """Return the matrices from nodal dofs to motions (u, θ) and to strains, (n, n_places, 6, 12).

    Motions and strains are in the element's axes, nodal dofs in the global axes. Places run from 0
    to 1 along an element.
    """
    moved, strain = (np.zeros((len(length), len(places), 6, 12)) for _ in range(2))
    for end, share, slope in ((0, 1.0 - places, -1.0 / length), (6, places, 1.0 / length)):
        for row in (0, 3):  # stretch and twist are linear
            moved[:, :, row, end + row] = share
            strain[:, :, row, end + row] = slope[:, None]
    L, one = length, np.ones_like(length)
    powers = places[:, None] ** np.arange(4)
    first, second = powers[:, [0, 0, 1, 2]] * [0, 1, 2, 3], powers[:, [0, 0, 0, 1]] * [0, 0, 2, 6]
    _, bent_y, bent_z, _, shear_y, shear_z = beam.stiffness
    # Deflection along y with θz, then along z with -θy. A cubic with v' = θ + γ interpolates v
    # and θ of both ends.
    for v, rotation, sign, bent, shear in (
        (1, 5, 1.0, bent_z, shear_y),
        (2, 4, -1.0, bent_y, shear_z),
    ):
        phi = 12.0 * bent / (shear * L * L)
        at_ends = np.tile(_AT_ENDS, (len(L), 1, 1))
        at_ends[:, [1, 3], 3] += 0.5 * phi[:, None]
        by_ends = np.stack([one, sign * L, one, sign * L], axis=1)
        cubic = np.linalg.inv(at_ends) * by_ends[:, None]
        sheared = (-0.5 * phi / L)[:, None, None] * cubic[:, 3:]
        deflection, slope, curvature = (
            by @ cubic / L[:, None, None] ** order
            for order, by in enumerate((powers, first, second))
        )
        ends = [v, rotation, 6 + v, 6 + rotation]
        moved[:, :, v, ends], strain[:, :, 3 + v, ends] = deflection, sheared
        moved[:, :, rotation, ends] = sign * (slope - sheared)
        strain[:, :, 3 - v, ends] = sign * curvature
    return _global(moved, frames, beam), _global(strain, frames, beam)


def _global(rows: FloatArray, frames: FloatArray, beam: Beam) -> FloatArray:
    """Transform rows for centroid motions in beam axes to rows for nodal dofs in global axes."""
    turned = rows.reshape(*rows.shape[:3], 2, 2, 3) @ frames[:, None, None, None]
    if any(beam.offset):  # displacement of the centroid: u + θ × d
        d = np.einsum("i,nij->nj", beam.offset, frames[:, 1:])
        turned[..., 1, :] += np.cross(d[:, None, None, None], turned[..., 0, :])
    return turned.reshape(*rows.shape[:3], 12)


def _rectangle_twisted(y: FloatArray, z: FloatArray, short: float, long: float) -> ArrayPair:
    """Return the torsional stresses τxy/Gθ' and τxz/Gθ', m, in a rectangle; y: short side."""
    n, half = _TERMS * np.pi / short, 0.5 * long
    alternating = 4.0 * short * 2.0 / np.pi**2 / _TERMS**2 * np.sin(0.5 * np.pi * _TERMS)
    above, below = (np.exp(n * (sign * z[:, None] - half)) for sign in (1.0, -1.0))
    share = alternating / (1.0 + np.exp(-2.0 * n * half))
    along_y = -(share * (above - below) * np.cos(n * y[:, None])).sum(axis=1)
    along_z = 2.0 * y - (share * (above + below) * np.sin(n * y[:, None])).sum(axis=1)
    return along_y, along_z


def _points(name: str, value: Any) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in finite_array(name, value, shape=(None, 2)).tolist())
