"""Units, plies and common directions of elements, for the readers of both formats."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import field
from typing import Any, get_args

import numpy as np
from scipy.spatial.transform import Rotation

from ..base import FloatArray, InputError, InputTypeError, IntArray, MeshError, record
from ..fem import (
    Beam,
    BeamSection,
    Laminate,
    Material,
    OneMaterial,
    Orthotropic,
    Ply,
    Shell,
    Solid,
)
from ..mesh import dot, unit
from .abaqusdeck import key
from .profiles import Profile
from .raw import RawMesh

# Largest difference between directions that are the same: what printed digits leave.
_SAME = 1e-4

# Sine of an angle below which two directions are the same.
PARALLEL = 1e-9

# Product of inertia over the polar moment that is rounding.
_ROUND = 1e-12

# Kinds of sections by the dimension of their elements.
_KINDS: dict[int, tuple[type[Any], ...]] = {3: get_args(Solid), 2: (Shell, Laminate), 1: (Beam,)}

# ν13 and ν23 of fabrics: ν23 of all four unidirectional carbon and glass epoxies of P. D. Soden,
# M. J. Hinton and A. S. Kaddour, Compos. Sci. Technol. 58, 1011 (1998), table 1.
_NU_ACROSS = 0.4


@record
class Source:
    """A deck, its units in SI, and what its user says of it.

    Attributes
    ----------
    raw : RawMesh
    length, stress, density : float
        m, Pa and kg/m³.
    given : mapping of str to Material, Orthotropic, Shell, Laminate or Beam
        By names in capitals without blanks.
    left_out : list of str
        Is said in one warning.
    taken : set of str
        Names of `given` that the deck has.
    wanted : dict of str to types
        Kinds that the deck has of names in `given` that are of another.
    """

    raw: RawMesh
    length: float
    stress: float
    density: float
    given: Mapping[str, OneMaterial]
    left_out: list[str] = field(default_factory=list)
    taken: set[str] = field(default_factory=set)
    wanted: dict[str, tuple[type[Any], ...]] = field(default_factory=dict)

    def instead(self, name: str, dim: int = 3) -> Any:
        """Return what is given in place of a section of 1 to 3 dimensions, or of a material."""
        kinds = _KINDS.get(dim, ())
        if (given := self.given.get(at := key(name))) is None:
            return None
        if not isinstance(given, kinds):
            self.wanted[at] = kinds
            return None
        self.taken.add(at)
        return given

    def isotropic(self, E: float, nu: float, rho: float) -> Material:
        """Return the material of constants in the deck's units."""
        return Material(E * self.stress, nu, rho * self.density)

    def orthotropic(self, *of: float) -> Orthotropic:
        """Return that of E1, E2, E3, ν12, ν13, ν23, G12, G13, G23, rho in the deck's units."""
        E1, E2, E3, G12, G13, G23 = (self.stress * of[i] for i in (0, 1, 2, 6, 7, 8))
        return Orthotropic(
            (E1, E2, E3), (G12, G13, G23), (of[3], of[4], of[5]), of[9] * self.density
        )

    def ply(self, *of: float) -> Orthotropic:
        """Return that of E1, E2, ν12, G12, G13, G23, rho, with a rule for E3.

        Fibres along 1 in a matrix are isotropic across the fibres: E3 = E2, ν23 = E2/(2 G23) - 1.
        Strain energy is then positive if 1 - ν23 > 2 ν12² E2/E1. A ply for which it is not has
        fibres along 2 as well, as a fabric. Its matrix carries both G23 and E3, and the rule is
        that of an isotropic solid, E3 = 2 (1 + ν) G, with the smaller of G13 and G23.
        """
        E1, E2, nu, G12, G13, G23, rho = of
        E3, nu13, nu23, rule = E2, nu, 0.5 * E2 / G23 - 1.0, "E2"
        if not 4.0 * G23 * (E1 - nu**2 * E2) > E1 * E2:
            factor, nu13, nu23 = 2.0 * (1.0 + _NU_ACROSS), _NU_ACROSS, _NU_ACROSS
            E3, rule = factor * min(G13, G23), f"{factor:g} times G13 or G23, as of a fabric"
        self.left_out.append(f"plies of LAMINA or MAT8 have no E3: that of contact is {rule}")
        return self.orthotropic(E1, E2, E3, nu, nu13, nu23, G12, G13, G23, rho)

    def numbers(self, area: float, second: Any, J: float, *more: FloatArray) -> Profile:
        """Return a cross-section by its figure's ∫h² dA, ∫hv dA, ∫v² dA in the deck's units.

        `more` are the inverse of its shear factors, and points.
        """
        unit, (hh, hv, vv), (compliance, points) = self.length, second, more
        tensor = unit**4 * np.array([[hh, hv], [hv, vv]])
        return Profile(area * unit**2, tensor, J * unit**4, compliance, unit * points, np.zeros(2))

    def beam(self, of: Any, material: Any, z: Any, members: IntArray, axes: Any, to: Any) -> Beam:
        """Return the beam of a section whose z axis is along z; of a profile in principal axes.

        `axes` has our y and z in rows in the axes of the profile's figure. `to` leads from the
        nodes of each element to the line that the figure has for these.
        """
        x, centre = self.directions(members), np.zeros(2)
        if isinstance(of, Profile):
            if of.skewed:
                self.left_out.append("L, T and the like carry shear at the centroid, not beside it")
            (yy, yz), (_, zz) = axes @ of.second @ axes.T
            if abs(yz) > _ROUND * (yy + zz):  # turned by up to 45 degrees
                angle = 0.5 * math.atan2(math.copysign(2.0, yy - zz) * yz, abs(yy - zz))
                c, s, z = math.cos(angle), math.sin(angle), across(z, x)
                z, axes = c * z - s * np.cross(z, x), np.array([[c, s], [-s, c]]) @ axes
            Iz, Iy = np.diag(axes @ of.second @ axes.T).tolist()
            ky, kz = (1.0 / k if k else math.inf for k in np.diag(axes @ of.compliance @ axes.T))
            centre, points = axes @ of.centre, (of.points @ axes.T).tolist()
            of = BeamSection(of.area, Iy, Iz, of.J, (ky, kz), points)
        try:
            orientation = common(z, x)
        except InputError:
            with suppress(InputError):  # a round section on its nodes has no axes
                if not np.any(to):
                    return Beam(of, material, None, (centre[0], centre[1]))
            raise
        z = across(np.array(orientation), x)
        places = np.sum(np.array([x, np.cross(z, x), z]) * to, axis=-1).T
        if np.abs(places - [0.0, *places[0, 1:]]).max() > _SAME * np.abs(to).max():
            raise InputError("its elements are moved along themselves, or unlike each other")
        return Beam(of, material, orientation, (centre + places[0, 1:]).round(12).tolist())

    def directions(self, members: IntArray, *, edges: bool = False) -> FloatArray:
        """Return unit normals of surface cells and tangents of lines, in order, shape (n, 3).

        With `edges` the directions from the first node to the second.
        """
        found = [np.zeros((0, 3))]
        for block, own in self.raw.rows(members):
            ends = self.raw.nodes[block.cells[own]]
            if block.dim == 2 and not edges:
                last = 3 if block.kind.startswith("quad") else 2
                found.append(np.cross(ends[:, 2] - ends[:, 0], ends[:, last] - ends[:, 1]))
            elif block.dim:
                found.append(ends[:, 1] - ends[:, 0])
        return unit(np.concatenate(found))


