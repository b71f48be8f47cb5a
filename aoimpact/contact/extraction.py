"""Compliance of a finite-element body beyond that of a half-space with the same contact.

The displacement under a contact force is split, u = χ u_B + w. u_B is the field of an elastic
half-space under Hertz's pressure p on a disc of radius a (`halfspace`). This field is known in
closed form and contains everything singular as a → 0. w corrects for the finite body; it is smooth,
so that the mesh of the body resolves it. The correction w satisfies a(w, v) = L(v) for all v, where
a(u, v) = ∫ ε(u):C:ε(v) + s² ρ u·v dV and

    L(v) = ∫ (p - χ σ_B n)·v dA + ∫ σ_B ∇χ·v - C_B g:∇v dV - s² ∫ ρ χ u_B·v dV
           - ∫ (C - C_B) (χ ε_B + g):∇v dV,     g = sym(u_B ⊗ ∇χ).

The cutoff χ is 1 with two exceptions. In bodies that reach behind the contact, χ falls to 0 there,
as u_B is singular on the axis. Under a layer on a stiffer material, χ falls with depth to the ratio
of the layer's modulus to that of the material below, so that the stress of χ u_B is nearly
continuous. C_B is the elastic tensor of the element at the contact. The compliance of the body
beyond that of the half-space,

    R = L(χ u_B) + 2 L(w) - a(w, w),

is stationary in w: a discrete w gives R too small by the energy of its error. The same holds for
the compliance between two forces, R_ij = L_i(χ u_Bj) + L_i(w_j) + L_j(w_i) - a(w_i, w_j). At
supports w = -χ u_B.

For any functional b of the contact, c = bᵀ(K + s²M)⁻¹b - R is the compliance that replaces the
half-space's in the mesh. Contact laws contain the indentation of the half-space, so that c is
removed from the law.

Subtracting a known singular field is the method of G. J. Fix, S. Gulati and G. I. Wakoff, J.
Comput. Phys. 13, 209 (1973).
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import PRINTED, ArrayPair, FloatArray, IntArray, RoomError
from ..fem import (
    Material,
    each_of,
    material_of,
    pieces,
    stiffness_mass,
)
from ..linalg import ROUGH, LinearSolver
from ..mesh import AT_NODE, plane_of
from .compliance import SPAN, Compliance
from .halfspace import AnisotropicHalfSpace, HalfSpace, IsotropicHalfSpace, ShearedHalfSpace
from .subdivision import cells_towards, sides_towards
from .touch import element_at, spread

# The cutoff χ falls from 1 to 0 as the cosine between outward normal and position increases from
# _BEHIND to _FAR_BEHIND. The wall of a hemispherical cup has cosines up to 0.71 from its pole.
_BEHIND, _FAR_BEHIND = 0.35, 0.8

# Largest ratio of an element's size to its distance from the contact for which the inertia terms
# use u_B interpolated between the element's nodes; keys: whether the mesh is quadratic. R changes
# by less than 1e-4 of its value.
_INTERPOLATED = {False: 0.3, True: 0.6}

# Relative step of central differences of the field χ u_B, with respect to position (for rotations)
# and to the force. Their relative errors are of the order of the step squared.
DIFFERENCE = 1e-4


def extracted(
    tip: Any,
    normal: FloatArray,
    radius: float,
    solver: LinearSolver,
    moved: FloatArray | None = None,
) -> Compliance:
    """Return the compliances of a body at a contact point on its surface.

    Parameters
    ----------
    tip : ContactPoint
        Contact point of a body with a mesh. If the point has tangents, forces act along these
        tangents as well.
    normal : ndarray, shape (3,)
        Outward normal.
    radius : float
        Contact radius a, m.
    solver : LinearSolver
        Solver of K + s²M.
    moved : ndarray, shape (1 or 3, n_dofs), optional
        Responses of a model at the solver's s to unit forces along the direction and the tangents,
        m/N; by default those of the body, from the solver.

    Notes
    -----
    The compliance of a half-space along a force at an angle θ to the normal is that along the
    normal times cos²θ + sin²θ (2 - ν)/(2 - 2ν), with Mindlin's ratio of the compliances.
    """
    body, point, direction = tip.body, tip.point, tip.direction
    tangents: Any = () if tip.tangents is None else tip.tangents
    splitting = Splitting(body, point, normal, radius, solver, tangents)
    w = splitting.w
    cosine = float(direction @ normal)
    straight = 1.0 - abs(cosine) < AT_NODE  # up to a milliradian
    along = tip.b if straight else tip.along(normal)
    x = moved[0] if straight and moved is not None else solver.solve_roughly(along, ROUGH)[0]
    strain, inertia = float(x @ (body.K @ x)), float(x @ (body.M @ x))
    compliance = 2.0 * float(along @ x) - strain - splitting.s2 * inertia
    beyond, varying = float(splitting.compliance[0, 0]), _over_width(body, splitting, point, normal)
    # The contact radius exceeds half its maximum while the force exceeds 1/8 of its maximum.
    varying += abs(splitting.by_width) * math.log(2.0)
    # The compliance c of a wide patch on a thin body varies as log s: dc/d(log s) = 2 s² dc/d(s²).
    # Motions of an impact have s = iω. At ω = s/SPAN, c differs by log(SPAN) times this slope in
    # phase and by π/2 times this slope out of phase, like a dashpot.
    slope = 2.0 * splitting.s2 * abs(splitting.inertia - inertia)
    varying += (math.log(SPAN) + 0.5 * math.pi) * slope
    removed = compliance - beyond
    if not straight:
        nu = splitting.space.nu
        removed *= cosine**2 + (1.0 - cosine**2) * (2.0 - nu) / (2.0 - 2.0 * nu)
    inward = np.copysign(1.0, -cosine) * x if straight else -x
    oblique = None
    if len(tangents):
        loads = np.array([of.b for of in tip.functionals])
        if moved is None:
            moved = np.array([solver.solve_roughly(load, ROUGH)[0] for load in loads])
        into = np.array([direction @ splitting.frame[2], 1.0, 1.0])
        oblique = loads @ moved.T - splitting.compliance * np.outer(into, into)
    return Compliance(
        removed=removed,
        varying=varying,
        deflection=x if straight else solver.solve(tip.b),
        s=math.sqrt(splitting.s2),
        radius=radius,
        by_width=splitting.by_width,
        beyond=beyond,
        splitting=splitting,
        mesh_field=body.at_nodes(inward, len(w[0])) - w[0],
        oblique=oblique,
    )


def _over_width(body: Any, splitting: Splitting, point: FloatArray, normal: FloatArray) -> float:
    """Return the change of w, averaged over Hertz's pressure, as its radius grows to a, m/N."""
    radius, sunk = splitting.space.radius, -splitting.w[0, 0, : body.mesh.n_nodes] @ normal
    try:
        mean = float(spread(body.surface, point, normal, radius).weights @ sunk)
    except RoomError as edge:
        # The share of Hertz's pressure beyond a straight edge at distance x a is 1/2 - 3x/4 + x³/4:
        # 0 for x = 1, 1/2 for x = 0, where the body is a quarter-space, about twice as soft.
        room = min(edge.room / radius, 1.0)
        return (1.0 - 1.5 * room + 0.5 * room**3) * splitting.space.mean_displacement
    here = body.surface.nearest(point)
    nodes = body.surface.nodes[here.face[0]]
    middle = float(body.surface.shape(here.face, here.uv)[0] @ sunk[nodes])
    # w is quadratic in the distance from the middle and, by reciprocity, in the radius of the
    # pressure: the mean of w under the pressure is g₀ + 0.8 g₁ a², and w at the middle is
    # g₀ + 0.4 g₁ a².
    return 2.0 * abs(mean - middle)


