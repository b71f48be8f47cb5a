"""A rigid sphere strikes the middle of a block's face at 30° with friction: a resolved reference.

``python tools/oblique_reference.py rod`` (or ``plate``) steps one half of the block, linear
hexahedra graded towards the contact, by central differences with a diagonal mass matrix. Each node
of the struck face is pressed by the sphere's parabola, over a stiff layer, and held by a stiff
spring along the face up to Coulomb's force. The sphere is a free rigid body. Its parabola moves
with it, or with ``--stays`` remains over the first point of contact, as the package assumes.
``--h`` is the size of the smallest elements, m; ``--until`` the duration, s; ``--out`` a file for
the histories. A rod at 0.3 mm takes some ten minutes. Nothing is taken from the package but, at the
end, its own answer to the same impact; docs/theory/contact.md has the figures.
"""

from __future__ import annotations

import argparse
import math
import time as clock
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

import aoimpact as ao

E, NU, RHO = 70e9, 0.33, 2700.0  # aluminium
R, MASS, MU = 0.02, 0.2614, 0.3  # the sphere: of steel's mass
SPEED, ANGLE = 2.0, math.radians(30.0)
VELOCITY = SPEED * np.array([math.sin(ANGLE), 0.0, -math.cos(ANGLE)])

# Sides of the block, m (x, y, z), and the counts of the package's elements; the sphere comes down
# on the middle of the top.
BODIES: dict[str, tuple[tuple[float, float, float], tuple[int, int, int]]] = {
    "rod": ((0.02, 0.02, 0.06), (10, 10, 30)),  # held at zmin
    "plate": ((0.06, 0.06, 0.012), (30, 30, 6)),  # held at both ends of x
}

# Half of the finely meshed width and its depth, m; growth of elements outside, and their most, m.
FINE, DEEP, GROWTH, MOST = 1.8e-3, 1.4e-3, 1.3, 2.5e-3

# Stiffness of the layer, in E/h; the share of the largest stable step; steps between two reports.
LAYER, SAFE, REPORT = 20.0, 0.6, 500


def graded(fine: float, far: float, h: float) -> np.ndarray:
    """Places from 0 outward to `far`, even up to `fine`, then growing."""
    steps: list[float] = []
    size = h
    while sum(steps) < far - fine:
        size = min(size * GROWTH, MOST)
        steps.append(size)
    scale = (far - fine) / sum(steps)
    even = np.linspace(0.0, fine, round(fine / h) + 1)
    return np.concatenate([even, fine + scale * np.cumsum(steps)])


def stiffness(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[Any, np.ndarray]:
    """K of boxes of eight nodes, by 2 x 2 x 2 points, and the lumped masses of the nodes."""
    nx, ny, nz = len(x), len(y), len(z)
    number = np.arange(nx * ny * nz).reshape(nx, ny, nz)
    corner = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    nodes = np.stack(
        [number[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k].ravel() for i, j, k in corner], 1
    )
    sides = np.meshgrid(np.diff(x), np.diff(y), np.diff(z), indexing="ij")
    size = np.stack(sides, -1).reshape(-1, 3)
    volume = size.prod(axis=1)
    lame, shear = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
    D = np.diag([2.0 * shear] * 3 + [shear] * 3)
    D[:3, :3] += lame
    at = 0.5 + 0.5 / math.sqrt(3.0) * np.array([-1.0, 1.0])
    K = np.zeros((len(size), 24, 24))
    for point in [(a, b, c) for a in at for b in at for c in at]:
        B = np.zeros((len(size), 6, 24))
        for n, ijk in enumerate(corner):
            values = [s if i else 1.0 - s for i, s in zip(ijk, point, strict=True)]
            for axis in range(3):
                others = [values[other] for other in range(3) if other != axis]
                slope = (1.0 if ijk[axis] else -1.0) * others[0] * others[1] / size[:, axis]
                B[:, axis, 3 * n + axis] = slope
                for row, pair in ((3, (1, 2)), (4, (0, 2)), (5, (0, 1))):
                    if axis in pair:
                        B[:, row, 3 * n + pair[1 - pair.index(axis)]] = slope
        K += np.einsum("eia,ij,ejb->eab", B, D, B, optimize=True) * (volume / 8.0)[:, None, None]
    dofs = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), 24)
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, (1, 24)).ravel()
    whole = scipy.sparse.csr_matrix((K.ravel(), (rows, columns)), shape=(3 * nx * ny * nz,) * 2)
    mass = np.bincount(nodes.ravel(), np.repeat(RHO * volume / 8.0, 8), nx * ny * nz)
    return whole, mass


