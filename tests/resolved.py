"""Impacts with a resolved contact region: axisymmetric finite elements, fine at the contact.

Neither the package nor Hertz's law is used, but linear triangles of scikit-fem with the weight 2πr,
a lumped mass, central differences, and nodes that must not penetrate each other (or a plane). Both
bodies touch at the origin; the lower body lies in z < 0. Contact nodes face each other at the same
r; as displacements are small, only z enters the contact condition.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.spatial import Delaunay, KDTree
from skfem import Basis, BilinearForm, ElementTriP1, ElementVector, MeshTri

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

# Growth of elements with the distance from the contact, 1/m, relative to the finest size: with
# finest elements of 20 µm, 6 % of the distance. Largest over finest size.
GROWTH, LARGEST = 3.0e3, 25.0


@dataclass(frozen=True)
class Solid:
    """A material: Young's modulus, Pa; Poisson's ratio; density, kg/m³."""

    E: float
    nu: float
    rho: float


@dataclass(frozen=True, eq=False)
class Body:
    """Matrices over the dofs (r, z of each node, interleaved), and the contact nodes."""

    nodes: FloatArray
    K: sp.csr_matrix
    mass: FloatArray
    contact: IntArray

    @property
    def total_mass(self) -> float:
        return float(self.mass[1::2].sum())


@dataclass(frozen=True, eq=False)
class Impact:
    """Force, N, over time, s, and coefficient of restitution of the centres of mass."""

    t: FloatArray
    force: FloatArray
    restitution: float

    def smooth(self, width: float = 0.5e-6) -> FloatArray:
        """Running mean of the force over `width`, s, against chatter of single nodes."""
        n = max(1, round(width / (self.t[1] - self.t[0])))
        return np.convolve(self.force, np.full(n, 1.0 / n), mode="same")

    @property
    def peak(self) -> float:
        return float(self.smooth().max())

    @property
    def duration(self) -> float:
        touching = self.t[self.force > 0.0]
        return float(touching[-1] - touching[0])


def size(rho: float, finest: float, reach: float) -> float:
    """Size of the elements at the distance rho from the contact, m."""
    return finest * min(LARGEST, 1.0 + GROWTH * max(0.0, rho - reach))


def ball(radius: float, solid: Solid, finest: float, reach: float) -> Body:
    """A ball above the origin, with elements of the finest size within `reach`, m."""
    nodes = [np.zeros((1, 2)), np.array([[0.0, 2.0 * radius]])]
    rho, polar = finest, finest / radius
    while polar < math.pi - 0.5 * size(rho, finest, reach) / radius:
        rho = 2.0 * radius * math.sin(0.5 * polar)
        step = size(rho, finest, reach)
        ring = arc(rho, 0.5 * polar, 0.5 * math.pi, step)
        # Near the upper pole, rings are close together: only their surface nodes are kept.
        nodes.append(ring if 2.0 * radius - rho > 0.5 * step else ring[:1])
        polar += step / radius
    surface = np.array([node[0] for node in nodes[2:]])
    touching = surface[np.linalg.norm(surface, axis=1) <= reach]
    return body(np.vstack(nodes), solid, np.vstack([nodes[0], touching]))


def block(
    radius: float, height: float, solid: Solid, finest: float, reach: float, like: Body
) -> Body:
    """A cylinder below the origin, with nodes opposite the contact nodes of `like`."""
    corners = np.array([[radius, 0.0], [0.0, -height], [radius, -height]])
    rings = list(like.nodes[like.contact[1:], 0])
    rho = rings[-1]
    while (rho := rho + size(rho, finest, reach)) < math.hypot(radius, height):
        if (np.abs(np.linalg.norm(corners, axis=1) - rho) > 0.4 * size(rho, finest, reach)).all():
            rings.append(rho)
    nodes = [np.zeros((1, 2)), corners]
    for rho in rings:
        start = -math.acos(min(1.0, radius / rho))
        nodes.append(arc(rho, start, -math.asin(min(1.0, height / rho)), size(rho, finest, reach)))
    touching = np.array([node[0] for node in nodes[2 : 1 + len(like.contact)]])
    return body(np.vstack(nodes), solid, np.vstack([nodes[0], touching]))


def arc(rho: float, start: float, end: float, size: float) -> FloatArray:
    """Nodes on an arc about the origin, `size` apart; a single node if the arc is short."""
    angle = np.linspace(start, end, round(abs(end - start) * rho / size) + 1)
    return rho * np.column_stack([np.cos(angle), np.sin(angle)])


def body(nodes: FloatArray, solid: Solid, touching: FloatArray) -> Body:
    """Triangulate the nodes of a convex body, with contact nodes at the points `touching`."""
    nodes = np.where(np.abs(nodes) < 1e-12, 0.0, nodes)
    triangles = Delaunay(nodes).simplices
    corners = nodes[triangles]
    arms = corners[:, 1:] - corners[:, :1]
    area = 0.5 * np.abs(arms[:, 0, 0] * arms[:, 1, 1] - arms[:, 0, 1] * arms[:, 1, 0])
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    mesh = MeshTri(nodes.T.copy(), triangles[area > 1e-3 * longest**2].T.copy())
    basis = Basis(mesh, ElementVector(ElementTriP1()), intorder=3)
    lam = solid.E * solid.nu / ((1 + solid.nu) * (1 - 2 * solid.nu))
    mu = solid.E / (2 * (1 + solid.nu))

    @BilinearForm
    def stiffness(u, v, w):  # type: ignore[no-untyped-def]
        r, du, dv = w.x[0], u.grad, v.grad
        strain_u = (du[0, 0], du[1, 1], u[0] / r, du[0, 1] + du[1, 0])
        strain_v = (dv[0, 0], dv[1, 1], v[0] / r, dv[0, 1] + dv[1, 0])
        trace = sum(strain_u[:3]) * sum(strain_v[:3])
        pairs = 2 * mu * sum(a * b for a, b in zip(strain_u[:3], strain_v[:3], strict=True))
        return 2 * np.pi * r * (lam * trace + pairs + mu * strain_u[3] * strain_v[3])

    @BilinearForm
    def inertia(u, v, w):  # type: ignore[no-untyped-def]
        return 2 * np.pi * w.x[0] * solid.rho * (u[0] * v[0] + u[1] * v[1])

    order = np.stack([basis.nodal_dofs[0], basis.nodal_dofs[1]], axis=1).reshape(-1)
    K = sp.csr_matrix(stiffness.assemble(basis))[order][:, order].tocsr()
    mass = np.asarray(inertia.assemble(basis).sum(axis=1)).ravel()[order]
    held = np.zeros(len(mass), dtype=bool)
    held[0::2] = nodes[:, 0] == 0.0  # nodes on the axis stay there
    free = sp.diags((~held).astype(float))
    contact = KDTree(nodes).query(touching)[1]
    return Body(nodes, (free @ K @ free).tocsr(), mass, contact)


def stable_step(of: Body) -> float:
    """Largest stable step of central differences, s: 2/ω of the highest mode."""
    scale = sp.diags(of.mass**-0.5)
    top = spla.eigsh(scale @ of.K @ scale, k=1, which="LM", tol=1e-3, return_eigenvectors=False)
    return 2.0 / math.sqrt(1.01 * float(top[0]))


def strike(upper: Body, lower: Body | None, velocity: float, duration: float) -> Impact:
    """Simulate the impact of `upper` on `lower`, at rest, or on a rigid plane."""
    bodies = [upper] if lower is None else [upper, lower]
    step = 0.9 * min(map(stable_step, bodies))
    n = math.ceil(duration / step)
    u = [np.zeros(len(of.mass)) for of in bodies]
    v = [np.zeros(len(of.mass)) for of in bodies]
    v[0][1::2] = -velocity
    touching = [2 * of.contact + 1 for of in bodies]
    gap = upper.nodes[upper.contact, 1].copy()
    give = [1.0 / of.mass[dofs] for of, dofs in zip(bodies, touching, strict=True)]
    yielding = sum(give)
    force = np.empty(n)
    for i in range(n):
        for of, x, rate in zip(bodies, u, v, strict=True):
            rate -= step * (of.K @ x) / of.mass
            x += step * rate
        opening = gap + u[0][touching[0]]
        if lower is not None:
            opening -= u[1][touching[1]]
        push = np.maximum(-opening, 0.0) / (step * step * yielding)
        for sign, x, rate, dofs, compliance in zip((1, -1), u, v, touching, give, strict=False):
            rate[dofs] += sign * step * push * compliance
            x[dofs] += sign * step * step * push * compliance
        force[i] = push.sum()
    means = [
        float(of.mass[1::2] @ rate[1::2]) / of.total_mass
        for of, rate in zip(bodies, v, strict=True)
    ]
    rebound = means[0] - (means[1] if lower is not None else 0.0)
    return Impact(step * np.arange(n), force, rebound / velocity)