class Splitting:
    """Split u = χ u_B + w of a body's displacement under unit forces at a point of its surface.

    The nodal loads L(v), `forces`, and the self terms L(χ u_B) are sums of several integrals. Loads
    and terms have two parts; the second part, ∫ ρ χ u_B·v dV, is multiplied by -s².

    Parameters
    ----------
    body : FEModel
        Body with a mesh.
    point : ndarray, shape (3,)
        Contact point on the surface, m.
    normal : ndarray, shape (3,)
        Outward normal. The first force acts against it.
    radius : float
        Contact radius a, m.
    solver : LinearSolver
        Solver of K + s²M.
    tangents : sequence of ndarray, shape (3,)
        Directions of further forces, tangential to the surface.

    Attributes
    ----------
    frame : ndarray, shape (3, 3)
        Local axes as rows; the last is the inward normal.
    space : HalfSpace
        Half-space of radius a with the field u_B of the normal force.
    behind : bool
        True if the body reaches behind the contact.
    depth, left : float
        Depth at which χ ceases to fall under a layer, m, and χ at this depth; infinity and 1
        without a layer.
    s2 : float
        Square of the frequency s, (rad/s)².
    w : ndarray, shape (n_forces, 1 or 2, n_nodes, 3)
        Displacement w, m/N, and for bodies with shells or beams its rotation, 1/N.
    compliance : ndarray, shape (n_forces, n_forces)
        Compliance R, m/N.
    inertia : float
        -dR/d(s²) for the normal force, kg m²/N².
    by_width : float
        dR/d(log a) for the normal force, m/N; 0 for a flat contact.
    """

    forces: FloatArray
    self_term: FloatArray
    curved: bool

    def __init__(
        self,
        body: Any,
        point: FloatArray,
        normal: FloatArray,
        radius: float,
        solver: LinearSolver,
        tangents: Sequence[FloatArray] | FloatArray = (),
    ) -> None:
        mesh, s2, self.s2 = body.mesh, solver.pencil.s2, solver.pencil.s2
        self.body, self.mesh, self.point = body, mesh, point
        self.frame = np.vstack([plane_of(-normal), -normal])
        local = (mesh.nodes - point) @ self.frame.T
        self.behind = bool((local[:, 2] < -_FAR_BEHIND * np.linalg.norm(local, axis=1)).any())
        material: Any = material_of(body.material, element_at(body, point)[0])
        own: int | None = each_of(body.material).index(material)
        like = material.half_space(normal)
        layers = [(math.inf, 1.0)]  # (depth of a stiffer material, m; ratio of E* to its modulus)
        for piece in (of for of in pieces(mesh, body.material) if of.which != own):
            ratio = like.plane_strain_modulus / piece.of.half_space(normal).plane_strain_modulus
            if ratio < 1.0:
                layers.append((float(local[piece.cells, 2].min()), ratio))
        self.depth, self.left = min(layers)
        if self.depth <= radius:
            self.depth = math.inf
        self.space: HalfSpace = IsotropicHalfSpace(like, radius)
        if not isinstance(material, Material):
            if local[:, 2].min() > -AT_NODE * mesh.size:
                turned, modulus = _turned(material.tensor, self.frame), like.plane_strain_modulus
                self.space = AnisotropicHalfSpace(turned, radius, modulus, like.nu)
            else:  # u_B: isotropic half-space of equal E*; L includes C - C_B
                own = None
            own = None if len(tangents) else own
        self.spaces = [(self.space, self.frame)]
        for tangent in tangents:
            frame = np.vstack([plane_of(-normal, tangent), -normal])
            self.spaces.append((ShearedHalfSpace(like, radius), frame))
        bent, moved_by = self._add_all(own)
        w, parts = self._solved(moved_by, solver)
        self.w = w.reshape(moved_by.shape)
        found = parts[0] - s2 * parts[1] + bent
        self.compliance, self.inertia = 0.5 * (found + found.T), float(parts[1, 0, 0])
        self.by_width = 0.0
        if self.curved:
            # dR/d(log a) is a difference quotient between the radii a and a/2 with the same w. As R
            # is stationary in w, the error is of second order. On a surface of curvature 1/ρ, R
            # varies as about log(a)/(E* ρ).
            half = copy.copy(self)
            half.space = self.space.of_radius(0.5 * radius)
            half.spaces = [(half.space, self.frame)]
            half_bent, _ = half._add_all(own)
            change = half.self_term[:, 0, 0] - self.self_term[:, 0, 0]
            change += 2.0 * (half.forces - self.forces[:, :1]).reshape(2, -1) @ w[0]
            whole = change[0] - s2 * change[1] + half_bent[0, 0] - bent[0, 0]
            self.by_width = -float(whole) / math.log(2.0)
        del self.forces, self.self_term

    def half_space_field(self, x: FloatArray, radius: FloatArray | None = None) -> ArrayPair:
        """Return χ u_B and its stress at points, for normal forces of 1 N on discs of given radii.

        Parameters
        ----------
        x : ndarray, shape (p, 3)
            Points, m.
        radius : ndarray, shape (n,), optional
            Radii of the discs, m; by default a.

        Returns
        -------
        displacement, stress : ndarrays, shape (n, p, 3) and (n, p, 3, 3)
            Displacement, m, and stress, Pa.
        """
        y = (x - self.point) @ self.frame.T
        chi, slope = self._cutoff(x)
        ratio = np.ones(1) if radius is None else self.space.radius / radius
        # Similarity of fields for all radii: u(y; a) = u(y/a; 1)/a and σ(y; a) = σ(y/a; 1)/a².
        u, stress = self.space.displacement_stress(ratio[:, None, None] * y)
        u, stress = ratio[:, None, None] * u, ratio[:, None, None, None] ** 2 * stress
        moved, stress = chi[:, None] * u, chi[:, None, None] * stress
        if self.behind or self.depth < math.inf:
            stress += np.einsum("ijkl,npk,pl->npij", self.space.stiffness, u, slope @ self.frame.T)
        return moved @ self.frame, self.frame.T @ stress @ self.frame

    def _solved(self, moved_by: FloatArray, solver: LinearSolver) -> ArrayPair:
        """Solve a(w, v) = L(v) on free dofs for w; on constrained dofs w = -χ u_B = -`moved_by`.

        Returns w and the two parts of R, the second of which is multiplied by -s².
        """
        body, n = self.body, len(moved_by)
        w, parts, forces = np.zeros((n, moved_by[0].size)), self.self_term, self.forces
        forces = forces.reshape(2, n, -1)
        held, K, M = body.held
        if len(held):
            w[:, held] = -moved_by.reshape(n, -1)[:, held]
            pulled = np.stack([(K @ w[:, held].T).T, -(M @ w[:, held].T).T])
            parts = parts + (2.0 * forces - pulled)[..., held] @ w[:, held].T
            forces = forces - pulled
        right = forces[..., body.free]
        found = [solver.solve_roughly(f, ROUGH)[0] for f in right[0] - self.s2 * right[1]]
        w[:, body.free] = moved = np.array(found)
        taken = moved @ np.stack([body.K @ moved.T, -(body.M @ moved.T)])
        return w, parts + 2.0 * right @ moved.T - taken

    def _fields(self, x: FloatArray, *, stress: bool = False) -> ArrayPair:
        """Return the half-space field u_B of each force at points and, if requested, its stress."""
        found, tensors = [], []
        for space, frame in self.spaces:
            y = (x - self.point) @ frame.T
            if stress:
                u, tensor = space.displacement_stress(y)
                tensors.append(frame.T @ tensor @ frame)
            else:
                u = space.displacement(y)
            found.append(u @ frame)
        return np.array(found), np.array(tensors)

    def field(self, x: FloatArray) -> FloatArray:
        """Return the displacements χ u_B of all forces at points, in global axes, m."""
        return self._cutoff(x)[0][..., None] * self._fields(x)[0]

    def at_nodes(self) -> FloatArray:
        """Return χ u_B at nodes and, by differences, its rotation at nodes of shells and beams.

        The amplitude of an added shape function interpolates χ u_B if a support holds the function,
        and is 0 otherwise.
        """
        nodes, some, shapes = self.mesh.nodes, self.mesh.thin_nodes, self.body.shapes
        found = np.zeros(self.forces.shape[1:])
        found[:, 0, : len(nodes)] = self.field(nodes)
        own, held = found[:, 0].copy(), np.unique(self.body.held[0] // 3)
        held = held[(held >= len(nodes)) & (held < shapes.n_nodes)]
        for block in (of for of in shapes.blocks if of.signs is not None):
            # At the node of an added shape function, all other added functions are zero.
            row, column = np.nonzero(np.isin(block.cells, held))
            shape, cells = block.element.shape(block.element.nodes[column]), block.cells[row]
            rest = self.field(np.einsum("na,nai->ni", shape, shapes.nodes[cells]))
            rest -= np.einsum("na,dnai->dni", shape, own[:, cells])
            found[:, 0, cells[range(len(row)), column]] = block.signs[row, column][:, None] * rest
        if self.mesh.thin:
            away = np.linalg.norm(nodes[some] - self.point, axis=1)
            step = DIFFERENCE * np.maximum(away, self.space.radius)[:, None, None]
            places = nodes[some][:, None] + step * np.vstack([np.eye(3), -np.eye(3)])
            ahead, behind = np.split(self.field(places), 2, axis=2)
            slope = (ahead - behind) / (2.0 * step)  # ∂_j u_k
            turned = [slope[..., j, k] - slope[..., k, j] for j, k in ((1, 2), (2, 0), (0, 1))]
            found[:, 1, some] = 0.5 * np.stack(turned, axis=-1)
        return found

    def _cutoff(self, x: FloatArray) -> ArrayPair:
        """Return the cutoff χ and its gradient, 1/m, at points."""
        y = (x - self.point) @ self.frame.T
        chi, slope = np.ones(x.shape[:-1]), np.zeros(x.shape)
        if self.behind:
            distance = np.maximum(np.linalg.norm(y, axis=-1), PRINTED * self.space.radius)[
                ..., None
            ]
            cosine = -y[..., 2:] / distance
            slope = -cosine * y / distance**2
            slope[..., 2] -= 1.0 / distance[..., 0]
            width = _FAR_BEHIND - _BEHIND
            t = np.clip((cosine - _BEHIND) / width, 0.0, 1.0)
            chi = (1.0 - t**3 * (10.0 - 15.0 * t + 6.0 * t * t))[..., 0]
            slope *= -30.0 * (t * (1.0 - t)) ** 2 / width
        if self.depth < math.inf:
            below = np.clip(y[..., 2] / self.depth, 0.0, 1.0)
            kept = 1.0 - (1.0 - self.left) * below * below
            steep = -2.0 * (1.0 - self.left) / self.depth * below * (below < 1.0)
            slope = slope * kept[..., None] + (chi * steep)[..., None] * np.eye(3)[2]
            chi = chi * kept
        return chi, slope @ self.frame

    def _add(
        self,
        part: int,
        nodes: IntArray,
        weight: FloatArray,
        shape: FloatArray,
        t: FloatArray,
        u: FloatArray,
    ) -> None:
        """Add ∫ t·v to nodal loads and ∫ t·u to self terms; t, u: shape (n_forces, n, q, 3)."""
        t = weight[..., None] * t
        self.self_term[part] += np.tensordot(t, u, axes=((1, 2, 3), (1, 2, 3)))
        self._add_forces(part, nodes, shape.swapaxes(1, 2) @ t)

    def _add_forces(self, part: int, nodes: IntArray, forces: FloatArray) -> None:
        for all_nodes, added in zip(self.forces[part, :, 0], forces, strict=True):
            np.add.at(all_nodes, nodes, added)

    def _add_all(self, own: int | None) -> ArrayPair:
        """Add all integrals of L; return the result of `add_sides`, and χ u_B at the nodes."""
        n, rows = len(self.spaces), 2 if self.mesh.thin else 1
        self.forces = np.zeros((2, n, rows, self.body.shapes.n_nodes, 3))
        self.self_term, self.curved = np.zeros((2, n, n)), False
        moved_by = self.at_nodes()
        bent = self.add_sides()
        self.add_cells(moved_by[:, 0], own)
        self.add_elements(moved_by)
        return bent, moved_by

    def add_sides(self) -> FloatArray:
        """Add ∫ (p - χ σ_B n)·v dA over the surface; return ∫ p·u_B less its value on a plane."""
        surface, nodes, a = self.body.surface, self.mesh.nodes, self.space.radius
        shapes, inward = self.body.shapes, self.frame[2]
        along = np.array([frame[space.axis] for space, frame in self.spaces])
        height = (nodes - self.point) @ inward
        p0, pressed, sunk = 1.5 / (np.pi * a * a), 0.0, np.zeros(self.self_term.shape[1:])
        for side, (number, face) in enumerate(surface.sides):
            block = self.mesh.blocks[number]
            if block.element.thin:
                continue
            rows = surface.cell[surface.side == side] - block.first
            on = block.cells[rows][:, face.nodes]
            size = np.ptp(nodes[on], axis=1).max(axis=1)
            rows = rows[np.abs(height[on]).max(axis=1) > AT_NODE * size]  # elsewhere p - σ_B n = 0
            corners = block.element.nodes[face.nodes[: face.n_corners]]
            block = shapes.blocks[number]
            for at in sides_towards(shapes.nodes, block, rows, corners, self.point, a):
                u, stress = self._fields(at.x, stress=True)
                y, n = (at.x - self.point) @ self.frame.T, at.area @ inward
                chi = self._cutoff(at.x)[0][..., None]
                r2 = y[..., 0] ** 2 + y[..., 1] ** 2
                # Pressure acts only on the touched side, not on the opposite side of a thin body.
                faces = (n < 0.0) & (np.abs(y[..., 2]) < np.maximum(0.5 * a, r2 / a))
                p = p0 * np.sqrt(np.maximum(1.0 - r2 / (a * a), 0.0)) * -n * faces
                pressure = p[..., None] * along[:, None, None]
                pressed += float(p.sum())
                sunk += np.tensordot(pressure, u, axes=((1, 2, 3), (1, 2, 3)))
                t = pressure - chi * np.einsum("dnqij,nqj->dnqi", stress, at.area)
                self._add(0, block.cells[at.rows], at.weight, at.shape, t, chi * u)
        # On a plane contact face no pressure is integrated, as faces in its plane are left out.
        self.curved = pressed > 0.5
        return sunk - pressed * np.diag([space.mean_displacement for space, _ in self.spaces])

    def add_cells(self, at_nodes: FloatArray, own: int | None) -> None:
        """Add integrals over cells near or behind the contact, and over cells of other materials.

        Near the contact, the mesh does not interpolate u_B well enough for its inertia. The
        integrals ∫ ρ χ u_B·v that `add_elements` adds for these cells are replaced.
        """
        nodes, mesh, shapes = self.mesh.nodes, self.mesh, self.body.shapes
        softness = np.array([_turned(of.softness, frame.T) for of, frame in self.spaces])
        softness = softness.reshape(-1, 9, 9)
        for piece in pieces(mesh, self.body.material):
            stiffness = piece.of.tensor.reshape(9, 9)
            corners = (nodes[piece.cells] - self.point) @ self.frame.T
            size, away = np.ptp(corners, axis=1).max(axis=1), np.linalg.norm(corners, axis=2)
            limit = _INTERPOLATED[mesh.quadratic] * np.maximum(away.min(axis=1), self.space.radius)
            near = np.zeros(len(piece.block.cells), dtype=bool)
            near[piece.rows] = size > limit
            wanted = near[piece.rows]
            if self.behind:
                wanted |= (-corners[..., 2] > _BEHIND * (away - size[:, None])).any(axis=1)
            differs = piece.which != own
            if differs or self.depth < math.inf:
                wanted[:] = True
            inner = self.behind or differs or self.depth < math.inf
            rows, block = piece.rows[wanted], shapes.blocks[mesh.blocks.index(piece.block)]
            for at in cells_towards(shapes.nodes, block, rows, self.point, self.space.radius):
                cells = block.cells[at.rows]
                chi, slope = self._cutoff(at.x)
                u, stress = self._fields(at.x, stress=inner)
                moved = chi[..., None] * u
                instead = at.shape @ at_nodes[:, cells]
                mass = piece.of.rho * at.weight * near[at.rows][:, None]
                self._add(1, cells, mass, at.shape, moved, moved)
                self._add(1, cells, -mass, at.shape, instead, instead)
                if not inner:
                    continue
                slope = slope[..., None, :]
                self._add(0, cells, at.weight, at.shape, (stress * slope).sum(axis=-1), moved)
                # extra = (C - C_B) χ ε_B + C g, which reduces to C_B g in the contact's material.
                tilted = u[..., None] * slope
                strain = 0.5 * (tilted + tilted.swapaxes(-1, -2))
                within = chi[..., None, None] * stress
                flat = within.reshape(len(u), -1, 9)
                strain += (flat @ softness).reshape(within.shape)
                extra = (strain.reshape(flat.shape) @ stiffness).reshape(within.shape) - within
                extra *= at.weight[..., None, None]
                self.self_term[0] -= np.tensordot(extra, strain, axes=((1, 2, 3, 4),) * 2)
                self._add_forces(0, cells, -np.einsum("dnqij,nqaj->dnai", extra, at.slopes))

    def add_elements(self, moved_by: FloatArray) -> None:
        """Add ∫ ρ χ u_B·v from the mass matrix, and terms of ground springs, shells and beams.

        The terms of springs, shells and beams are -a(χ u_B, v), from their stiffness matrices and χ
        u_B at nodes.
        """
        body, moved = self.body, moved_by.reshape(len(moved_by), -1)
        held, free = np.zeros((2, *moved.shape)), body.free
        held[1][:, free] = (body.M @ moved[:, free].T).T
        if body.springs is not None:
            held[0][:, free] = -body.springs * moved[:, free]
        if self.mesh.thin:
            K, _ = stiffness_mass(body.shapes.of_elements(thin=True), body.material)
            held[0] -= (K @ moved.T).T
        ground, _, M = body.held
        if len(ground):
            by_ground = (M @ moved[:, ground].T).T
            held[1][:, free] += by_ground[:, free]
            held[1][:, ground] += (M.T @ moved.T).T
        self.self_term += held @ moved.T
        self.forces += held.reshape(self.forces.shape)


def _turned(tensor: FloatArray, frame: FloatArray) -> FloatArray:
    """Return the elastic tensor C_ijkl in the axes that are the rows of `frame`."""
    return np.asarray(np.einsum("ai,bj,ck,dl,ijkl->abcd", frame, frame, frame, frame, tensor))
