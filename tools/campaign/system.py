"""The equations of motion of a scene in its own coordinates, from the stars' numbers alone.

Every body is M q'' + C q' + K q = b f + g, u = b'q + R f with the forces f at its contact
coordinates. If these have masses, q has all coordinates of the body, and R = 0. A massless contact
coordinate is in balance with its springs, u = (sum k_i q_i + f)/s with s = k0 + sum k_i: so
b = k/s, R = 1/s and K = diag(k) - k k'/s. Damping is that of the natural modes of (K, M); R has
none. A frame is a row of masses, with a contact coordinate at each.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg

from .case import Body, Case, Frame
from .outcome import FloatArray


def stiffness_of(body: Body | Frame) -> FloatArray:
    """Return K of all coordinates of a body, including a massless contact's."""
    stiffness = np.zeros((len(body.masses), len(body.masses)))
    for i, j, k in body.springs:
        stiffness[i, i] += k
        if j != i:
            stiffness[j, j] += k
            stiffness[i, j] = stiffness[j, i] = -k
    return stiffness


def starts(sizes: Iterable[int]) -> npt.NDArray[np.intp]:
    """Return the first index of each of consecutive parts of these sizes, and the end."""
    return np.cumsum([0, *sizes])


def sides_of(case: Case, first: npt.NDArray[np.intp], count: int) -> FloatArray:
    """Return rows with +1 at the coordinate of body a and -1 at that of b, for each contact."""
    sides = np.zeros((len(case.contacts), count))
    for c, contact in enumerate(case.contacts):
        sides[c, first[contact.a] + contact.at[0]] = 1.0
        sides[c, first[contact.b] + contact.at[1]] = -1.0
    return sides


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
    """Equations of all bodies: q'' = matrix (q, q') + pull + push f.

    The contact coordinates and their rates are (u, u') = port (q, q') + residual (f, f').

    Attributes
    ----------
    n : int
        Number of coordinates.
    matrix : ndarray, shape (n, 2n)
    push : ndarray, shape (n, ports)
    pull : ndarray, shape (n,)
        Acceleration by gravity, m/s².
    port : ndarray, shape (2 ports, 2n)
    residual : ndarray, shape (ports,)
        Residual compliance, m/N.
    centre : ndarray, shape (bodies, n)
        Weights of the coordinates in the centres of mass.
    start : ndarray, shape (2n,)
        Initial q and q'.
    sides : ndarray, shape (contacts, ports)
        +1 for body a of a contact, -1 for body b.
    gaps : ndarray, shape (contacts,)
        Initial gaps, m.
    wall_speed : ndarray, shape (bodies,)
        Velocities of walls, m/s; 0 for other bodies.
    port_speed : ndarray, shape (ports,)
        Velocities of the ports of walls, m/s; 0 for other ports.
    first_port : ndarray, shape (bodies + 1,)
        Number of each body's first port, and of all ports.
    fastest : float
        Largest magnitude of an eigenvalue of the free motion, 1/s.
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
    fastest: float


def system_of(case: Case) -> System:
    """Return the equations of a scene; a wall has no coordinates."""
    first = starts(0 if of.wall else len(of.masses) - of.massless for of in case.bodies)
    ports = starts(body.ports for body in case.bodies)
    n, count, bodies = int(first[-1]), int(ports[-1]), len(case.bodies)
    matrix, push, pull = np.zeros((n, 2 * n)), np.zeros((n, count)), np.zeros(n)
    port, centre = np.zeros((2 * count, 2 * n)), np.zeros((bodies, n))
    start, residual, speed = np.zeros(2 * n), np.zeros(count), np.zeros(count)
    for i, body in enumerate(case.bodies):
        own, its = slice(first[i], first[i + 1]), slice(ports[i], ports[i + 1])
        rates = slice(n + first[i], n + first[i + 1])
        if body.wall:
            speed[its] = body.velocity
            continue
        mass, stiffness = np.array(body.masses), stiffness_of(body)
        unit = np.eye(body.ports, len(mass))
        if body.massless:
            unit, residual[its] = -stiffness[:1, 1:] / stiffness[0, 0], 1.0 / stiffness[0, 0]
            mass, stiffness = mass[1:], stiffness[1:, 1:] + stiffness[1:, :1] @ unit
        matrix[own, own] = -stiffness / mass[:, None]
        matrix[own, rates] = -_damping(body, mass, stiffness) / mass[:, None]
        push[own, its] = (unit / mass).T
        # A held AO model given by numbers has unknown supports, so that its weight does not act.
        pull[own] = 0.0 if body.held and isinstance(body, Body) else case.gravity
        port[its, own] = port[count + ports[i] : count + ports[i + 1], rates] = unit
        centre[i, own] = mass / mass.sum()
        start[rates] = body.velocity
    whole = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), matrix])
    return System(
        n,
        matrix,
        push,
        pull,
        port,
        residual,
        centre,
        start,
        sides_of(case, ports, count),
        np.array([contact.gap for contact in case.contacts]),
        np.array([body.velocity if body.wall else 0.0 for body in case.bodies]),
        speed,
        ports,
        float(np.abs(np.linalg.eigvals(whole)).max(initial=0.0)),
    )
