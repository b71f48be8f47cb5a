"""Preconditioned conjugate gradients for a symmetric positive definite matrix."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..base import ConvergenceError, FloatArray, SingularError, bar

_Map = Callable[[FloatArray], FloatArray]


class Found(NamedTuple):
    """Result of conjugate gradients.

    Attributes
    ----------
    x : ndarray, shape (n,)
    iterations : int
    left : float
        ‖f - A x‖ / ‖f‖, as the iteration has it.
    """

    x: FloatArray
    iterations: int
    left: float


def conjugate_gradients(
    product: _Map,
    precondition: _Map,
    load: FloatArray,
    *,
    tolerance: float,
    most: int,
    what: str,
    label: str,
) -> Found:
    """Solve A x = f to ‖f - A x‖ ≤ `tolerance` ‖f‖, or as far as `most` iterations get.

    With β after Polak and Ribière, which forgives a preconditioner its rounding.

    Parameters
    ----------
    product, precondition : callable
        x ↦ A x and r ↦ about A⁻¹ r, symmetric.
    load : ndarray, shape (n,)
    what, label : str
        The matrix in messages, and the work in progress bars.

    Raises
    ------
    SingularError
        If a motion turns out to have no positive stiffness.
    ConvergenceError
        If the preconditioner is not positive: of a matrix that is nearly singular, by its rounding.
    """
    size = math.sqrt(inner(load, load))
    if size == 0.0:
        return Found(np.zeros_like(load), 0, 0.0)
    x, r = np.zeros_like(load), load
    z = precondition(r)
    p, rz, reached, digits = z, inner(r, z), 0.0, -math.log10(tolerance)
    with bar(label, digits, unit="digit") as progress:
        for iteration in range(1, most + 1):
            along = product(p)
            curvature = inner(p, along)
            if not rz > 0.0:
                raise ConvergenceError(
                    f"iterations with {what} have to be given up: it is nearly singular, and the "
                    "rounding of what speeds them up takes over; take another solver"
                )
            if not curvature > 0.0:
                raise SingularError(
                    f"{what} is singular or not positive definite: a motion has a stiffness "
                    f"of {curvature:.2g}"
                )
            step = rz / curvature
            x += step * p
            before = r
            r = r - step * along
            left = math.sqrt(inner(r, r)) / size
            if left <= tolerance or iteration == most:
                return Found(x, iteration, left)
            progress.update(max(0.0, -math.log10(left) - reached))
            reached = max(reached, -math.log10(left))
            z = precondition(r)
            rz_next = inner(r, z)
            p = z + (rz_next - inner(before, z)) / rz * p
            rz = rz_next
    raise ValueError(f"at least one iteration is needed, got {most}")


def inner(a: FloatArray, b: FloatArray) -> float:
    """Return aᵀb without BLAS, whose threads keep cores busy after it and change the last bits."""
    return float(np.einsum("i,i->", a, b))