@record
class Axes:
    """A coordinate system in global coordinates.

    Attributes
    ----------
    kind : str
        "R", "C" or "S": rectangular, cylindrical (r, θ, z) or spherical (r, θ, φ with θ from the
        axis z), in degrees.
    origin : ndarray, shape (3,)
    axes : ndarray, shape (3, 3)
        Unit vectors in rows.
    """

    kind: str = "R"
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    axes: FloatArray = field(default_factory=lambda: np.eye(3))

    def basic(self, x: FloatArray) -> FloatArray:
        """Return global coordinates of points given in this system, shape (n, 3)."""
        if self.kind != "R":
            r, turn, height = x.T
            if self.kind == "S":
                theta = np.radians(turn)
                r, turn, height = r * np.sin(theta), height, r * np.cos(theta)
            angle = np.radians(turn)
            x = np.stack([r * np.cos(angle), r * np.sin(angle), height], axis=1)
        return self.origin + x @ self.axes

    def directions(self, x: FloatArray) -> FloatArray:
        """Return unit vectors of the coordinates at points given in global coordinates.

        Returns
        -------
        ndarray, shape (n, 3, 3)
            A unit vector in each row.
        """
        local = (x - self.origin) @ self.axes.T
        angles = np.zeros((len(x), 2))
        if self.kind != "R":
            angles[:, 0] = np.arctan2(local[:, 1], local[:, 0])
        if self.kind == "S":
            angles[:, 1] = np.arctan2(np.hypot(local[:, 0], local[:, 1]), local[:, 2])
        turned = Rotation.from_euler("ZY", angles).as_matrix().transpose(0, 2, 1) @ self.axes
        return np.roll(turned, 1, axis=1) if self.kind == "S" else turned


