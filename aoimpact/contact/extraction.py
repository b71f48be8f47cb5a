"""Compliance of a finite-element body beyond the half-space that touches it at the contact.

The displacement under a contact force is split, u = χ u_B + w. u_B is the field of an elastic
half-space under Hertz's pressure p on a disc of radius a (`halfspace`). It holds all that is
singular as a → 0, and is known in closed form. w corrects for the finite body; it is smooth, so
that the mesh of the body resolves it. It satisfies a(w, v) = L(v) for all v, where a(u, v) =
∫ ε(u):C:ε(v) + s² ρ u·v dV and

    L(v) = ∫ (p - χ σ_B n)·v dA + ∫ σ_B ∇χ·v - C_B g:∇v dV - s² ∫ ρ χ u_B·v dV
           - ∫ (C - C_B) (χ ε_B + g):∇v dV,     g = sym(u_B ⊗ ∇χ).

χ is 1 except in bodies that reach behind the contact, where u_B is singular on the axis. C_B is
that of the element at the contact. The compliance of the body beyond the half-space's own,

    R = L(χ u_B) + 2 L(w) - a(w, w),

is stationary in w: a discrete w gives R too small by the energy of its error. At supports
w = -χ u_B. With any functional b of the contact, c = bᵀ(K + s²M)⁻¹b - R is the compliance that the
mesh has in place of the half-space. The contact law of the real bodies contains the half-space's
indentation, so c is taken out of it.

Subtracting a known singular field is the method of G. J. Fix, S. Gulati and G. I. Wakoff, J.
Comput. Phys. 13, 209 (1973).
"""

from __future__ import annotations

import copy
import math
from contextlib import suppress
from typing import Any

import numpy as np

from ..base import ArrayPair, FloatArray, IntArray, RoomError
from ..fem import (
    Material,
    Solid,
    each_of,
    material_of,
    pieces,
    some_elements,
)
from ..linalg import LinearSolver
from ..mesh import plane_of
from .compliance import SPAN, Compliance
from .halfspace import AnisotropicHalfSpace, HalfSpace, IsotropicHalfSpace, ShearedHalfSpace
from .subdivision import cells_towards, sides_towards
from .touch import element_at, spread

# A direction is along the normal where 1 - |cos θ| is below this: a milliradian.
_ALONG = 1e-6

# Heights over the tangent plane, as a share of the size of a side or of the body, that are none.
_FLAT = 1e-7

# χ falls from 1 to 0 where the cosine to the outward normal grows from the first value to the
# second. Seen from the pole of a hemispherical cup, its wall has 0.71 at most.
_BEHIND, _FAR_BEHIND = 0.35, 0.8

# Elements larger than this share of their distance do not interpolate u_B well enough for its
# inertia, of linear and quadratic elements: R changes by less than 1e-4 of itself.
_INTERPOLATED = {False: 0.3, True: 0.6}

# Residual of w over its load. R lacks the energy of its error: 0.007/(E* a) on elements 27 times as
# long as wide, with a residual of 3e-2.
_SOLVED = 1e-3

