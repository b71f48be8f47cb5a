"""A finer model of a body: the space of a reduced model, and what that leaves out first.

At the frequency iω a model leaves the forces r = b - (K + s²M) X_r unbalanced, in one direction for
each contact point at every s (see recovery.py). The error of the body's displacement is the
response to these forces alone, (K + s²M)⁻¹ r. The rational Krylov space of r, with a shift at the
frequencies where the model ends and a static one in turn, takes in the error where it is largest.
Its vectors are orthogonal to the model's, so that the finer model contains the model.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import scipy

from ..base import FloatArray
from ..fem import (
    SHIFT_TIMES_DURATION,
    FEModel,
    highest_shift,
    near_static,
    own_contact_time,
)
from .interface import InterfaceModel, of_modes
from .modes import star_of_modes
from .star import AOModel
from .subspace import ORDER_FITTED

__all__ = ["finer_model"]

# Vectors that are added for each contact point: half of them leave errors 1.2 times as far from
# the true ones.
_MORE = 16

# Less of a vector than this, or of the model's shapes relative to their size, is rounding.
_NEW, _DEPENDENT = 1e-9, 1e-13


def finer_model(model: AOModel | InterfaceModel) -> AOModel | InterfaceModel:
    """Return a model whose space contains that of a model made of a body's elements.

    It is the model itself where that has all that the contacts excite.
    """
    tips, body = model.contact_points, model.contact_points[0].body
    reduced = model.coordinates()
    assert reduced is not None  # made of elements
    space = with_rigid(body, orthonormal(body, reduced.basis))
    time = model.contact_time or min(map(own_contact_time, tips))
    fast, top = SHIFT_TIMES_DURATION / time, max(map(highest_shift, tips))
    fast = max(fast, min(model.n / len(tips) / ORDER_FITTED * fast, top))
    shifts = (fast, math.sqrt(near_static(body)))
    inverses = [body.inverse(s * s, solutions=_MORE // 2 * len(tips)) for s in shifts]
    loads = np.stack([tip.b for tip in tips], axis=1)
    # Away from the shifts that models are fitted to, where nothing would be left.
    stiffness = body.K + (2.0 * fast) ** 2 * body.M
    forces = stiffness @ space
    forces = loads - forces @ np.linalg.solve(space.T @ forces, space.T @ loads)
    for turn in range(_MORE):
        inverse = inverses[turn % 2]
        found = [inverse.solve(np.ascontiguousarray(load)) for load in forces.T]
        more = _new_directions(body, space, found)
        if not more.shape[1]:
            break
        space, forces = np.hstack([space, more]), body.M @ more
    omega2, within = np.linalg.eigh(space.T @ (body.K @ space))
    omega2 = np.maximum(omega2, 0.0)
    omega2[: body.rigid_modes.shape[1]] = 0.0
    larger: AOModel | InterfaceModel
    if isinstance(model, InterfaceModel):
        larger = of_modes(tips, np.sqrt(omega2), space @ within, model.solver)
    else:
        star = star_of_modes(tips[0], omega2, space @ within, "AO", contact_time=model.contact_time)
        larger = replace(star, damping=model.damping, surface=model.surface)
    return larger if larger.n > model.n else model


def orthonormal(body: FEModel, shapes: FloatArray) -> FloatArray:
    """An M-orthonormal basis of shapes (n_dofs, n), of which some may depend on others."""
    mass = shapes.T @ (body.M @ shapes)
    size = np.sqrt(mass.diagonal())
    size[size == 0.0] = 1.0
    values, vectors = np.linalg.eigh(mass / np.outer(size, size))
    kept = values > _DEPENDENT * values[-1]
    basis = (shapes / size) @ (vectors[:, kept] / np.sqrt(values[kept]))
    lower = np.linalg.cholesky(basis.T @ (body.M @ basis))
    found: FloatArray = scipy.linalg.solve_triangular(lower, basis.T, lower=True).T
    return found


def with_rigid(body: FEModel, space: FloatArray) -> FloatArray:
    return np.hstack([space, _new_directions(body, space, list(body.rigid_modes.T))])


def _new_directions(body: FEModel, space: FloatArray, vectors: list[FloatArray]) -> FloatArray:
    """Return an M-orthonormal basis of vectors beyond an M-orthonormal space, (n_dofs, k)."""
    start = space.shape[1]
    for vector in vectors:
        rest = vector
        for _ in range(2):
            rest = rest - space @ (space.T @ (body.M @ rest))
        length, whole = (math.sqrt(max(x @ (body.M @ x), 0.0)) for x in (rest, vector))
        if length > _NEW * whole:
            space = np.column_stack([space, rest / length])
    return space[:, start:]
