"""Conjugate gradients with a preconditioner."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..base import ConvergenceError, FloatArray, SingularError, bar
from .smoother import inner

# Three times what multigrid takes on the worst bodies measured: a cube takes 13, a sheet 150 times
# as long as thick 142, a cube of ν = .499 169.
_MOST_ITERATIONS = 500


def conjugate_gradients(
    name: str,
    what: str,
    product: Callable[[FloatArray], FloatArray],
    precondition: Callable[[FloatArray], FloatArray],
    rhs: FloatArray,
    tolerance: float,
    most: float,
) -> tuple[FloatArray, int]:
    """Return A⁻¹ `rhs`, shape (n,), and the iterations that it took.

    To half of ‖f - A x‖ / ‖f‖ = `tolerance`, since the residual that is computed afresh comes out
    slightly larger. With β after Polak and Ribière, which forgives the preconditioner its rounding.

    Parameters
    ----------
    name, what : str
        The method and the matrix, for messages.
    product, precondition : callable
        x ↦ A x, and r ↦ about A⁻¹ r, symmetric and positive definite.
    rhs : ndarray, shape (n,)
    tolerance : float
    most : float
        Iterations at most.

    Raises
    ------
    SingularError
        If a motion turns out to have no positive stiffness.
    ConvergenceError
        If the iterations do not suffice, or the preconditioner is not positive: of a matrix that is
        nearly singular, by its rounding.
    """
    limit, tolerance = max(1, int(min(most, _MOST_ITERATIONS))), 0.5 * tolerance
    size = math.sqrt(inner(rhs, rhs))
    if size == 0.0:
        return np.zeros_like(rhs), 0
    x, r = np.zeros_like(rhs), rhs
    label, digits = f"{name}, {len(rhs)} dofs", -math.log10(tolerance)
    with bar(label, digits, unit="digit") as progress:
        p = z = precondition(r)
        rz, reached = inner(r, z), 0.0
        for iteration in range(1, limit + 1):
            along = product(p)
            curvature = inner(p, along)
            if not rz > 0.0:
                raise ConvergenceError(
                    f"iterations with {what} have to be given up: it is nearly singular, and the "
                    "rounding of what speeds them up takes over; take another solver"
                )
            if not curvature > 0.0:
                raise SingularError(
                    f"{what} is singular or not positive definite: a motion has a stiffness of "
                    f"{curvature:.2g}"
                )
            step = rz / curvature
            x += step * p
            before, r = r, r - step * along
            left = math.sqrt(inner(r, r)) / size
            if left <= tolerance:
                return x, iteration
            progress.update(max(0.0, -math.log10(left) - reached))
            reached = max(reached, -math.log10(left))
            z = precondition(r)
            rz_next = inner(r, z)
            p = z + (rz_next - inner(before, z)) / rz * p
            rz = rz_next
    raise ConvergenceError(
        f"solver {name!r} of {what} ({len(rhs)} dofs) reached {left:.2g} of the right-hand side in "
        f"{limit} iterations, {tolerance:g} was asked for: the matrix is nearly singular (a "
        "mechanism, missing supports, ν near .5) or its elements are flat. Take another solver"
    )