def triad(
    x: FloatArray, beside: FloatArray, error: Callable[[str], MeshError], least: float = PARALLEL
) -> FloatArray:
    """Return the unit axes, in rows, of a first one and a vector in the plane of it and the second.

    `least` is the sine of the angle between both below which they are refused.
    """
    z = np.cross(x, beside)
    if not np.linalg.norm(z) > least * np.linalg.norm(x) * np.linalg.norm(beside):
        raise error("its points are on one line")
    return unit(np.array([x, np.cross(z, x), z]))


def across(vectors: FloatArray, directions: FloatArray) -> FloatArray:
    """Return unit vectors along the parts of vectors across unit directions, shape (n, 3).

    They are zero where there is no such part.
    """
    along = dot(np.broadcast_to(vectors, directions.shape), directions)
    part = vectors - along[:, None] * directions
    length = np.linalg.norm(part, axis=1, keepdims=True)
    least = _SAME * np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit(np.where(length > least, part, 0.0))


def common(vectors: FloatArray, directions: FloatArray) -> tuple[float, ...]:
    """Return a vector whose part across each direction is along that of each vector.

    Normals and tangents are such directions, of which `Laminate` and `Beam` take the part across.
    """
    wanted = across(vectors, directions)
    if not wanted.any(axis=1).all():
        raise InputError("its axis is along some of its elements, or their normals")
    for one in (vectors[0], wanted.mean(axis=0)):
        if np.abs(across(one, directions) - wanted).max() < _SAME:
            return tuple(np.round(one, 12).tolist())
    raise InputError("its elements have axes in several directions; make it several sections")


def layered(
    plies: list[Ply],
    axis: Callable[[], Any],
    offset: float,
    share: float = 0.0,
    *,
    symmetric: bool = False,
) -> Shell | Laminate:
    """Return the shell of some plies; the axis is asked for if one of them has fibres.

    The middle lies a length and a share of the thickness above the nodes.
    """
    plies = plies + plies[::-1] * symmetric
    offset += share * sum(ply.thickness for ply in plies)
    fibrous = any(isinstance(ply.material, Orthotropic) for ply in plies)
    if len(plies) == 1 and not fibrous:
        return Shell(plies[0].thickness, plies[0].material, offset)
    return Laminate(plies, np.asarray(axis()).tolist() if fibrous else None, offset)


@contextmanager
def refusing(error: Callable[[str], MeshError]) -> Iterator[None]:
    """Say of bad values to which card they belong."""
    try:
        with np.errstate(divide="raise", invalid="raise"):
            yield
    except MeshError:  # names its own card
        raise
    except ArithmeticError:
        raise error("its numbers are 0, or lie too far apart to compute with") from None
    except (InputTypeError, ValueError, RecursionError) as wrong:  # systems refer to others
        raise error(str(wrong)) from None