# Step of a central difference over the distance from the contact: errors of 1e-8 and rounding.
_DIFFERENCE = 1e-4


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
        On a body with a mesh. With tangents a force acts along these as well.
    normal : ndarray, shape (3,)
        Outward.
    radius : float
        a, of the contact itself, m.
    solver : LinearSolver
        Factors of K + s²M.
    moved : ndarray, shape (1 or 3, n_dofs), optional
        A model's responses to unit forces along the direction and the tangents, m/N, at that s; the
        body's own by the solver if left out.

    Notes
    -----
    A force at an angle θ to the normal moves a half-space along itself by cos²θ of what it does
    along the normal, and by sin²θ (2 - ν)/(2 - 2ν) of it, Mindlin's ratio of the compliances.
    """
    body, b, point, direction = tip.body, tip.b, tip.point, tip.direction
    splitting = Splitting(body, point, normal, radius, solver)
    cosine = float(direction @ normal)
    straight = 1.0 - abs(cosine) < _ALONG
    along = b if straight else body.on_dofs(np.outer(tip.forces[0] @ direction, normal))
    x = moved[0] if straight and moved is not None else solver.solve_roughly(along, _SOLVED)[0]
    strain, inertia = float(x @ (body.K @ x)), float(x @ (body.M @ x))
    compliance = 2.0 * float(along @ x) - strain - splitting.s2 * inertia
    beyond, varying = splitting.compliance, _over_width(body, splitting, point, normal)
    # A contact is wider than half its largest radius while the force is above an eighth.
    varying += abs(splitting.by_width) * math.log(2.0)
    # c of a wide patch on a thin body depends on frequency, as log s: dc/d(log s) = 2 s² dc/d(s²).
    # An impact has frequencies ω where s = iω. At ω = s/SPAN it is off by log(SPAN) of that in
    # phase, and by π/2 of it out of phase, as a dashpot.
    slope = 2.0 * splitting.s2 * abs(splitting.inertia - inertia)
    varying += (math.log(SPAN) + 0.5 * math.pi) * slope
    removed = compliance - beyond
    if not straight:
        nu = splitting.space.nu
        removed *= cosine**2 + (1.0 - cosine**2) * (2.0 - nu) / (2.0 - 2.0 * nu)
    inward = np.copysign(1.0, -cosine) * x if straight else -x
    with_tangents: dict[str, Any] = {}
    if tip.tangents is not None:
        with_tangents = _oblique(tip, splitting, beyond, solver, moved)
    return Compliance(
        removed=removed,
        varying=varying,
        deflection=x if straight else solver.solve(b),
        s=math.sqrt(splitting.s2),
        radius=radius,
        by_width=splitting.by_width,
        beyond=beyond,
        splitting=splitting,
        mesh_field=body.at_nodes(inward, len(splitting.w)) - splitting.w,
        **with_tangents,
    )


def _over_width(body: Any, splitting: Splitting, point: FloatArray, normal: FloatArray) -> float:
    """Return how much the mean of w under Hertz's pressure changes with the radius, m/N."""
    radius, sunk = splitting.space.radius, -splitting.w[0, : body.mesh.n_nodes] @ normal
    try:
        mean = float(spread(body.surface, point, normal, radius).weights @ sunk)
    except RoomError as edge:
        # The share of Hertz's pressure beyond a straight edge at x a is 1/2 - 3 x/4 + x³/4, from
        # none at x = 1 to a half, where a quarter-space is about twice as soft as a half-space.
        room = min(edge.room / radius, 1.0)
        return (1.0 - 1.5 * room + 0.5 * room**3) * splitting.space.mean_displacement
    here = body.surface.nearest(point)
    nodes = body.surface.nodes[here.face[0]]
    middle = float(body.surface.shape(here.face, here.uv)[0] @ sunk[nodes])
    # w is quadratic in the distance from the middle, and by reciprocity in the radius of the
    # pressure: under it, it has the mean g₀ + 0.8 g₁ a², and in the middle g₀ + 0.4 g₁ a².
    return 2.0 * abs(mean - middle)


def _oblique(
    tip: Any,
    splitting: Splitting,
    straight: float,
    solver: LinearSolver,
    moved: FloatArray | None,
) -> dict[str, Any]:
    """`oblique` and `sheared` of a `Compliance`.

    R_ii is stationary in w_i. R_ij is the mean of w_j along i under the pressure, or over the
    nodes' shares where the surface ends within it: of first order in w, so that half of R_ij and
    R_ji is taken.
    """
    body, direction = tip.body, tip.direction
    weights = tip.forces[0] @ direction
    axes, a = np.vstack([direction, tip.tangents]), splitting.space.radius
    loads = np.array([body.on_dofs(np.outer(weights, axis)) for axis in axes])
    if moved is None:
        moved = np.array([solver.solve_roughly(load, _SOLVED)[0] for load in loads])
    point, inward = splitting.point, splitting.frame[2]
    sheared = [Splitting(body, point, -inward, a, solver, tangent) for tangent in tip.tangents]
    with suppress(RoomError):
        weights = spread(body.surface, point, -inward, a).weights
    straight_on = float(direction @ inward) * splitting.w
    under = weights[: len(body.mesh.nodes)]
    means = np.array(
        [under @ w[0, : len(under)] @ axes.T for w in (straight_on, *(of.w for of in sheared))]
    )
    beyond = 0.5 * (means + means.T)
    np.fill_diagonal(beyond, [straight, *(of.compliance for of in sheared)])
    return {
        "oblique": loads @ moved.T - beyond,
        "sheared": body.at_nodes(moved[1:], len(splitting.w)) - [of.w for of in sheared],
    }


