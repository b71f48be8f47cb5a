"""Models of a body that leave less out than a given one: finer, and as soft as the body is.

At the frequency iω a model leaves the forces r = b - (K + s²M) X_r unbalanced, in one direction for
each contact point at every s (see recovery.py). The error of the body's displacement is the
response to these forces alone, (K + s²M)⁻¹ r. The rational Krylov space of r, with a shift at the
frequencies where the model ends and a static one in turn, takes in the error where it is largest.
Its vectors are orthogonal to the model's, so that the finer model contains the model.

An eigenvalue of Galerkin's method is too large by the energy of its mode's error (G. Strang and
G. J. Fix, *An Analysis of the Finite Element Method*, section 6.3). That energy is estimated by the
difference of averaged strain to the elements' own (`fem.stresserror`): a mode with a share θ of its
energy in it has ω² (1 - θ) for ω².
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..contact import SHIFT_TIMES_DURATION, highest_shift, own_contact_time
from ..fem import energy_error, near_static
from ..linalg import m_orthonormal
from .body import Body, of_modes
from .krylov import ORDER_FITTED, only_excited

# Vectors that are added for each contact point: half of them leave errors 1.2 times as far from
# the true ones.
_MORE = 16

# The true share over θ where it is small: 0.4 to 1.5 on plates, beams, bars and blocks of solid
# elements of first and second order, with a median of 0.8; on plates of shell elements 1 to 3.6,
# and 1.6. These factors cover four of five modes, and histories, of many modes, nearly always.
# Where elements lock nearly all of the energy is false, and θ is right by itself.
_SAFETY = {False: 2.0, True: 2.5}

# No mode is taken to be softer than this.
_LEAST = 0.1


def finer_model(model: Body) -> Body:
    """Return a model whose space contains that of a model made of a body's elements.

    It is the model itself where that has all that the contacts excite.
    """
    tips, body = model.tips, model.body
    space = np.hstack([model.modes, m_orthonormal(model.modes, body.rigid_modes, body.M)])
    time = model.contact_time or min(map(own_contact_time, tips))
    fast, top = SHIFT_TIMES_DURATION / time, max(map(highest_shift, tips))
    fast = max(fast, min(model.n / len(tips) / ORDER_FITTED * fast, top))
    shifts = (fast, math.sqrt(near_static(body)))
    inverses = [body.inverse(s * s, solutions=_MORE // 2 * len(tips)) for s in shifts]
    loads = model.loads()
    # Away from the shifts that models are fitted to, where nothing would be left.
    stiffness = body.K + (2.0 * fast) ** 2 * body.M
    forces = stiffness @ space
    forces = loads - forces @ np.linalg.solve(space.T @ forces, space.T @ loads)
    for turn in range(_MORE):
        inverse = inverses[turn % 2]
        found = [inverse.solve(np.ascontiguousarray(load)) for load in forces.T]
        more = m_orthonormal(space, np.stack(found, axis=1), body.M)
        if not more.shape[1]:
            break
        space, forces = np.hstack([space, more]), body.M @ more
    omega2, within = np.linalg.eigh(space.T @ (body.K @ space))
    omega2 = np.maximum(omega2, 0.0)
    omega2[: body.rigid_modes.shape[1]] = 0.0
    larger = of_modes(tips, omega2, space, within, kind=model.kind, contact_time=model.contact_time)
    if model.kind in ("AO", "rigid"):
        larger = only_excited(larger)
    return larger if larger.n > model.n else model


def softer_model(model: Body) -> Body:
    """Return a model whose modes are each softer by the error of its elements.

    Parameters
    ----------
    model : Body
        Made of a body's elements, with a mesh and material.
    """
    body, omega2 = model.body, model.omega**2
    assert body.mesh is not None
    safety = _SAFETY[body.mesh.thin] - 1.0
    pressed = body.at_nodes(np.sum([np.abs(tip.b) for tip in model.tips], axis=0)) > 0.0
    loaded = np.asarray(pressed.any(axis=(0, 2)))
    for j in np.flatnonzero(omega2):
        moved = body.at_nodes(model.modes[:, j])
        false, own = energy_error(body, moved, loaded, float(model.omega[j]))
        share = min(float(false.sum() / own.sum()), 1.0 - _LEAST)
        omega2[j] *= 1.0 - share * (1.0 + safety * (1.0 - share) ** 2)
    order = np.argsort(omega2, kind="stable")
    shape = np.ascontiguousarray(model.shape[:, order])
    return replace(
        model,
        omega=np.sqrt(omega2[order]),
        shape=shape,
        push=shape,
        vectors=model.modes[:, order],
        coordinates=None,
        follow=None,
        residual=None,
        oscillators=None,
    )
