"""Contact coordinates without mass: their deflections by balance, and the rates of these.

A deflection w is u - u_free, what the forces of contacts bend the residual compliance by. The
balance is w / R + the sum of the contact forces on the coordinate = 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from .formulas import Formula, Value

FloatArray = npt.NDArray[np.float64]
Ends = Sequence[tuple[int, int]]

_MOST = 200
_SHORTEST = 1e-6


def balance(
    place: FloatArray,
    w: FloatArray,
    ports: tuple[int, ...],
    touching: Mapping[int, tuple[Formula, float]],
    ends: Ends,
    spring: FloatArray,
    sizes: tuple[float, float],
) -> None:
    """Find the deflections of `ports` in balance with elastic forces: a convex problem.

    Parameters
    ----------
    place : ndarray
        Of all ports without their deflections, m.
    w : ndarray
        A guess, overwritten by the solution, m.
    ports : tuple of int
    touching : mapping
        Of the contacts that may press on them: law and gap.
    ends : sequence of (port, port)
    spring : ndarray
        1/R, N/m.
    sizes : (length, force)
        By which rounding is told, m and N.
    """
    length, force = sizes

    def left() -> tuple[FloatArray, FloatArray]:
        over, slope = [-spring[p] * w[p] for p in ports], np.diag(spring[list(ports)])
        for c, (law, gap) in touching.items():
            a, b = ends[c]
            push, stiffness, _ = law.at(float(place[a] + w[a] - place[b] - w[b]) - gap)
            signs = [(ports.index(p), s) for p, s in ((a, 1.0), (b, -1.0)) if p in ports]
            for i, s in signs:
                over[i] -= s * push
                for j, r in signs:
                    slope[i, j] += s * r * stiffness
        return np.array(over), slope

    here = list(ports)
    over, slope = left()
    error = max(map(abs, over))
    for _ in range(_MOST):
        if error <= 1e-15 * force:
            return
        step = np.linalg.solve(slope, over) if len(ports) > 1 else over / slope[0, 0]
        before, share = w[here], 1.0
        while True:
            w[here] = before + share * step
            over, slope = left()
            new = max(map(abs, over))
            if new < error or share < _SHORTEST:
                break
            share *= 0.5
        small = max(map(abs, step)) <= 1e-15 * (max(map(abs, w[here])) + length)
        if new >= error and small:
            return
        error = new


def follow(
    speed: FloatArray,
    ports: tuple[int, ...],
    values: Mapping[int, Value],
    ends: Ends,
    spring: FloatArray,
) -> FloatArray:
    """Return the rates of those deflections, m/s; `speed`: of all ports without them."""
    matrix, over = np.diag(spring[list(ports)]), np.zeros(len(ports))
    for c, (_, stiffness, _) in values.items():
        _add(
            matrix,
            over,
            ports,
            ends[c],
            stiffness,
            stiffness * (speed[ends[c][0]] - speed[ends[c][1]]),
        )
    return np.linalg.solve(matrix, over)


def flow(
    speed: FloatArray,
    w: FloatArray,
    ports: tuple[int, ...],
    values: Mapping[int, Value],
    ends: Ends,
    spring: FloatArray,
    lag: float,
) -> FloatArray:
    """Return the rates, m/s, of deflections that dashpots rule, with one of `lag` s beside them."""
    own = spring[list(ports)]
    matrix, over = np.diag(lag * own), -own * w[list(ports)]
    for c, (elastic, _, damper) in values.items():
        push = elastic + damper * (speed[ends[c][0]] - speed[ends[c][1]])
        _add(matrix, over, ports, ends[c], damper, push)
    return np.linalg.solve(matrix, over)


def _add(
    matrix: FloatArray,
    over: FloatArray,
    ports: tuple[int, ...],
    ends: tuple[int, int],
    slope: float,
    push: float,
) -> None:
    """Add a contact to the equations of `ports`."""
    signs = [(ports.index(p), s) for p, s in zip(ends, (1.0, -1.0), strict=True) if p in ports]
    for i, s in signs:
        over[i] -= s * push
        for j, r in signs:
            matrix[i, j] += s * r * slope
