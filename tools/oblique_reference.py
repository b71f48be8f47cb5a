"""Resolved reference: a rigid sphere strikes the middle of a block's face at 30° with friction.

``python tools/oblique_reference.py rod`` (or ``plate``) integrates one half of the block, linear
hexahedra graded towards the contact, by central differences with a diagonal mass matrix. The
sphere's parabola presses on each node of the struck face through a stiff layer, and a stiff spring
along the face holds the node up to Coulomb's force. The sphere is a free rigid body. Its parabola
moves with it, or with ``--stays`` remains over the first point of contact, as the package assumes.
``--h`` is the size of the smallest elements, m; ``--until`` the duration, s. A rod at 0.3 mm takes
some ten minutes. Needs scikit-fem. The package is used only at the end, for its result of the same
impact; docs/theory/contact.md has the figures.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from skfem import Basis, ElementHex1, ElementVector, LinearForm, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

import aoimpact as ao

E, NU, RHO = 70e9, 0.33, 2700.0  # aluminium
R, MASS, MU = 0.02, 0.2614, 0.3  # the sphere, m and kg (of steel), and friction
SPEED, ANGLE = 2.0, math.radians(30.0)
VELOCITY = SPEED * np.array([math.sin(ANGLE), 0.0, -math.cos(ANGLE)])

# Sides of the block, m (x, y, z), and numbers of elements in the package's mesh; the sphere strikes
# the middle of the top.
BODIES = {
    "rod": ((0.02, 0.02, 0.06), (10, 10, 30)),  # held at zmin
    "plate": ((0.06, 0.06, 0.012), (30, 30, 6)),  # held at both ends of x
}

# Half width and depth of the finely meshed region, m; growth factor and largest size, m, of the
# elements outside.
FINE, DEEP, GROWTH, MOST = 1.8e-3, 1.4e-3, 1.3, 2.5e-3

# Stiffness of the layer per area over E/h, and time step over the largest stable step.
LAYER, SAFE = 20.0, 0.6


def graded(fine: float, far: float, h: float) -> np.ndarray:
    """Return coordinates from 0 to `far`, m: even steps up to `fine`, growing steps beyond."""
    steps: list[float] = []
    size = h
    while sum(steps) < far - fine:
        size = min(size * GROWTH, MOST)
        steps.append(size)
    scale = (far - fine) / sum(steps)
    even = np.linspace(0.0, fine, round(fine / h) + 1)
    return np.concatenate([even, fine + scale * np.cumsum(steps)])


@dataclass(frozen=True)
class Half:
    """One half of a block, y > 0, and the nodes of its top that the sphere may touch.

    Attributes
    ----------
    K : sparse matrix
        Stiffness, N/m.
    inverse : ndarray, shape (n_dofs,)
        One over the masses, 1/kg; 0 for held dofs.
    top : ndarray, shape (n,)
        Numbers of the top nodes.
    at : ndarray, shape (n, 2)
        x and y of the top nodes, m.
    layer : ndarray, shape (n,)
        Stiffness of the layer over each top node, N/m.
    dt : float
        Time step, s.
    """

    K: Any
    inverse: np.ndarray
    top: np.ndarray
    at: np.ndarray
    layer: np.ndarray
    dt: float

    @classmethod
    def of(cls, body: str, h: float) -> Half:
        """Mesh one half of a body with smallest elements of size `h`, m."""
        lx, ly, lz = BODIES[body][0]
        half = graded(FINE, 0.5 * lx, h)
        x, y = np.concatenate([-half[:0:-1], half]), graded(FINE, 0.5 * ly, h)
        z = -graded(DEEP, lz, h)[::-1]
        mesh, hexahedron = MeshHex.init_tensor(x, y, z), ElementHex1()
        K = linear_elasticity(*lame_parameters(E, NU)).assemble(
            Basis(mesh, ElementVector(hexahedron), intorder=3)
        )
        mass = LinearForm(lambda v, w: RHO * v).assemble(Basis(mesh, hexahedron))
        grid = mesh.p.T
        free = np.ones((len(grid), 3))
        free[grid[:, 1] == 0.0, 1] = 0.0
        free[grid[:, 2] == z[0] if body == "rod" else np.abs(grid[:, 0]) == 0.5 * lx] = 0.0
        top = np.flatnonzero((grid[:, 2] == 0.0) & (np.hypot(*grid[:, :2].T) < FINE))
        wide, deep = np.gradient(x), np.gradient(y)
        deep[0] *= 0.5
        area = wide[np.searchsorted(x, grid[top, 0])] * deep[np.searchsorted(y, grid[top, 1])]
        layer = LAYER * E / h * area
        extra = np.zeros((len(grid), 3))
        extra[top] = layer[:, None]
        inverse = (free / mass[:, None]).ravel()
        root = scipy.sparse.diags(np.sqrt(inverse))
        square = root @ (K + scipy.sparse.diags(extra.ravel())) @ root
        largest = scipy.sparse.linalg.eigsh(square, 1, return_eigenvectors=False, tol=1e-2)
        dt = SAFE * 2.0 / math.sqrt(float(largest[0]))
        return cls(K, inverse, top, grid[top, :2], layer, dt)


@dataclass(frozen=True)
class Reference:
    """Forces of the whole block on the sphere, N, and its final velocity, m/s, and spin, rad/s."""

    t: np.ndarray
    normal: np.ndarray
    along: np.ndarray
    velocity: tuple[float, float]
    spin: float


def march(half: Half, duration: float, *, stays: bool) -> Reference:
    """Step the impact from the first touch, the sphere's parabola moving with it or staying."""
    u, v = np.zeros(len(half.inverse)), np.zeros(len(half.inverse))
    place, speed = np.zeros(2), VELOCITY[[0, 2]].copy()  # of the sphere, along x and z
    turn, spin = 0.0, 0.0  # of the sphere about y, rad and rad/s
    anchor = np.zeros((len(half.top), 2))  # places of zero force of the springs along the face
    steps = math.ceil(duration / half.dt)
    forces = np.zeros((2, steps))
    for step in range(steps):
        push = -(half.K @ u)
        moved = u.reshape(-1, 3)[half.top]
        middle = 0.0 if stays else place[0]
        bottom = place[1] + ((half.at[:, 0] - middle) ** 2 + half.at[:, 1] ** 2) / (2.0 * R)
        press = half.layer * np.maximum(moved[:, 2] - bottom, 0.0)
        past = np.stack([place[0] - R * turn - moved[:, 0], -moved[:, 1]], 1)
        force = half.layer[:, None] * (past - anchor)
        size, most = np.hypot(*force.T), MU * press
        force *= np.where(size > most, most / np.maximum(size, 1e-300), 1.0)[:, None]
        anchor = past - force / half.layer[:, None]
        load = push.reshape(-1, 3)
        load[half.top, 2] -= press
        load[half.top, :2] += force
        v += half.dt * half.inverse * push
        u += half.dt * v
        normal, along = 2.0 * float(press.sum()), -2.0 * float(force[:, 0].sum())
        speed += half.dt / MASS * np.array([along, normal])
        spin -= half.dt * along / (0.4 * MASS * R)
        place += half.dt * speed
        turn += half.dt * spin
        forces[:, step] = normal, along
    t = half.dt * np.arange(steps)
    return Reference(t, *forces, (float(speed[0]), float(speed[1])), spin)


