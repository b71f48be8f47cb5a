"""The stiffness of a body's elements at a contact, which tells roughly how long a contact lasts.

Under impact nearly incompressible material deforms in shear, sideways; single nodes displaced with
all others at rest meet its bulk modulus.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..fem import ContactPoint, stiffness_mass
from ..mesh import Mesh

__all__ = ["contact_stiffness"]


# ν above which λ is taken as it is there. The half-space's (1 - ν)/G goes on almost as before; λ
# grows without bound, and with it bᵀKb: at .49 by a factor of four.
_COMPRESSIBLE = 0.45


def contact_stiffness(tip: ContactPoint) -> float:
    """Return bᵀKb/‖b‖⁴, N/m, with λ of nearly incompressible material kept beside μ.

    Of matrices that came without a mesh the material is not known, and K is taken as it is.
    """
    body, b = tip.body, tip.b
    share = float(b @ b)
    if body.mesh is None or body.material is None or body.material.nu <= _COMPRESSIBLE:
        return float(b @ (body.K @ b)) / share**2
    assert body.free is not None  # a body with a mesh has nodes
    force = np.zeros(3 * body.mesh.n_nodes)
    force[body.free] = b
    moved = force.reshape(-1, 3)
    touched = np.abs(moved).max(axis=1) > 0.0
    cells = body.mesh.cells[touched[body.mesh.cells].any(axis=1)]
    nodes, local = np.unique(cells, return_inverse=True)
    around = Mesh(body.mesh.nodes[nodes], local.reshape(cells.shape), body.mesh.kind)
    shear = body.material.E / (1.0 + body.material.nu)
    softer = replace(body.material, E=shear * (1.0 + _COMPRESSIBLE), nu=_COMPRESSIBLE)
    K, _ = stiffness_mass(around, softer)
    there = moved[nodes].ravel()
    return float(there @ (K @ there)) / share**2
