"""Local compliance of a model at a contact, to be replaced by that of a half-space or layer."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from ..base import FloatArray

# The force of an impact depends on frequencies from s/SPAN to s SPAN, with s = 10/duration.
SPAN = 3.0


@dataclass(frozen=True, eq=False)
class Compliance:
    """Compliances of a model of a body at a contact point under a unit force.

    For shells, R is the compliance of their elastic layers. For shells and beams, c hardly depends
    on the contact radius.

    Attributes
    ----------
    removed : float
        c = G - R, m/N, to be removed from the contact law: the model's compliance G at the
        frequency s minus the body's compliance R beyond the part contained in a contact law.
        Negative if the model is too stiff.
    varying : float
        Change of c during an impact, in which the contact radius grows to a and the frequency
        varies, m/N.
    deflection : ndarray, shape (n_dofs,)
        Displacement x of the model under the unit force at the frequency s, m/N.
    s : float
        Frequency (Laplace variable), rad/s.
    radius : float
        Contact radius a, m.
    by_width : float
        dR/d(log a), m/N; 0 for flat contacts and for shells and beams.
    beyond : float
        Compliance R of a solid at the frequency s, m/N; NaN for shells and beams.
    splitting : Splitting or None
        Split u = χ u_B + w of a solid's displacement into a half-space's and a correction.
    mesh_field : ndarray, shape (1 or 2, n_nodes, 3), or None
        The model's approximation of u_B, m/N: its displacement under the nodal forces minus w. For
        bodies with shells or beams, followed by the rotations, 1/N.
    oblique : ndarray, shape (3, 3), or None
        Compliance c for forces and displacements along the direction of the force and two tangents,
        m/N; None without tangents.
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
        """Return the removed compliance c, m/N, for another contact radius, m (None: `removed`)."""
        if radius is None or self.by_width == 0.0:
            return self.removed
        return self.removed - self.by_width * math.log(radius / self.radius)

    def of_truncated(self, tip: Any, deflection: FloatArray) -> Compliance:
        """Return the compliances of a truncated model, which omits some of the body's modes.

        The omitted compliance at s, ΔG = bᵀΔx, is added to the contact law (residual flexibility:
        R. H. MacNeal, Comput. Struct. 1, 581 (1971)). The derivative of ΔG with respect to s² is
        minus the omitted inertia, xᵀMx - x̃ᵀMx̃. The change of ΔG over the frequencies of an impact
        is estimated by a single mode with this compliance and derivative.

        Parameters
        ----------
        tip : ContactPoint
        deflection : ndarray, shape (n_dofs,)
            Displacement x̃ of the truncated model under the unit force at s, m/N.
        """
        M, field = tip.body.M, self.mesh_field
        # The direction of travel, and b, may have been reversed since `deflection` was computed.
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