class Splitting:
    """The displacement of a body under a unit force at a place of its surface, as χ u_B + w.

    L(v) at the nodes, `forces`, and the self term L(χ u_B) are added up integral by integral. Both
    have two parts, of which the second counts -s² times: ∫ ρ χ u_B·v dV.

    Parameters
    ----------
    body : FEModel
        With a mesh.
    point : ndarray, shape (3,)
        On the surface, m.
    normal : ndarray, shape (3,)
        Outward.
    radius : float
        a, of the contact itself, m.
    solver : LinearSolver
        Factors of K + s²M.
    tangent : ndarray, shape (3,), optional
        Direction of the force where it acts along the surface.

    Attributes
    ----------
    frame : ndarray, shape (3, 3)
        Rows are the local axes; the last is the inward normal.
    space : HalfSpace
        With u_B; its radius is a.
    behind : bool
        True if the body reaches behind the contact, so that χ is not 1 everywhere.
    s2 : float
        s², (rad/s)².
    w : ndarray, shape (1 or 2, n_nodes, 3)
        m/N; where the body has shells or beams, also the rotation, 1/N.
    compliance : float
        R, m/N.
    inertia : float
        -dR/d(s²), kg m²/N².
    bent : float
        The part of R that a curved contact adds to the mean of w under the pressure, m/N.
    by_width : float
        dR/d(log a), m/N; 0 for a flat contact.
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
        tangent: FloatArray | None = None,
    ) -> None:
        mesh, s2, self.s2 = body.mesh, solver.pencil.s2, solver.pencil.s2
        self.body, self.mesh, self.point = body, mesh, point
        self.frame = np.vstack([plane_of(-normal, tangent), -normal])
        local = (mesh.nodes - point) @ self.frame.T
        self.behind = bool((local[:, 2] < -_FAR_BEHIND * np.linalg.norm(local, axis=1)).any())
        material: Any = material_of(body.material, element_at(body, point)[0])
        own: int | None = each_of(body.material).index(material)
        isotropic = IsotropicHalfSpace if tangent is None else ShearedHalfSpace
        self.space: HalfSpace
        if isinstance(material, Material):
            self.space = isotropic(material, radius)
        elif local[:, 2].min() > -_FLAT * mesh.size and tangent is None:
            like = material.half_space(normal)
            turned = _tensor(material, self.frame)
            self.space = AnisotropicHalfSpace(turned, radius, like.plane_strain_modulus, like.nu)
        else:  # the closed form of a body with the same E*; the rest is polarisation
            self.space, own = isotropic(material.half_space(normal), radius), None
        self.bent, moved_by = self._add_all(own)
        w, parts = self._solved(moved_by, solver)
        self.w = w.reshape(moved_by.shape)
        self.compliance, self.inertia = float(parts[0] - s2 * parts[1]), float(parts[1])
        self.by_width = 0.0
        if self.curved:
            # From R for half the radius with the same w. R is stationary in w, and so right to the
            # second order. On a surface of curvature 1/ρ, R changes by some log(a)/(E* ρ).
            half = copy.copy(self)
            half.space = self.space.of_radius(0.5 * radius)
            half_bent, _ = half._add_all(own)
            change = half.self_term - self.self_term
            change += 2.0 * (half.forces - self.forces).reshape(2, -1) @ w
            whole = change[0] - s2 * change[1] + half_bent - self.bent
            self.by_width = -float(whole) / math.log(2.0)
        del self.forces, self.self_term

    def half_space_field(self, x: FloatArray, radius: FloatArray | None = None) -> ArrayPair:
        """Return χ u_B and its stress at places, for a force of 1 N on discs of some radii.

        Parameters
        ----------
        x : ndarray, shape (p, 3)
            m.
        radius : ndarray, shape (n,), optional
            m; a if left out.

        Returns
        -------
        displacement, stress : ndarrays, shape (n, p, 3) and (n, p, 3, 3)
            m and Pa.
        """
        y = (x - self.point) @ self.frame.T
        chi, slope = self._cutoff(y)
        ratio = np.ones(1) if radius is None else self.space.radius / radius
        # Fields of discs of all radii are alike: u(y; a) = u(y/a; 1)/a and σ(y; a) = σ(y/a; 1)/a².
        u, stress = self.space.displacement_stress(ratio[:, None, None] * y)
        u, stress = ratio[:, None, None] * u, ratio[:, None, None, None] ** 2 * stress
        moved, stress = chi[:, None] * u, chi[:, None, None] * stress
        if self.behind:
            stress += np.einsum("ijkl,npk,pl->npij", self.space.stiffness, u, slope)
        return moved @ self.frame, self.frame.T @ stress @ self.frame

    def _solved(self, moved_by: FloatArray, solver: LinearSolver) -> ArrayPair:
        """w by L on the free dofs, and -χ u_B on the constrained ones, where that is `moved_by`.

        And of R the parts that count once and -s² times.
        """
        body, forces = self.body, self.forces.reshape(2, -1)
        w, parts = np.zeros(moved_by.size), self.self_term + np.array([self.bent, 0.0])
        held, K, M = body.held
        if len(held):
            w[held] = -moved_by.reshape(-1)[held]
            pulled = np.stack([K @ w[held], -(M @ w[held])])
            parts += (2.0 * forces - pulled)[:, held] @ w[held]
            forces = forces - pulled
        right = forces[:, body.free]
        w[body.free] = moved = solver.solve_roughly(right[0] - self.s2 * right[1], _SOLVED)[0]
        parts += 2.0 * right @ moved - [moved @ (body.K @ moved), -(moved @ (body.M @ moved))]
        return w, parts

    def field(self, x: FloatArray) -> FloatArray:
        """χ u_B at places, in global axes, m."""
        y = (x - self.point) @ self.frame.T
        return np.asarray(self._cutoff(y)[0][..., None] * self.space.displacement(y) @ self.frame)

    def at_nodes(self) -> FloatArray:
        """χ u_B at the nodes, and its rotation at those of shells and beams, by differences."""
        nodes, some = self.mesh.nodes, self.mesh.thin_nodes
        found = np.zeros(self.forces.shape[1:])
        found[0, : len(nodes)] = self.field(nodes)
        if self.mesh.thin:
            away = np.linalg.norm(nodes[some] - self.point, axis=1)
            step = _DIFFERENCE * np.maximum(away, self.space.radius)[:, None, None]
            places = nodes[some][:, None] + step * np.vstack([np.eye(3), -np.eye(3)])
            ahead, behind = np.split(self.field(places), 2, axis=1)
            slope = (ahead - behind) / (2.0 * step)  # ∂_j u_k
            found[1, some] = 0.5 * np.stack(
                [slope[:, j, k] - slope[:, k, j] for j, k in ((1, 2), (2, 0), (0, 1))], axis=1
            )
        return found

    def _cutoff(self, y: FloatArray) -> ArrayPair:
        """χ and its gradient at local places."""
        if not self.behind:
            return np.ones(y.shape[:-1]), np.zeros(y.shape)
        distance = np.maximum(np.linalg.norm(y, axis=-1), 1e-9 * self.space.radius)[..., None]
        cosine = -y[..., 2:] / distance
        slope = -cosine * y / distance**2
        slope[..., 2] -= 1.0 / distance[..., 0]
        width = _FAR_BEHIND - _BEHIND
        t = np.clip((cosine - _BEHIND) / width, 0.0, 1.0)
        chi = 1.0 - t**3 * (10.0 - 15.0 * t + 6.0 * t * t)
        return chi[..., 0], -30.0 * (t * (1.0 - t)) ** 2 / width * slope

    def _add(
        self,
        part: int,
        nodes: IntArray,
        weight: FloatArray,
        shape: FloatArray,
        t: FloatArray,
        u: FloatArray,
    ) -> None:
        """∫ t·v, and ∫ t·u in the self term; t and u in local axes, shape (n, q, 3)."""
        self.self_term[part] += float(np.einsum("nq,nqi,nqi->", weight, t, u))
        forces = shape.swapaxes(1, 2) @ (weight[..., None] * t @ self.frame)
        np.add.at(self.forces[part, 0], nodes, forces)

    def _add_all(self, own: int | None) -> tuple[float, FloatArray]:
        """Add up all integrals; return what `add_sides` does, and χ u_B at the nodes."""
        self.forces = np.zeros((2, 2 if self.mesh.thin else 1, self.body.shapes.n_nodes, 3))
        self.self_term, self.curved = np.zeros(2), False
        moved_by = self.at_nodes()
        sunk = self.add_sides()
        self.add_cells(moved_by[0], own)
        self.add_elements(moved_by)
        return sunk, moved_by

    def add_sides(self) -> float:
        """∫ (p - χ σ_B n)·v dA over the surface; returns what ∫ p·u exceeds that of a plane."""
        surface, nodes, a = self.body.surface, self.mesh.nodes, self.space.radius
        shapes = self.body.shapes
        axis = self.space.axis
        height = (nodes - self.point) @ self.frame[2]
        p0, pressed, sunk = 1.5 / (np.pi * a * a), 0.0, 0.0
        for side, (number, face) in enumerate(surface.sides):
            block = self.mesh.blocks[number]
            if block.element.thin:
                continue
            rows = surface.cell[surface.side == side] - block.first
            on = block.cells[rows][:, face.nodes]
            size = np.ptp(nodes[on], axis=1).max(axis=1)
            rows = rows[np.abs(height[on]).max(axis=1) > _FLAT * size]  # on a plane σ_B n = p
            corners = block.element.nodes[face.nodes[: face.n_corners]]
            block = shapes.blocks[number]
            for at in sides_towards(shapes.nodes, block, rows, corners, self.point, a):
                y, n = (at.x - self.point) @ self.frame.T, at.area @ self.frame.T
                u, stress = self.space.displacement_stress(y)
                chi = self._cutoff(y)[0][..., None]
                t = -chi * np.einsum("nqij,nqj->nqi", stress, n)
                r2 = y[..., 0] ** 2 + y[..., 1] ** 2
                # The side that is touched, and not another one of a thin body under the disc.
                faces = (n[..., 2] < 0.0) & (np.abs(y[..., 2]) < np.maximum(0.5 * a, r2 / a))
                p = p0 * np.sqrt(np.maximum(1.0 - r2 / (a * a), 0.0)) * -n[..., 2] * faces
                t[..., axis] += p
                pressed += float(p.sum())
                sunk += float((p * u[..., axis]).sum())
                self._add(0, block.cells[at.rows], at.weight, at.shape, t, chi * u)
        # A plane contact has no pressure on sides that are out of its plane.
        self.curved = pressed > 0.5
        return sunk - pressed * self.space.mean_displacement

    def add_cells(self, at_nodes: FloatArray, own: int | None) -> None:
        """Integrals over cells near the contact, behind it, and of other materials than there.

        Near the contact u_B is not interpolated well enough for its inertia: what `add_elements`
        takes for it there is replaced.
        """
        nodes, mesh, shapes = self.mesh.nodes, self.mesh, self.body.shapes
        for piece in pieces(mesh, self.body.material):
            corners = (nodes[piece.cells] - self.point) @ self.frame.T
            size, away = np.ptp(corners, axis=1).max(axis=1), np.linalg.norm(corners, axis=2)
            limit = _INTERPOLATED[mesh.quadratic] * np.maximum(away.min(axis=1), self.space.radius)
            near = np.zeros(len(piece.block.cells), dtype=bool)
            near[piece.rows] = size > limit
            wanted = near[piece.rows]
            if self.behind:
                wanted |= (-corners[..., 2] > _BEHIND * (away - size[:, None])).any(axis=1)
            difference = None
            if piece.which != own:
                wanted[:] = True
                difference = _tensor(piece.of, self.frame) - self.space.stiffness
            rows, block = piece.rows[wanted], shapes.blocks[mesh.blocks.index(piece.block)]
            for at in cells_towards(shapes.nodes, block, rows, self.point, self.space.radius):
                cells, y = block.cells[at.rows], (at.x - self.point) @ self.frame.T
                chi, slope = self._cutoff(y)
                if self.behind or difference is not None:
                    u, stress = self.space.displacement_stress(y)
                else:
                    u, stress = self.space.displacement(y, rough=True), None
                moved = chi[..., None] * u
                instead = at.shape @ (at_nodes[cells] @ self.frame.T)
                mass = piece.of.rho * at.weight * near[at.rows][:, None]
                self._add(1, cells, mass, at.shape, moved, moved)
                self._add(1, cells, -mass, at.shape, instead, instead)
                if stress is None:
                    continue
                tilted = u[..., :, None] * slope[..., None, :]
                g = 0.5 * (tilted + tilted.swapaxes(2, 3))
                extra = np.einsum("ijkl,nqkl->nqij", self.space.stiffness, g)
                energy = np.einsum("nq,nqij,nqij->", at.weight, extra, g)
                if difference is not None:
                    strain = chi[..., None, None] * self.space.strain(stress) + g
                    polarised = np.einsum("ijkl,nqkl->nqij", difference, strain)
                    energy += np.einsum("nq,nqij,nqij->", at.weight, polarised, strain)
                    extra += polarised
                self.self_term[0] -= float(energy)
                body_force = np.einsum("nqij,nqj->nqi", stress, slope) @ self.frame
                inner = self.frame.T @ extra @ self.frame
                forces = np.einsum("nq,nqa,nqi->nai", at.weight, at.shape, body_force)
                forces -= np.einsum("nq,nqij,nqaj->nai", at.weight, inner, at.slopes)
                np.add.at(self.forces[0, 0], cells, forces)

    def add_elements(self, moved_by: FloatArray) -> None:
        """∫ ρ χ u_B·v by the mass matrix, the springs to the ground, and shells and beams.

        These take χ u_B as it is at their nodes: -a(χ u_B, v) by their stiffness.
        """
        body, moved = self.body, moved_by.reshape(-1)
        held = np.zeros((2, len(moved)))
        held[1, body.free] = body.M @ moved[body.free]
        if body.springs is not None:
            held[0, body.free] = -body.springs * moved[body.free]
        if self.mesh.thin:
            thin = [block.element.thin for block in self.mesh.blocks]
            sizes = [len(block.cells) for block in self.mesh.blocks]
            dofs, K, _ = some_elements(body, np.repeat(thin, sizes))
            held[0, dofs] -= K @ moved[dofs]
        ground, _, M = body.held
        if len(ground):
            by_ground = M @ moved[ground]
            held[1, body.free] += by_ground[body.free]
            held[1, ground] += M.T @ moved
        self.self_term += held @ moved
        self.forces += held.reshape(self.forces.shape)


def _tensor(material: Solid, frame: FloatArray) -> FloatArray:
    """C_ijkl in local axes."""
    return np.asarray(
        np.einsum("ai,bj,ck,dl,ijkl->abcd", frame, frame, frame, frame, material.tensor)
    )
