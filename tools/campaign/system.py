"""The equations of motion of a scene in its own coordinates, from the stars' numbers alone.

Every star is M q'' + C q' + K q = b f + g, u = b'q + R f with f the force at its contact
coordinate. With m0 > 0 the coordinates are the contact's and the oscillators', and R = 0. With
m0 = 0 the contact coordinate is where its springs hold it, u = (sum k_i q_i + f)/s with
s = k0 + sum k_i: so b = k/s, R = 1/s and K = diag(k) - k k'/s. Damping is that of the natural modes
of (K, M); R has none. A frame is a row of masses, with a contact coordinate at each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg

from .case import Body, Case, Frame

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Star:
    """One body's matrices; push: b of each port, shape (ports, n). A wall has no coordinates."""

    mass: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    push: FloatArray
    residual: float
    centre: FloatArray


def star_of(body: Body | Frame) -> Star:
    """Return the matrices of a body."""
    if isinstance(body, Frame):
        return _row(body)
    if body.wall:
        none = np.zeros(0)
        return Star(none, np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((1, 0)), 0.0, none)
    m, k = np.array(body.m), np.array(body.k)
    total = body.k0 + k.sum()
    if body.massless:
        push = k / total
        mass, stiffness = m, np.diag(k) - np.outer(k, push)
        residual, centre = 1.0 / total, m / m.sum()
    else:
        mass = np.concatenate([[body.m0], m])
        stiffness = np.diag(np.concatenate([[total], k]))
        stiffness[0, 1:] = stiffness[1:, 0] = -k
        push = np.zeros(len(mass))
        push[0] = 1.0
        residual, centre = 0.0, mass / mass.sum()
    return Star(mass, stiffness, _damping(body, mass, stiffness), push[None], residual, centre)


def _row(body: Frame) -> Star:
    mass, stiffness = np.array(body.m), np.diag(np.array(body.k0))
    for i, k in enumerate(body.k):
        stiffness[i : i + 2, i : i + 2] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    damping = _damping(body, mass, stiffness)
    return Star(mass, stiffness, damping, np.eye(len(mass)), 0.0, mass / mass.sum())


def _damping(body: Body | Frame, mass: FloatArray, stiffness: FloatArray) -> FloatArray:
    if body.damping is None:
        return np.zeros_like(stiffness)
    if body.damping[0] == "Rayleigh":
        return body.damping[1] * np.diag(mass) + body.damping[2] * stiffness
    omega2, modes = scipy.linalg.eigh(stiffness, np.diag(mass))
    omega = np.sqrt(np.maximum(omega2, 0.0))
    if not body.held:
        omega[0] = 0.0
    shapes = mass[:, None] * modes
    damping: FloatArray = (shapes * (2.0 * body.damping[1] * omega)) @ shapes.T
    return damping


@dataclass(frozen=True, eq=False)
class System:
    """All bodies: q'' = matrix (q, q') + pull + push f, and (u, u') = port (q, q') + residual (f,
    f').

    Attributes
    ----------
    n : int
        Number of coordinates.
    matrix : ndarray, shape (n, 2n)
    push : ndarray, shape (n, ports)
    pull : ndarray, shape (n,)
        Gravity.
    port : ndarray, shape (2 ports, 2n)
    residual : ndarray, shape (ports,)
    centre : ndarray, shape (bodies, n)
    start : ndarray, shape (2n,)
    sides : ndarray, shape (contacts, ports)
        +1 for a, -1 for b.
    gaps : ndarray, shape (contacts,)
    wall_speed : ndarray, shape (bodies,)
    port_speed : ndarray, shape (ports,)
        Of walls.
    first_port : ndarray, shape (bodies + 1,)
    """

    n: int
    matrix: FloatArray
    push: FloatArray
    pull: FloatArray
    port: FloatArray
    residual: FloatArray
    centre: FloatArray
    start: FloatArray
    sides: FloatArray
    gaps: FloatArray
    wall_speed: FloatArray
    port_speed: FloatArray
    first_port: npt.NDArray[np.intp]

    @property
    def fastest(self) -> float:
        """Largest eigenvalue of the free motion, 1/s."""
        if self.n == 0:
            return 0.0
        lower = np.hstack([np.zeros((self.n, self.n)), np.eye(self.n)])
        return float(np.abs(np.linalg.eigvals(np.vstack([lower, self.matrix]))).max())


def system_of(case: Case) -> System:
    """Return the equations of a scene."""
    stars = [star_of(body) for body in case.bodies]
    sizes = [len(star.mass) for star in stars]
    first = np.concatenate([[0], np.cumsum(sizes)])
    ports = np.concatenate([[0], np.cumsum([body.ports for body in case.bodies])])
    n, count, bodies = int(first[-1]), int(ports[-1]), len(stars)
    matrix, push, pull = np.zeros((n, 2 * n)), np.zeros((n, count)), np.zeros(n)
    port, centre = np.zeros((2 * count, 2 * n)), np.zeros((bodies, n))
    start, residual, speed = np.zeros(2 * n), np.zeros(count), np.zeros(count)
    for i, (body, star) in enumerate(zip(case.bodies, stars, strict=True)):
        own, its = slice(first[i], first[i + 1]), slice(ports[i], ports[i + 1])
        rates = slice(n + first[i], n + first[i + 1])
        matrix[own, own] = -star.stiffness / star.mass[:, None]
        matrix[own, rates] = -star.damping / star.mass[:, None]
        push[own, its] = (star.push / star.mass).T
        # What holds a star given by numbers is not known, nor what its weight does to it.
        pull[own] = 0.0 if body.held and isinstance(body, Body) else case.gravity
        port[its, own] = port[count + ports[i] : count + ports[i + 1], rates] = star.push
        residual[its] = star.residual
        centre[i, own] = star.centre
        start[rates] = body.velocity
        speed[its] = body.velocity if body.wall else 0.0
    sides = np.zeros((len(case.contacts), count))
    for j, contact in enumerate(case.contacts):
        sides[j, ports[contact.a] + contact.at[0]] = 1.0
        sides[j, ports[contact.b] + contact.at[1]] = -1.0
    return System(
        n,
        matrix,
        push,
        pull,
        port,
        residual,
        centre,
        start,
        sides,
        np.array([contact.gap for contact in case.contacts]),
        np.array([body.velocity if body.wall else 0.0 for body in case.bodies]),
        speed,
        ports,
    )