def package(body: str, duration: float) -> Any:
    """Return the package's result of the same impact."""
    (lx, ly, lz), counts = BODIES[body]
    mesh = ao.box_mesh((lx, ly, lz), counts, kind="hexahedron20")
    fixed = [("zmin", "xyz")] if body == "rod" else [("xmin", "xyz"), ("xmax", "xyz")]
    block = ao.FEModel.from_mesh(mesh, ao.Material(E=E, nu=NU, rho=RHO), fixed=fixed)
    sphere = ao.rigid(MASS, inertia=0.4 * MASS * R * R, arm=(0, 0, -R))
    law = ao.Hertz(k=4.0 / 3.0 * E / (1.0 - NU * NU) * math.sqrt(R))
    contact = block.contact(point=(lx / 2, ly / 2, lz))
    return ao.simulate(sphere, contact, VELOCITY, law=law, friction=MU, duration=duration)


def main() -> None:
    """Run the reference and the package, and print both results and their differences."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("body", choices=sorted(BODIES))
    parser.add_argument("--h", type=float, default=0.3e-3)
    parser.add_argument("--stays", action="store_true")
    parser.add_argument("--until", type=float, default=1.65e-4)
    options = parser.parse_args()
    half = Half.of(options.body, options.h)
    found = march(half, options.until, stays=options.stays)
    hit = package(options.body, options.until)
    t, along = found.t, -hit.friction_force[:, 0]
    print(f"{len(half.inverse)} degrees of freedom, {len(t)} steps; the package's in brackets")
    print(f"peak normal force   {found.normal.max():.5g} N ({hit.peak_force:.5g})")
    ours = f"({along.min():.5g} to {along.max():.5g})"
    print(f"friction            {found.along.min():.5g} to {found.along.max():.5g} N {ours}")
    ours = f"({hit.impulse:.5g}, {np.trapezoid(along, hit.t):.5g})"
    pair = f"{np.trapezoid(found.normal, t):.5g}, {np.trapezoid(found.along, t):.5g}"
    print(f"impulses            {pair} N s {ours}")
    print(f"final velocity      {found.velocity} m/s ({hit.projectile.final_velocity})")
    print(f"final spin          {found.spin:.4g} rad/s ({hit.projectile.final_spin})")
    both = ("normal", found.normal, hit.force), ("friction", found.along, along)
    for name, theirs, mine in both:
        off = np.abs(theirs - np.interp(t, hit.t, mine)) / np.abs(theirs).max()
        rms = math.sqrt(off @ off / len(t))
        print(f"{name}: off by {off.max():.3g} of its peak at most, {rms:.3g} rms")


if __name__ == "__main__":
    main()
