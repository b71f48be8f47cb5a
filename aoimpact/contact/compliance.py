"""Compliance that a model of a body has in place of the half-space's, or layer's, at a contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from ..base import FloatArray

# Frequencies that shape the force of an impact, over and below s = 10/T.
SPAN = 3.0


@dataclass(frozen=True, eq=False)
class Compliance:
    """Compliances of a model of a body at a contact point under a unit force.

    Those of a shell or beam are what its elements have in place of an elastic layer. They hardly
    depend on the radius of the contact.

    Attributes
    ----------
    removed : float
        c = G - R, m/N, of the model's own compliance G at the frequency s and that of the body
        beyond what a contact law contains, R. Negative where the model yields too little.
    varying : float
        How much c changes while the contact grows to the radius a, and with frequency, m/N.
    deflection : ndarray, shape (n_dofs,)
        x, the model's displacement under the unit force at the frequency s, m/N.
    s : float
        rad/s.
    radius : float
        a, m.
    by_width : float
        dR/d(log a), m/N; 0 for a flat contact, and of shells and beams.
    beyond : float
        R of solids, m/N, at the frequency s.
    splitting : Splitting or None
        Of solids.
    mesh_field : ndarray, shape (1 or 2, n_nodes, 3), or None
        The model's approximation of u_B, m/N: the displacement under the force on the nodes less w;
        where the body has shells or beams, also its rotation, 1/N.
    oblique : ndarray, shape (3, 3), or None
        c between the direction of the force and two tangents, m/N; None where these are not given.
    """

    removed: float
    varying: float
    deflection: FloatArray
    s: float
    radius: float
    by_width: float = 0.0
    beyond: float = math.nan
    splitting: Any = None
    mesh_field: Any = None
    oblique: FloatArray | None = None

    def removed_for(self, radius: float | None) -> float:
        """Return c for a contact of another radius, m; `removed` where it is not known."""
        if radius is None or self.by_width == 0.0:
            return self.removed
        return self.removed - self.by_width * math.log(radius / self.radius)

    def of_truncated(self, tip: Any, deflection: FloatArray) -> Compliance:
        """Return the compliances of a model that leaves some of the body's modes out.

        The compliance left out at s, ΔG = bᵀΔx, is left to the contact law (the residual
        flexibility of R. H. MacNeal, Comput. Struct. 1, 581 (1971)). Its slope over s² is minus the
        inertia left out, xᵀMx - x̃ᵀMx̃. Over the frequencies of an impact it changes like that of
        one mode with this compliance and slope.

        Parameters
        ----------
        tip : ContactPoint
        deflection : ndarray, shape (n_dofs,)
            x̃, the truncated model's displacement under the unit force at s, m/N.
        """
        M, field = tip.body.M, self.mesh_field
        # By the direction of travel of the contact point, which may be turned.
        left_out = math.copysign(1.0, tip.b @ self.deflection) * self.deflection - deflection
        missing = float(tip.b @ left_out)
        inertia = float(self.deflection @ (M @ self.deflection) - deflection @ (M @ deflection))
        share = min(self.s**2 * inertia / missing, 1.0) if missing > 0.0 < inertia else 0.0
        slow, fast = (missing / (1.0 + (f**2 - 1.0) * share) for f in (1.0 / SPAN, SPAN))
        if field is not None:
            inward = math.copysign(1.0, self.splitting.frame[2] @ tip.direction)
            field = field - tip.body.at_nodes(inward * left_out, len(field))
        return replace(
            self,
            removed=self.removed - missing,
            varying=self.varying + slow - fast,
            deflection=deflection,
            mesh_field=field,
        )
