"""Bodies of springs and masses in contact, by SciPy on equations written out here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.integrate

Hertzian = tuple[int, int, float, float]  # first body, second body, k, gap


def matrices(star: Any) -> tuple[np.ndarray, np.ndarray]:
    """K and the diagonal of M of a star, its contact mass first."""
    stiffness = np.diag(np.concatenate([[star.k0 + star.k.sum()], star.k]))
    stiffness[0, 1:] = stiffness[1:, 0] = -star.k
    return stiffness, np.concatenate([[star.m0], star.m])


def run(
    stars: Sequence[Any],
    velocities: Sequence[float],
    contacts: Sequence[Hertzian],
    duration: float,
    *,
    gravity: float = 0.0,
    times: Any = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Contact coordinates and their rates, shapes (bodies, times), and forces (contacts, times)."""
    parts = [matrices(star) for star in stars]
    first = np.cumsum([0, *(len(mass) for _, mass in parts)])
    n, at = int(first[-1]), first[:-1]
    stiffness, mass = np.zeros((n, n)), np.concatenate([mass for _, mass in parts])
    for (k, _), start in zip(parts, at, strict=True):
        stiffness[start : start + len(k), start : start + len(k)] = k
    ends = np.zeros((len(contacts), n))
    for row, (one, two, _, _) in zip(ends, contacts, strict=True):
        row[at[one]], row[at[two]] = 1.0, -1.0
    k = np.array([contact[2] for contact in contacts])
    gap = np.array([contact[3] for contact in contacts])

    def forces(x: np.ndarray) -> np.ndarray:
        depth = np.maximum(ends @ x - (gap if x.ndim == 1 else gap[:, None]), 0.0)
        return (k if x.ndim == 1 else k[:, None]) * depth**1.5

    def motion(_: float, y: np.ndarray) -> np.ndarray:
        x = y[:n]
        pull = stiffness @ x + ends.T @ forces(x)
        return np.concatenate([y[n:], gravity - pull / mass])

    start = np.concatenate(
        [np.zeros(n), np.repeat(np.asarray(velocities, dtype=float), np.diff(first))]
    )
    found = scipy.integrate.solve_ivp(
        motion,
        (0.0, duration),
        start,
        method="DOP853",
        rtol=1e-12,
        atol=1e-18,
        max_step=duration / 200,
        t_eval=[duration] if times is None else times,
    )
    return found.y[at], found.y[n + at], forces(found.y[:n])
