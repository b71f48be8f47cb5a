"""Units, materials, plies and axes of sections, shared by the readers of Abaqus and Nastran."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import field
from typing import Any, get_args

import numpy as np
from scipy.spatial.transform import Rotation

from ..base import PRINTED, FloatArray, InputError, InputTypeError, IntArray, MeshError, record
from ..fem import (
    SAME,
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

# Types of sections and materials, by the dimension of the elements that can have them.
_KINDS: dict[int, tuple[type[Any], ...]] = {3: get_args(Solid), 2: (Shell, Laminate), 1: (Beam,)}

# ν13 and ν23 assumed for fabrics: equal to ν23 of all four unidirectional carbon and glass epoxies
# in P. D. Soden, M. J. Hinton and A. S. Kaddour, Compos. Sci. Technol. 58, 1011 (1998), table 1.
_NU_ACROSS = 0.4


@record
class Source:
    """A deck with its units, and sections and materials by which the user replaces the deck's.

    Attributes
    ----------
    raw : RawMesh
    length, stress, density : float
        The deck's units, in m, Pa and kg/m³.
    given : mapping of str to Material, Orthotropic, Shell, Laminate or Beam
        The argument `given` of `read_sections`, with names in capitals without blanks.
    left_out : list of str
        Descriptions of left-out contents of the deck, for one warning.
    taken : set of str
        Names in `given` whose sections or materials have been used.
    wanted : dict of str to types
        For each name in `given` with an object of a wrong type: the types that the deck requires.
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
        """Return the section or material that the user gave under a name, or None.

        None means that there is none of this name, or that its type does not suit elements of the
        dimension `dim`.
        """
        kinds = _KINDS.get(dim, ())
        if (given := self.given.get(at := key(name))) is None:
            return None
        if not isinstance(given, kinds):
            self.wanted[at] = kinds
            return None
        self.taken.add(at)
        return given

    def isotropic(self, E: float, nu: float, rho: float) -> Material:
        """Return an isotropic material from constants in the deck's units."""
        return Material(E * self.stress, nu, rho * self.density)

    def orthotropic(self, *of: float) -> Orthotropic:
        """Return a material from E1, E2, E3, ν12, ν13, ν23, G12, G13, G23, rho (deck units)."""
        E1, E2, E3, G12, G13, G23 = (self.stress * of[i] for i in (0, 1, 2, 6, 7, 8))
        return Orthotropic(
            (E1, E2, E3), (G12, G13, G23), (of[3], of[4], of[5]), of[9] * self.density
        )

    def ply(self, *of: float) -> Orthotropic:
        """Return a ply's material from E1, E2, ν12, G12, G13, G23, rho, with an estimate of E3.

        Unidirectional plies are isotropic across the fibres: E3 = E2, ν23 = E2/(2 G23) - 1. Their
        strain energy is positive if 1 - ν23 > 2 ν12² E2/E1. Otherwise the ply is taken for a fabric
        with fibres along 1 and 2. There the matrix determines both G23 and E3, so E3 = 2 (1 + ν) G
        as in an isotropic solid, with G the smaller of G13 and G23.
        """
        E1, E2, nu, G12, G13, G23, rho = of
        E3, nu13, nu23, rule = E2, nu, 0.5 * E2 / G23 - 1.0, "E2"
        if not 4.0 * G23 * (E1 - nu**2 * E2) > E1 * E2:
            factor, nu13, nu23 = 2.0 * (1.0 + _NU_ACROSS), _NU_ACROSS, _NU_ACROSS
            E3, rule = factor * min(G13, G23), f"{factor:g} times G13 or G23, as of a fabric"
        self.left_out.append(f"plies of LAMINA or MAT8 have no E3: contacts take {rule}")
        return self.orthotropic(E1, E2, E3, nu, nu13, nu23, G12, G13, G23, rho)

    def numbers(self, area: float, second: Any, J: float, *more: FloatArray) -> Profile:
        """Return a cross-section from its properties in the deck's units.

        `second`: moments of area ∫h² dA, ∫hv dA, ∫v² dA in the figure's axes. `more`: inverse of
        the shear factors, shape (2, 2), and the points at which stress is evaluated.
        """
        unit, (hh, hv, vv), (compliance, points) = self.length, second, more
        tensor = unit**4 * np.array([[hh, hv], [hv, vv]])
        return Profile(area * unit**2, tensor, J * unit**4, compliance, unit * points, np.zeros(2))

    def beam(self, of: Any, material: Any, z: Any, members: IntArray, axes: Any, to: Any) -> Beam:
        """Return the `Beam` of a section with z along `z`; a `Profile` gets its principal axes.

        The rows of `axes` are the beam's y and z, in components along (h, v) of the profile's
        figure. `to` is each element's offset from its nodes to the figure's line of nodes, m.
        """
        x, centre = self.directions(members), np.zeros(2)
        if isinstance(of, Profile):
            if of.skewed:
                self.left_out.append("the shear centre of L, T and the like is put at the centroid")
            (yy, yz), (_, zz) = axes @ of.second @ axes.T
            if abs(yz) > PRINTED * (yy + zz):  # y and z are no principal axes
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
            with suppress(InputError):  # a round section needs no orientation
                if not np.any(to):
                    return Beam(of, material, None, (centre[0], centre[1]))
            raise
        z = across(np.array(orientation), x)
        places = np.sum(np.array([x, np.cross(z, x), z]) * to, axis=-1).T
        if np.abs(places - [0.0, *places[0, 1:]]).max() > SAME * np.abs(to).max():
            raise InputError("its offsets must be across its elements, and the same for all")
        return Beam(of, material, orientation, (centre + places[0, 1:]).round(12).tolist())

    def directions(self, members: IntArray, *, edges: bool = False) -> FloatArray:
        """Return unit normals of surface cells and unit tangents of lines, shape (n, 3).

        With `edges`, return the unit vectors from the first to the second node of every cell.
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
    """A coordinate system, defined relative to global coordinates.

    Attributes
    ----------
    kind : str
        "R", "C" or "S": rectangular, cylindrical (r, θ, z) or spherical (r, θ, φ with θ measured
        from z); angles in degrees.
    origin : ndarray, shape (3,)
        Origin, in the deck's unit of length.
    axes : ndarray, shape (3, 3)
        Unit vectors along x, y and z in rows.
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
        """Return the system's local basis vectors at points with global coordinates `x`.

        Returns
        -------
        ndarray, shape (n, 3, 3)
            Unit vectors along the three coordinates, in rows, for each point.
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
    x: FloatArray, beside: FloatArray, error: Callable[[str], MeshError], least: float = PRINTED
) -> FloatArray:
    """Return unit axes in rows: the first along `x`, the second in the plane of `x` and `beside`.

    `least` is the smallest permitted sine of the angle between `x` and `beside`.
    """
    z = np.cross(x, beside)
    if not np.linalg.norm(z) > least * np.linalg.norm(x) * np.linalg.norm(beside):
        raise error("its points must not be on one line")
    return unit(np.array([x, np.cross(z, x), z]))


def across(vectors: FloatArray, directions: FloatArray) -> FloatArray:
    """Return, normalized, the part of each vector normal to its unit direction, shape (n, 3).

    The result is zero for a vector that is parallel to its direction.
    """
    along = dot(np.broadcast_to(vectors, directions.shape), directions)
    part = vectors - along[:, None] * directions
    length = np.linalg.norm(part, axis=1, keepdims=True)
    least = SAME * np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit(np.where(length > least, part, 0.0))


def common(vectors: FloatArray, directions: FloatArray) -> tuple[float, ...]:
    """Return one vector that can replace all `vectors` of a section's elements.

    `Laminate` and `Beam` use only the part of a vector normal to each element's direction (normal
    of a shell, tangent of a beam). This part must be along that part of the element's own vector.
    """
    wanted = across(vectors, directions)
    if not wanted.any(axis=1).all():
        raise InputError("its axis must not be along any of its elements, or their normals")
    for one in (vectors[0], wanted.mean(axis=0)):
        if np.abs(across(one, directions) - wanted).max() < SAME:
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
    """Return the shell of given plies; `axis` returns the axis that ply angles are measured from.

    `axis` is called only if a ply is orthotropic. The mid-surface lies above the nodes by `offset`
    (m) plus `share` times the thickness.
    """
    plies = plies + plies[::-1] * symmetric
    offset += share * sum(ply.thickness for ply in plies)
    fibrous = any(isinstance(ply.material, Orthotropic) for ply in plies)
    if len(plies) == 1 and not fibrous:
        return Shell(plies[0].thickness, plies[0].material, offset)
    return Laminate(plies, np.asarray(axis()).tolist() if fibrous else None, offset)


@contextmanager
def refusing(error: Callable[[str], MeshError]) -> Iterator[None]:
    """Replace errors about bad values by errors that name the entry or keyword."""
    try:
        with np.errstate(divide="raise", invalid="raise"):
            yield
    except MeshError:  # already names the entry
        raise
    except ArithmeticError:
        raise error("its numbers must not be 0, or too far apart to compute with") from None
    except (InputTypeError, ValueError, RecursionError) as wrong:  # circular references
        raise error(str(wrong)) from None
