"""The contact functional: the displacement u = bᵀX of a body at its contact.

The paper uses the unit vector of a dof i₀ (eq. 1). Other vectors b describe a point within a face,
by the face's shape functions, or a patch of the surface under Hertz's pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import (
    PRINTED,
    ROUNDING,
    FloatArray,
    Frozen,
    InputError,
    InputTypeError,
    RoomError,
    choice,
    finite_array,
    held_warnings,
    integer,
    nonnegative,
    place,
    plain,
    positive,
    unit_vector,
    warn,
)
from ..fem import (
    Beam,
    FEModel,
    Layers,
    Material,
    OneMaterial,
    beam_motion,
    label_of,
    labelled_rows,
    material_of,
    nodes_by_number,
    pieces,
)
from ..linalg import LARGEST, LinearSolver
from ..mesh import AT_NODE, SHARP, nearest_line, surface_shape
from .compliance import Compliance
from .extraction import extracted
from .layer import bending_length
from .thinextraction import excess_of_beam, excess_of_shell, patch_on_shell
from .touch import Patch, Touch, edge_length, element_at, thickness, to_nodes, touched

# Ratio of a patch's radius r to the contact radius a. For two similar bodies, the compliance
# removed from Hertz's law is 1.2 a/r of the law's own compliance dδ/dF, thus all of it at
# r = 1.2 a. The excess above 1.2 is a margin.
PATCH_OVER_CONTACT = 1.4

# Largest ratio of a patch's radius r to the body's thickness h if the contact radius is unknown.
# Beyond the half-space's field, the body's motion consists of waves with k up to 1/h. For these
# waves Hertz's pressure does 1 - (k r)²/5 times the work of a point force, 1 % less.
_OF_DEPTH = 0.25

# Factor by which a patch is widened if the contact proves stiffer than the mesh under the patch.
_WIDER = 2.0

# Assumed ratio of the contact radius to the element's edge while the radius is unknown. The
# compliance R of the body beyond the half-space hardly depends on this ratio: assuming 0.1 or 4
# times the true radius changes the contact force by 0.2 %. On a curved body, R depends on log a
# only while a is small compared with the surface's radius of curvature, which does not hold for
# wide patches.
_WITHIN_EDGE = 0.15

# A patch that does not fit on the surface is tried again with a smaller radius. `_WITHIN`: ratio of
# the new radius to the distance at which the surface ends. `_LEAST_PATCH`: smallest ratio of the
# radius to the element's edge; for smaller patches a point force is used.
_WITHIN, _LEAST_PATCH = 0.95, 0.03

# Largest abs(resultant - 1), and ratio of couple to body size, of a functional without a warning;
# largest sin² of the angle between a force and the axis of a tube that it may strike.
_NEARLY = 1e-3

# Product s T of the shift s and the contact duration T. On the paper's beam, values of 8 to 14 are
# equivalent; values 3 times as small or as large need two more oscillators for the same accuracy.
# Several shifts at once gave less accuracy per linear solution.
SHIFT_TIMES_DURATION = 10.0

# Largest ratio of thickness to width of the solid elements of a sheet, with a margin for rounding
# errors.
_FLAT = 0.1 * (1.0 + 1e-6)


@dataclass(frozen=True)
class ContactSurface:
    """Material and curvature of a body's surface at its contact.

    Attributes
    ----------
    material : Material
        Isotropic material, or the equivalent one for an orthotropic half-space.
    curvatures : (float, float)
        Principal curvatures, 1/m; positive where the body is convex.
    directions : pair of unit vectors, or None
        Principal directions in the body's coordinates; None if they do not matter.
    error : float
        Uncertainty of each curvature, 1/m.

    Examples
    --------
    >>> ContactSurface(Material(E=210e9, nu=0.3, rho=7800), (100.0, 0.0)).radii
    (0.01, inf)
    """

    material: Material
    curvatures: tuple[float, float]
    directions: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    error: float = 0.0

    @property
    def radii(self) -> tuple[float, float]:
        """Principal radii of curvature, m; infinite if the curvature is below its error."""
        first, second = (
            math.inf if abs(kappa) <= self.error else 1.0 / kappa for kappa in self.curvatures
        )
        return first, second


@dataclass(frozen=True, eq=False)
class ContactPoint(Frozen):
    """A contact point of a body: its position, direction and functional b.

    Made by `FEModel.contact`. `simulate` accepts a contact point as a body: the full finite-element
    model.

    Attributes
    ----------
    body : FEModel
    b : ndarray, shape (n_dofs,)
        Contact functional on the free dofs: u = bᵀX.
    direction : ndarray, shape (3,), or None
        Unit vector of the projectile's direction of travel; None for a body without nodes.
    point : ndarray, shape (3,), or None
        Position, m; on the surface of the mesh.
    node : int or None
        Index of the touched node in `body.nodes`; None if the force acts on several nodes.
    patch : Patch or None
        Disc that carries the contact; None for a node or a point.
    normal : ndarray, shape (3,), or None
        Outward normal of the surface; None on an edge, and for a body without a mesh.
    directed : bool
        True if the direction was given. A default direction is reversed for the projectile; see
        `reversed`.
    automatic : bool
        True if the radius of the patch was chosen automatically.
    contact_radius : float or None
        Contact radius a at the largest force, m; None if not known.
    tangents : ndarray, shape (2, 3), or None
        Directions of friction: unit vectors perpendicular to the direction and to each other.
    shift : float or None
        Shift s of the impact for which the patch was chosen, rad/s.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> end = bar.contact(point=(0.1, 0.005, 0.005))
    >>> end.direction.round(6), end.patch.radius > 0.0
    (array([-1.,  0.,  0.]), True)
    >>> bool(abs(end.b.sum()) > 0.99)  # of a force along x
    True
    """

    body: FEModel
    b: FloatArray
    direction: FloatArray | Any = None
    point: FloatArray | Any = None
    node: int | None = None
    patch: Patch | None = None
    normal: FloatArray | Any = None
    directed: bool = True
    automatic: bool = False
    contact_radius: float | None = None
    tangents: FloatArray | None = None
    shift: float | None = None

    @cached_property
    def key(self) -> tuple[Any, ...]:
        """Key of a cache, equal for equal contact points of one body.

        :meta private:
        """
        at = np.flatnonzero(self.b)
        arrays = at, self.b[at], self.direction, self.point, self.normal, self.tangents
        parts = (None if of is None else of.tobytes() for of in arrays)
        return *parts, self.directed, self.automatic, self.contact_radius, self.shift

    @cached_property
    def translates(self) -> bool:
        """True if the body is free to translate along the direction of travel.

        :meta private:
        """
        M, rigid = self.body.M, self.body.rigid_modes
        if self.direction is None or not rigid.shape[1]:
            return False
        along = self.body.translation(self.direction)
        rest = along - rigid @ (rigid.T @ (M @ along))
        return float(rest @ (M @ rest)) <= ROUNDING * float(along @ (M @ along))

    @cached_property
    def reversed(self) -> ContactPoint:
        """The contact point if its body is the projectile instead of the target, or vice versa.

        The direction of travel is reversed. On a shell or beam a direction given by the caller is
        kept, and the opposite side is touched.

        :meta private:
        """
        known = vars(self).get("extraction")  # `other` takes over the compliance of the impact
        if self.thin is not None and self.directed and self.normal is not None:
            other = replace(self, normal=-self.normal)
            if known is not None and isinstance(self.thin, Layers) and self.thin.sided:
                known = other._extracted(self.body.inverse(known.s**2))
        else:
            opposite = None if self.direction is None else -self.direction
            other = replace(self, b=-self.b, direction=opposite)
            if known is not None and known.oblique is not None:
                signs = np.array([-1.0, 1.0, 1.0])
                known = replace(known, oblique=known.oblique * np.outer(signs, signs))
        if known is not None:
            vars(other)["extraction"] = known
        return other

    @cached_property
    def finer(self) -> ContactPoint | None:
        """The same contact point of the body with finer elements; None if there is no such body.

        :meta private:
        """
        if (body := self.body.finer) is None:
            return None
        return replace(self, body=body, b=self._on_finer(body))

    def _on_finer(self, body: FEModel) -> FloatArray:
        """Return the functional b on the body with finer elements."""
        point, along, surface = self.point, self.direction, body.surface
        alike = self.body.mesh is body.mesh
        with held_warnings():  # the original point gave the same warnings
            if alike and self.patch is None and self.on_surface:
                # A patch replaces the point, as the deflection of the added shape functions under a
                # point force is unbounded.
                return body.functional(self.body.contact(point=point).along(np.array(along)))
            if alike or point is None or along is None or self.node is not None:
                return body.functional(self.b)
            if surface is None:
                return body.on_dofs(_on_beam(body, point, along).forces)
            radius = 0.0 if self.patch is None else self.patch.radius
            return body.on_dofs(touched(surface, point, along, radius).forces)

    @cached_property
    def functionals(self) -> tuple[ContactPoint, ...]:
        """Return the contact point itself and, if it has tangents, one more point per tangent.

        :meta private:
        """
        if self.tangents is None:
            return (self,)
        given: dict[str, Any] = {"tangents": None, "automatic": False, "directed": True}
        return self, *(
            replace(self, b=self.along(tangent), direction=tangent, **given)
            for tangent in self.tangents
        )

    def along(self, axis: FloatArray) -> FloatArray:
        """Return the functional of the contact's displacement along another axis, (n_dofs,).

        :meta private:
        """
        return self.body.on_dofs(np.outer(self.forces[0] @ self.direction, axis))

    @cached_property
    def made_of(self) -> OneMaterial | None:
        """Material, beam or layers of the element at the contact; None without a mesh.

        Layers are ordered so that the touched side of the shell is the top.

        :meta private:
        """
        if self.body.mesh is None or self.body.material is None or self.point is None:
            return None
        of = material_of(self.body.material, element_at(self.body, self.point)[0])
        normal: Any = self.direction if self.normal is None else self.normal
        if not isinstance(of, Layers) or normal is None:
            return of
        surface: Any = self.body.surface
        here = surface.nearest(self.point)
        return of.seen_from(top=bool(surface.normal(here.face, here.uv)[0] @ normal > 0.0))

    @property
    def thin(self) -> Layers | Beam | None:
        """The shell or beam at the contact; None for a solid, and without a mesh."""
        return self.made_of if isinstance(self.made_of, (Layers, Beam)) else None

    @property
    def _axis(self) -> FloatArray:
        """Vector between the ends of the beam element at the contact, m."""
        mesh: Any = self.body.mesh
        first, last = mesh.nodes[mesh.cells[nearest_line(mesh, self.point)[0], :2]]
        return np.asarray(last - first)

    @property
    def _along_beam(self) -> float:
        """Cosine of the angle between the direction and the axis of the beam at the contact."""
        return abs(float(self.direction @ self._axis)) / float(np.linalg.norm(self._axis))

    def check_wall(self) -> None:
        """Refuse a force across a tube of beam elements, whose wall is rigid and would not bend.

        :meta private:
        """
        if not isinstance(self.thin, Beam) or not self.thin.hollow:
            return
        if 1.0 - self._along_beam**2 > _NEARLY:
            raise InputError(
                f"direction {plain(np.array(self.direction))} is across a tube of beams, whose "
                "wall cannot bend; mesh the tube's surface, and take ao.Shell"
            )

    @cached_property
    def extraction(self) -> Compliance | None:
        """Local compliance of the mesh, to be replaced by the half-space of a contact law.

        Requires two linear solutions, for the contact and for the body beyond the half-space. None
        for a body without a mesh, and on a sharp edge. The compliance hardly depends on the
        duration of the contact; as the duration is not known here, `own_contact_time` is used.

        Raises
        ------
        InputError
            If the contact is on a shell that lies on solids.
        """
        if not self.on_surface:
            return None
        shift = SHIFT_TIMES_DURATION / own_contact_time(self)
        return self._extracted(self.body.inverse(shift**2))

    @property
    def on_surface(self) -> bool:
        """True for a contact on the surface of a mesh where a normal exists.

        :meta private:
        """
        known = self.point, self.direction, self.body.mesh, self.normal
        return all(one is not None for one in known)

    @property
    def width(self) -> float:
        """Contact radius, m; an estimate if it is not known.

        :meta private:
        """
        if self.contact_radius is not None:
            return self.contact_radius
        if self.point is None:
            return math.nan
        if isinstance(self.thin, Beam):
            return _WITHIN_EDGE * math.sqrt(self.thin.numbers.area)
        surface: Any = self.body.surface
        within = _WITHIN_EDGE * edge_length(surface, self.point)
        return within if self.patch is None else min(within, self.patch.radius / PATCH_OVER_CONTACT)

    @property
    def _covered(self) -> bool:
        """True if the force acts on a shell that lies on solids."""
        body: Any = self.body
        if not body.mesh.thin:
            return False
        solids = [piece.cells.ravel() for piece in pieces(body.mesh, body.material)]
        both = np.intersect1d(np.concatenate([[], *solids]), body.mesh.thin_nodes)
        pressed_on = self.forces[0].any(axis=1)
        return bool(np.isin(np.flatnonzero(pressed_on), both).all())

    def _extracted(self, solver: LinearSolver, moved: FloatArray | None = None) -> Compliance:
        surface: Any = self.body.surface
        point: Any = self.point
        of, radius, s = self.thin, self.width, math.sqrt(solver.s2)
        if not isinstance(of, Beam) and self._covered:
            raise InputError(
                f"point {plain(point)} m: a shell on solids cannot be touched; mesh solids there"
            )
        if of is not None:
            removed, varying = (
                excess_of_beam(of) if isinstance(of, Beam) else excess_of_shell(self, of, radius, s)
            )
            return Compliance(removed, varying, solver.solve(self.b), s, radius)
        normal: Any = touched(surface, point, None, 0.0).normal
        found = extracted(self, normal, self.width, solver, moved)
        if self.patch is not None and not self.automatic and found.removed < 0.0:
            raise InputError(  # mesh errors do not make a compliance negative
                f"radius={self.patch.radius:g}: the patch is too wide, since the mesh under it is "
                "stiffer than the body under the contact; give a smaller radius, or leave radius "
                "out"
            )
        return found

    def at_impact(
        self, contact_radius: float, solver: LinearSolver, moved: FloatArray | None = None
    ) -> ContactPoint:
        """Return the contact point with its compliance computed for a given contact radius.

        Parameters
        ----------
        contact_radius : float
            Contact radius at the largest force, m.
        solver : LinearSolver
            Solver of K + s²M, with s about 10 divided by the duration of the contact.
        moved : ndarray, shape (1 or 3, n_dofs), optional
            Known responses to unit forces along the direction and the tangents, m/N.

        :meta private:
        """
        tip = replace(self, contact_radius=contact_radius, shift=math.sqrt(solver.s2))
        if self.on_surface:
            vars(tip)["extraction"] = tip._extracted(solver, moved)
        return tip

    @cached_property
    def deflections(self) -> dict[Any, FloatArray]:
        """Cache of K⁻¹ b, shape (n_dofs,), keyed by the solver; initially empty.

        All models fitted to this contact share the cache.

        :meta private:
        """
        return {}

    @cached_property
    def contact_surface(self) -> ContactSurface | None:
        """Material and curvatures of the surface at the point; None for a body without a mesh.

        Raises
        ------
        InputError
            If the point is on a sharp edge.
        """
        surface: Any = self.body.surface
        if self.material is None or self.point is None:
            return None
        if isinstance(self.thin, Beam):
            across = 0.0 if self._along_beam > SHARP else self.thin.section.curvature
            return ContactSurface(self.material, (across, 0.0))
        shape = surface_shape(surface, self.point)
        if self.normal is not None and float(shape.normal @ self.normal) < 0.0:
            shape = shape.from_below
        first, second = shape.curvatures.tolist()
        along: Any = shape.directions
        return ContactSurface(self.material, (first, second), along, shape.error)

    @cached_property
    def material(self) -> Material | None:
        """Material of the element at the contact; None without a mesh.

        For an orthotropic material the isotropic equivalent, see `Orthotropic.half_space`.
        """
        of, normal = self.made_of, self.direction if self.normal is None else self.normal
        if isinstance(of, Beam):
            return of.material
        return None if of is None or normal is None else of.half_space(normal)

    @cached_property
    def depth(self) -> float:
        """Thickness of the body under the point, m; infinite without a mesh.

        For a beam, the thickness is the height of a rectangle with the same area and bending
        stiffness along the force.
        """
        surface = self.body.surface
        if isinstance(self.thin, Beam) and self.direction is not None:
            of, z = self.thin.numbers, self.thin.orientation
            share = 0.0 if z is None else float(self.direction @ z) ** 2 / float(np.dot(z, z))
            return math.sqrt(12.0 * (share * of.Iy + (1.0 - share) * of.Iz) / of.area)
        if isinstance(self.thin, Layers):
            return self.thin.total_thickness
        if surface is None or self.point is None or self.direction is None:
            return math.inf
        return thickness(surface, self.point, self.direction)

    @cached_property
    def flat(self) -> bool:
        """True if the body under the contact is a sheet of flat solid elements.

        :meta private:
        """
        surface, normal = self.body.surface, self.normal
        if surface is None or self.point is None or normal is None or self.thin is not None:
            return False
        cell = int(surface.cell[surface.nearest(self.point).face[0]])
        height = float(np.ptp(surface.mesh.nodes[surface.mesh.cells[cell]] @ normal))
        width = edge_length(surface, self.point)
        return height <= _FLAT * width and self.depth <= width

    def edge_and_wave(self, s: float) -> tuple[float, float]:
        """Return the edge length at the contact, and the bending length λ for a frequency s, m.

        λ = (D/(m s²))^(1/4) is computed for a plate as thick as the body. λ is infinite for beams
        struck along their axis, and for an unknown thickness.

        :meta private:
        """
        surface: Any = self.body.surface
        material: Any = self.material
        point: Any = self.point
        beam, depth = isinstance(self.thin, Beam), self.depth
        if isinstance(self.thin, Layers):
            wave = bending_length(self.thin, s)
        elif material is None or not math.isfinite(depth) or (beam and self._along_beam > SHARP):
            return 0.0, math.inf
        else:
            wave = (
                material.plane_strain_modulus * (depth / s) ** 2 / (12.0 * material.rho)
            ) ** 0.25
        edge = np.linalg.norm(self._axis) if beam else edge_length(surface, point)
        return float(edge), wave

    @property
    def resultant(self) -> FloatArray:
        """Sum of the nodal forces for a unit contact force, shape (3,)."""
        return np.asarray(self.forces[0].sum(axis=0))

    @property
    def forces(self) -> FloatArray:
        """Nodal forces and couples, m, for a unit contact force, shape (2, n_nodes, 3).

        :meta private:
        """
        if self.body.nodes is None:
            raise InputError(
                "a resultant needs nodes: make the model by from_mesh or FEModel(K=, M=, nodes=)"
            )
        return self.body.at_nodes(self.b)

    def __repr__(self) -> str:
        body = repr(self.body.name) if self.body.name else f"a body of {self.body.n_dofs} dofs"
        dofs = np.flatnonzero(self.b)
        if self.point is None or self.direction is None:
            where = f"dof {dofs[0]}" if len(dofs) == 1 else f"functional of {len(dofs)} dofs"
            nodes = np.zeros(0) if self.body.labels is None else self.body.labels[dofs, 0]
            label = f"node {nodes[0]}, " if len(np.unique(nodes)) == 1 else ""
            return f"ContactPoint({label}{where} of {body})"
        what = f"functional of {len(dofs)} dofs" if self.node is None else f"node {self.node_label}"
        if self.patch is not None:
            what = f"patch of radius {self.patch.radius:.4g} m on {self.patch.faces} faces"
        where, along = (", ".join(f"{x:.4g}" for x in of) for of in (self.point, self.direction))
        return f"ContactPoint({what} at ({where}) m along ({along}) of {body})"

    @property
    def node_label(self) -> int | None:
        """The label of `node` if nodes have labels, otherwise `node` itself."""
        return None if self.node is None else label_of(self.node, self.body.node_labels)

    @property
    def name(self) -> str:
        """Name of the body."""
        return self.body.name


def own_contact_time(tip: ContactPoint) -> float:
    """Return an estimate of the contact time, s: half a period of mass and contact stiffness.

    The stiffness is that of a half-space under Hertz's pressure on a radius r, r E*/0.6, or,
    without a mesh, the stiffness of K for a displacement of the contact's nodes alone. Without
    stiffness, the time is infinite.
    """
    if tip.on_surface:
        assert tip.material is not None
        # The displacement of a half-space is its mean under Hertz's pressure.
        compliance = 0.6 / (tip.width * tip.material.plane_strain_modulus)
    else:
        stiffness = quadratic(tip.body.K, tip.b) / float(tip.b @ tip.b) ** 2
        compliance = 1.0 / stiffness if stiffness > 0.0 else math.inf
    body = tip.body
    # If the mass is unknown, the trace of M is an upper bound.
    mass = float(body.M.diagonal().sum()) if body.mass is None else body.mass
    return math.pi * math.sqrt(mass * compliance)


def quadratic(A: Any, b: FloatArray) -> float:
    """Return bᵀAb for a vector b with few nonzero entries."""
    there = np.flatnonzero(b)
    return float(b[there] @ (A[there] @ b))


def contact_point(
    body: FEModel,
    point: npt.ArrayLike | None = None,
    direction: npt.ArrayLike | None = None,
    node: int | None = None,
    dof: int | None = None,
    b: npt.ArrayLike | None = None,
    radius: float | str = "auto",
    expected: float | None = None,
) -> ContactPoint:
    """Return the contact point of a body; for the parameters see `FEModel.contact`."""
    if isinstance(radius, str):
        choice("radius", radius, ("auto",))
    else:
        radius = nonnegative("radius", radius, unit="m")
    if expected is not None:
        if radius != "auto":
            raise InputError(f'expected is for radius="auto", but radius={radius!r} was given')
        expected = positive("expected", expected, unit="m")
    given = {"point": point, "node": node, "dof": dof, "b": b}
    names = [name for name, value in given.items() if value is not None]
    if not names:
        raise InputTypeError("contact needs what is touched: point=(x, y, z), node=, dof= or b=")
    if len(names) > 1:
        raise InputError(f"give either {' or '.join(names)}, not both")
    if direction is not None and names[0] in ("dof", "b"):
        raise InputError(
            f"give either {names[0]}, or point and direction, not both: {names[0]} has its own"
        )
    if radius not in ("auto", 0.0) and (names[0] in ("dof", "b") or body.surface is None):
        what = "a body without faces of elements" if names[0] not in ("dof", "b") else names[0]
        raise InputError(
            f"radius={radius}: {what} has no patch; give radius=0, or point on a body with a mesh"
        )
    if b is not None:
        return _of_functional(body, b)
    if dof is not None:
        return _at_dof(body, integer("dof", dof, low=0, high=body.n_dofs - 1))
    if body.nodes is None and (node is None or body.labels is None):
        name, missing = ("point", "nodes") if node is None else ("node", "labels")
        raise InputError(
            f"{name}: this body has no {missing}; give dof, or FEModel(K=, M=, {missing}=)"
        )
    along = None if direction is None else unit_vector("direction", direction)
    if along is None and body.mesh is None:
        raise InputTypeError("contact needs direction: a body without a mesh has no normal")
    if node is None:
        return _at_point(body, place("point", point), along, radius, expected)
    if body.nodes is None:
        return _at_label(body, integer("node", node), along)
    labelled, count = body.node_labels, len(body.nodes)
    low, high = (0, count - 1) if labelled is None else (None, None)
    wanted = integer("node", node, low=low, high=high)
    where = body.nodes[nodes_by_number("node", wanted, count, labelled)[0]]
    try:
        return _at_point(body, where, along, radius, expected)
    except InputError as error:
        raise InputError(f"node {node}: {error}") from error


def _at_point(
    body: FEModel,
    where: FloatArray,
    along: FloatArray | None,
    radius: float | str,
    expected: float | None,
) -> ContactPoint:
    if body.mesh is None:
        return _made(body, _on_node(body, _nearest_node(body, where), along))
    how: dict[str, Any] = {"directed": along is not None, "contact_radius": expected}
    how["automatic"] = isinstance(radius, str)
    surface = body.surface
    if surface is None:
        return _made(body, _on_beam(body, where, along), **how)
    where = to_nodes(body, where)
    if not isinstance(radius, str) or surface.thin(surface.nearest(where).face)[0]:
        touch = touched(surface, where, along, 0.0 if isinstance(radius, str) else radius)
        return _made(body, touch, **how)
    wide = edge_length(surface, where)
    normal = surface.smooth_normal(surface.nearest(where))
    if normal is not None:
        wide = min(wide, _OF_DEPTH * thickness(surface, where, normal))
    wide = wide if expected is None else PATCH_OVER_CONTACT * expected
    return _with_room(body, where, along, wide, how)


def contact_within(
    tip: ContactPoint, contact_radius: float, *, wider: bool = False
) -> ContactPoint:
    """Return the contact point with a patch for a given contact radius, or the largest that fits.

    On solids the patch is slightly wider than the contact; for shells see `patch_on_shell`. At the
    edge of a shell, if no patch fits, the force acts at a point.

    Parameters
    ----------
    tip : ContactPoint
    contact_radius : float
        Contact radius a, m.
    wider : bool, optional
        True for a wider patch, as needed if the contact is stiffer than the mesh under the patch.

    Raises
    ------
    InputError
        If no patch that the mesh can resolve fits on the surface.
    """
    point: Any = tip.point
    layers, radius = tip.thin, PATCH_OVER_CONTACT * contact_radius
    if isinstance(layers, Beam):
        return tip
    if layers is not None:
        # The touched side depends on the body's role, which is not yet known.
        sides = {layers, layers.seen_from(top=False)}
        radius = max(patch_on_shell(side, contact_radius, whole=wider) for side in sides)
    elif wider:
        radius *= _WIDER
    kept = {name: getattr(tip, name) for name in ("directed", "automatic", "tangents")}
    try:
        return _with_room(tip.body, point, tip.direction, radius, kept)
    except InputError:
        if layers is None:
            raise
        return tip


def _with_room(
    body: FEModel,
    point: FloatArray,
    along: FloatArray | None,
    radius: float,
    how: dict[str, Any],
) -> ContactPoint:
    """Return the contact point with a patch of the given radius, or of a smaller one that fits."""
    surface: Any = body.surface
    with held_warnings():  # the original point gave the same warnings
        least = min(radius, _LEAST_PATCH * edge_length(surface, point))
        while True:
            try:
                return _made(body, touched(surface, point, along, radius), **how)
            except RoomError as error:
                radius = _WITHIN * error.room
                if radius < least:
                    raise InputError(
                        f"point {plain(point)} m has no room for a contact over a patch: "
                        f"{error.reason}; {error.cure}"
                    ) from None


def _on_beam(body: FEModel, point: FloatArray, along: FloatArray | None) -> Touch:
    """Return the unit contact force (`Touch`) at a point on the axis of a beam element.

    Without a given direction, the force at a point beside the axis acts towards the axis.
    """
    mesh: Any = body.mesh
    given, point = point, to_nodes(body, point)
    cell, place, gap = nearest_line(mesh, point)
    ends = mesh.cells[cell, :2]
    x = (1.0 - place) * mesh.nodes[ends[0]] + place * mesh.nodes[ends[1]]
    made_of: Any = body.material
    of: Any = material_of(made_of, cell)
    if gap > math.sqrt(of.numbers.area) + AT_NODE * mesh.size:
        raise InputError(
            f"point {plain(point)} m is {gap:.3g} m from the nearest place on the axis of a beam, "
            f"{plain(x)} m; give a point there (is it in metres?)"
        )
    if along is None:
        away = float(np.linalg.norm(x - given))
        if away <= AT_NODE * mesh.size:
            raise InputTypeError(
                "contact needs direction, or a point beside the beam, whose axis has no normal"
            )
        along = (x - given) / away
    shares = beam_motion(mesh.nodes[ends][None], of, place)
    forces = np.zeros((2, mesh.n_nodes, 3))
    forces[:, ends] = np.einsum("i,ineJ->enJ", along, shares)
    members = ends[None]
    if at_node := min(place, 1.0 - place) < AT_NODE:
        members = mesh.cells[(mesh.cells[:, :2] == ends[round(place)]).any(axis=1), :2]
    axes = np.diff(mesh.nodes[members], axis=1)[:, 0]
    inner = not at_node or len(members) > 1
    if inner and (np.abs(axes @ along) > SHARP * np.linalg.norm(axes, axis=1)).all():
        warn(
            f"direction {plain(along)} is along the beam, but point {plain(x)} m is on the beam's "
            "side, whose surface the contact law uses; give a direction across the beam, or a "
            "point at its end"
        )
    return Touch(x, along, forces, -along)


def _at_dof(body: FEModel, dof: int) -> ContactPoint:
    b = np.eye(1, body.n_dofs, dof)[0]
    if body.nodes is None or body.free is None:
        return ContactPoint(body, b)
    node, component = divmod(int(body.free[dof]), 3)
    if node >= len(body.nodes):
        return ContactPoint(body, b, point=body.nodes[node - len(body.nodes)])
    return _placed(ContactPoint(body, b, np.eye(3)[component], body.nodes[node], node))


def _of_functional(body: FEModel, b: Any) -> ContactPoint:
    """Return the contact point of a functional b, with direction and position if they exist."""
    values = finite_array("b", b, shape=(None,)).copy()
    size = float(np.abs(values).max(initial=0.0))
    if len(values) != body.n_dofs:
        whole = body.nodes is not None and len(values) == 3 * len(body.nodes)
        raise InputError(
            f"b must have one entry for each of the {body.n_dofs} rows of K, got {len(values)}"
            + ("; take b[body.free]" if whole else "")
        )
    if not 1.0 / LARGEST <= size <= LARGEST:  # else bᵀKb or bᵀMb might overflow or underflow
        raise InputError(f"b must have entries of about 1, not all zero: the largest is {size:g}")
    tip = ContactPoint(body, values)
    if body.nodes is None:
        return tip
    forces, resultant = tip.forces[0], tip.resultant
    length = float(np.linalg.norm(resultant))
    with np.errstate(invalid="ignore", divide="ignore"):  # a resultant of 0 causes NaN
        centre = (forces @ resultant / length**2) @ body.nodes
    couple = float(np.linalg.norm(np.cross(body.nodes - centre, forces).sum(axis=0)))
    if abs(length - 1.0) > _NEARLY or couple > _NEARLY * np.ptp(body.nodes, axis=0).max():
        warn(
            f"b is no mean displacement: its nodal forces sum up to {plain(resultant)} N, of size "
            f"{length:.4g} N, with a couple of {couple:.3g} N m; give entries that sum up to 1 "
            "without a couple, unless u is to be a multiple or to include rotation"
        )
    return (
        tip if abs(length - 1.0) > PRINTED else _placed(replace(tip, direction=resultant / length))
    )


def _placed(tip: ContactPoint) -> ContactPoint:
    """Return a contact point with the point and normal of the surface that its force presses on."""
    surface, nodes, direction = tip.body.surface, tip.body.nodes, tip.direction
    if surface is None or nodes is None:
        return tip
    forces = tip.forces[0] @ direction
    centre = forces @ nodes
    spread = float(np.sqrt(np.abs(forces) @ ((nodes - centre) ** 2).sum(axis=1)))
    place = surface.nearest(centre)
    if float(place.distance[0]) > spread + AT_NODE * surface.mesh.size:
        return tip
    try:
        normal = touched(surface, place.x[0], direction, 0.0).normal
    except InputError:  # the force is tangential to the surface
        return tip
    return replace(tip, point=place.x[0], normal=normal, directed=False)


def _at_label(body: FEModel, label: int, along: Any) -> ContactPoint:
    """Return the contact point at a node of a body with labels but without coordinates."""
    labels: Any = body.labels
    rows, b = labelled_rows(labels, label), np.zeros(body.n_dofs)
    b[rows] = body.translation(along)[rows]
    if not b.any():
        raise InputError(
            f"node {label} with direction {plain(along)}: its free components are "
            f"{', '.join(map(str, labels[rows, 1]))}, none of them along it"
        )
    return ContactPoint(body, b, along)


def _on_node(body: FEModel, node: int, along: Any) -> Touch:
    nodes: Any = body.nodes
    forces = np.zeros((2, *nodes.shape))
    forces[0, node] = along
    return Touch(nodes[node], along, forces)


def _made(body: FEModel, touch: Touch, **how: Any) -> ContactPoint:
    """Return the contact point of a unit contact force, with its nodal forces on the free dofs."""
    # Remove rounding errors of the forces, so that a point at a node loads only this node.
    b = body.on_dofs(np.where(np.abs(touch.forces) > ROUNDING, touch.forces, 0.0))
    if np.abs(b).max(initial=0.0) <= ROUNDING:
        raise InputError(
            f"point {plain(touch.point)} m with direction {plain(touch.direction)}: supports hold "
            "all nodes of the contact; choose another point or direction, or release the nodes in "
            "fixed"
        )
    shares = touch.forces[0] @ touch.direction
    node = int(shares.argmax()) if shares.max() > 1.0 - AT_NODE else None
    return ContactPoint(
        body, b, touch.direction, touch.point, node, touch.patch, touch.normal, **how
    )


def _nearest_node(body: FEModel, point: FloatArray) -> int:
    """Return the node nearest to a point of a body without a mesh; refuse distant points."""
    nodes: Any = body.nodes
    distance = np.linalg.norm(nodes - point, axis=1)
    node = int(np.argmin(distance))
    gap = float(distance[node])
    if gap <= AT_NODE * np.linalg.norm(np.ptp(nodes, axis=0)):
        return node
    called = label_of(node, body.node_labels)
    around = np.linalg.norm(nodes - nodes[node], axis=1)
    spacing = float(np.sort(around)[1]) if len(nodes) > 1 else 0.0
    if gap > 0.5 * spacing:
        raise InputError(
            f"point {plain(point)} m is {gap:.3g} m from the nearest "
            f"node ({called}, at {plain(nodes[node])} m), where nodes are "
            f"{spacing:.3g} m apart: give the coordinates of a node (are they in metres?)"
        )
    warn(
        f"point {plain(point)} m is no node; this body has no mesh, so a contact is at a node, and "
        f"node {called} at {plain(nodes[node])} m, {gap:.3g} m off, is taken: give its "
        "coordinates if it is meant, or make the body with FEModel.from_mesh(...)"
    )
    return node