@dataclass(frozen=True)
class Half:
    """One half of a block, y > 0, and the nodes of its top that the sphere may touch.

    Attributes
    ----------
    K : sparse matrix
        N/m.
    inverse : ndarray, shape (n_dofs,)
        One over the masses, 1/kg; 0 where a dof is held.
    top : ndarray, shape (n,)
        Numbers of nodes.
    at : ndarray, shape (n, 2)
        Their x and y, m.
    layer : ndarray, shape (n,)
        Stiffness over each, N/m.
    dt : float
        s.
    """

    K: Any
    inverse: np.ndarray
    top: np.ndarray
    at: np.ndarray
    layer: np.ndarray
    dt: float

    @classmethod
    def of(cls, body: str, h: float) -> Half:
        """Mesh a body, down to elements of h, m."""
        lx, ly, lz = BODIES[body][0]
        half = graded(FINE, 0.5 * lx, h)
        x, y = np.concatenate([-half[:0:-1], half]), graded(FINE, 0.5 * ly, h)
        z = -graded(DEEP, lz, h)[::-1]
        K, mass = stiffness(x, y, z)
        grid = np.stack(np.meshgrid(x, y, z, indexing="ij"), -1).reshape(-1, 3)
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
    place, speed = np.zeros(2), VELOCITY[[0, 2]].copy()  # of the sphere, x and z
    turn, spin = 0.0, 0.0  # about y
    anchor = np.zeros((len(half.top), 2))  # where springs along the face are not stretched
    steps = math.ceil(duration / half.dt)
    forces, begin = np.zeros((2, steps)), clock.perf_counter()
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
        if step % REPORT == 0:
            spent = clock.perf_counter() - begin
            print(f"{step * half.dt * 1e6:7.2f} µs {normal:9.1f} {along:9.1f} N  {spent:.0f} s")
    t = half.dt * np.arange(steps)
    return Reference(t, *forces, (float(speed[0]), float(speed[1])), spin)


def package(body: str, duration: float) -> Any:
    """Return the package's answer."""
    (lx, ly, lz), counts = BODIES[body]
    mesh = ao.box_mesh((lx, ly, lz), counts, kind="hexahedron20")
    fixed = [("zmin", "xyz")] if body == "rod" else [("xmin", "xyz"), ("xmax", "xyz")]
    block = ao.FEModel.from_mesh(mesh, ao.Material(E=E, nu=NU, rho=RHO), fixed=fixed)
    sphere = ao.rigid(MASS, inertia=0.4 * MASS * R * R, arm=(0, 0, -R))
    law = ao.Hertz(k=4.0 / 3.0 * E / (1.0 - NU * NU) * math.sqrt(R))
    contact = block.contact(point=(lx / 2, ly / 2, lz))
    return ao.simulate(sphere, contact, VELOCITY, law=law, friction=MU, duration=duration)


def main() -> None:
    """Run both and print what they differ by."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("body", choices=sorted(BODIES))
    parser.add_argument("--h", type=float, default=0.3e-3)
    parser.add_argument("--stays", action="store_true")
    parser.add_argument("--until", type=float, default=1.65e-4)
    parser.add_argument("--out")
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
    if options.out:
        np.savez(options.out, t=t, normal=found.normal, along=found.along)


if __name__ == "__main__":
    main()
