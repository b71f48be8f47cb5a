"""A model that is softer by as much as its elements are too stiff, mode by mode.

An eigenvalue of Galerkin's method is too large by the energy of its mode's error (G. Strang and
G. J. Fix, *An Analysis of the Finite Element Method*, section 6.3). That energy is estimated by the
difference of averaged strain to the elements' own (`fem.stresserror`): a mode with a share θ of its
energy in it has ω² (1 - θ) for ω².
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..base import FloatArray
from ..fem import FEModel, field_error
from .finer import orthonormal, with_rigid
from .interface import InterfaceModel, of_modes
from .star import AOModel

# The true share over θ where it is small: 0.4 to 1.5 on plates, beams, bars and blocks of solid
# elements of first and second order, with a median of 0.8; on plates of shell elements 1 to 3.6,
# and 1.6. These factors cover four of five modes, and histories, of many modes, nearly always.
# Where elements lock nearly all of the energy is false, and θ is right by itself.
_SAFETY = {False: 2.0, True: 2.5}

# No mode is taken to be softer than this.
_LEAST = 0.1


def softer_model(model: AOModel | InterfaceModel) -> InterfaceModel:
    """Return the model in its natural modes, each softer by the error of its elements.

    Parameters
    ----------
    model : AOModel or InterfaceModel
        Made of a body's elements, with a mesh and material.
    """
    tips, body = model.contact_points, model.contact_points[0].body
    reduced = model.coordinates()
    assert reduced is not None  # made of elements
    space = with_rigid(body, orthonormal(body, reduced.basis))
    omega2, within = np.linalg.eigh(space.T @ (body.K @ space))
    rigid = body.rigid_modes.shape[1]
    modes, omega2 = space @ within, np.maximum(omega2, 0.0)
    omega2[:rigid] = 0.0
    pressed = body.at_nodes(np.sum([np.abs(tip.b) for tip in tips], axis=0)) > 0.0
    loaded = np.asarray(pressed.any(axis=(0, 2)))
    for j in range(rigid, len(omega2)):
        omega2[j] *= 1.0 - _false_share(body, modes[:, j], loaded, math.sqrt(omega2[j]))
    order = np.argsort(omega2)
    return of_modes(
        tips, np.sqrt(omega2[order]), modes[:, order], model.linear_solver, model.contact_time
    )


def _false_share(
    body: FEModel, mode: FloatArray, loaded: npt.NDArray[np.bool_], omega: float
) -> float:
    """The share of a mode's energy by which it is too stiff."""
    assert body.mesh is not None
    false, own = field_error(body, body.at_nodes(mode), loaded, omega)
    share = min(float(false.sum() / own.sum()), 1.0 - _LEAST)
    return share * (1.0 + (_SAFETY[body.mesh.thin] - 1.0) * (1.0 - share) ** 2)
