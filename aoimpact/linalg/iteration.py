"""Conjugate gradients with a preconditioner."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ..base import ConvergenceError, FloatArray, SingularError, bar

# Maximum number of iterations: three times as many as multigrid takes on the worst bodies measured.
# A cube takes 13, a sheet 150 times as long as thick 142, a cube of ν = 0.499 169.
_MOST_ITERATIONS = 500


def conjugate_gradients(
    name: str,
    what: str,
    product: Callable[[FloatArray], FloatArray],
    precondition: Callable[[FloatArray], FloatArray],
    rhs: FloatArray,
    tolerance: float,
    most: float,
    at_once: int = 1,
) -> tuple[FloatArray, int]:
    """Return A⁻¹ `rhs`, shape (n,) or (n, m), and the number of preconditioned residuals used.

    Each column iterates until ‖f - A x‖ / ‖f‖ ≤ `tolerance` / 2 by the recursive residual, since
    the residual computed from x is slightly larger. β is that of Polak and Ribière, which tolerates
    rounding in the preconditioner.

    Parameters
    ----------
    name, what : str
        Names of the method and of the matrix, for messages.
    product, precondition : callable
        x ↦ A x, and r ↦ ≈ A⁻¹ r, symmetric positive definite; x, r: (n, columns not converged).
    rhs : ndarray, shape (n,) or (n, m)
    tolerance : float
    most : float
        Maximum number of iterations.
    at_once : int, optional
        Number of columns solved together. With 1, each column is bit for bit as if solved alone.

    Raises
    ------
    SingularError
        If a motion turns out to have no positive stiffness.
    ConvergenceError
        If the iterations do not suffice, or rounding makes the preconditioner indefinite, as for a
        nearly singular matrix.
    """
    if (count := rhs[0].size) > at_once:
        given: dict[str, Any] = {"tolerance": tolerance, "most": most, "at_once": at_once}
        solved = partial(conjugate_gradients, name, what, product, precondition, **given)
        each = np.split(rhs, range(at_once, count, at_once), axis=1)
        columns, counts = zip(*map(solved, each), strict=True)
        return np.hstack(columns), sum(counts)
    limit, tolerance = max(1, int(min(most, _MOST_ITERATIONS))), 0.5 * tolerance
    r = rhs.reshape(len(rhs), -1)
    found, size, taken = np.zeros_like(r), np.sqrt(_inner(r, r)), 0
    going = np.flatnonzero(size)
    if not len(going):
        return found.reshape(rhs.shape), 0
    r, size = r[:, going], size[going]
    x = np.zeros_like(r)
    label, digits = f"{name}, {len(rhs)} dofs", -math.log10(tolerance)
    with bar(label, digits, unit="digit") as progress:
        p = z = precondition(r)
        rz, reached = _inner(r, z), 0.0
        for _ in range(limit):
            taken += len(going)
            along = product(p)
            curvature = _inner(p, along)
            if not (rz > 0.0).all():
                raise ConvergenceError(
                    f"iterations with {what} stopped: it is nearly singular, and rounding errors "
                    "in the preconditioner dominate; take another solver"
                )
            if not (curvature > 0.0).all():
                raise SingularError(
                    f"{what} is singular or not positive definite: a motion has a stiffness of "
                    f"{curvature.min():.2g}"
                )
            step = rz / curvature
            x += step * p
            before, r = r, r - step * along
            left = np.sqrt(_inner(r, r)) / size
            if (done := left <= tolerance).any():
                found[:, going[done]] = x[:, done]
                if done.all():
                    return found.reshape(rhs.shape), taken
                x, r, before, p = (of[:, ~done] for of in (x, r, before, p))
                going, left, size, rz = going[~done], left[~done], size[~done], rz[~done]
            digits = -math.log10(left.max())
            progress.update(max(0.0, digits - reached))
            reached = max(reached, digits)
            z = precondition(r)
            rz_next = _inner(r, z)
            p = z + (rz_next - _inner(before, z)) / rz * p
            rz = rz_next
    raise ConvergenceError(
        f"solver {name!r} of {what} ({len(rhs)} dofs) left a residual of {left.max():.2g} of the "
        f"right-hand side in {limit} iterations, instead of {tolerance:g}: nearly singular matrix "
        "(a mechanism, missing supports, ν near .5) or flat elements. Take another solver"
    )


def by_columns(of: Callable[[FloatArray], FloatArray]) -> Callable[[FloatArray], FloatArray]:
    """Return the function of arrays of shape (n, m) that applies `of` to each column."""
    return lambda x: np.column_stack([of(column) for column in x.T])


def _inner(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return aᵀb of each column, without BLAS for the reasons of `smoother.inner`."""
    return np.asarray(np.einsum("ij,ij->j", a, b))
