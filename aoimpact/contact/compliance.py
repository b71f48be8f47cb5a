"""Compliance that a model of a body has in place of the half-space's, or layer's, at a contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Self

from ..base import FloatArray

# Frequencies that shape the force of an impact, over and below s = 10/T.
_SPAN = 3.0


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactCompliance:
    """Compliances of a model of a body at a contact point under a unit force.

    Attributes
    ----------
    removed : float
        c = G - R, m/N, of the model's own compliance G at the frequency s and that of the body
        beyond what a contact law contains, R. Negative where the model yields too little.
    error : float
        Estimated error of R, m/N.
    varying : float
        How much c changes while the contact grows to the radius a, and with frequency, m/N.
    deflection : ndarray, shape (n_dofs,)
        x, the model's displacement under the unit force at the frequency s, m/N.
    strain : float
        xᵀKx, m/N.
    s : float
        rad/s.
    radius : float
        a, m.
    lagging : float
        dc/d(ln s), m/N, where c keeps changing with the frequency. The displacement c F then lags
        behind the force, as that of a dashpot does.
    """

    removed: float
    error: float
    varying: float
    deflection: FloatArray
    strain: float
    s: float
    radius: float
    lagging: float = 0.0

    by_width = 0.0

    def removed_for(self, radius: float | None) -> float:
        """Return c for a contact of another radius, m; `removed` where it is not known."""
        return self.removed

    def of_truncated(self, tip: Any, deflection: FloatArray) -> Self:
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
        K, M = tip.body.K, tip.body.M
        missing = float(tip.b @ self.missing(tip, deflection))
        inertia = float(self.deflection @ (M @ self.deflection) - deflection @ (M @ deflection))
        share = min(self.s**2 * inertia / missing, 1.0) if missing > 0.0 < inertia else 0.0
        slow, fast = (missing / (1.0 + (f**2 - 1.0) * share) for f in (1.0 / _SPAN, _SPAN))
        return replace(
            self,
            removed=self.removed - missing,
            varying=self.varying + slow - fast,
            deflection=deflection,
            strain=float(deflection @ (K @ deflection)),
        )

    def missing(self, tip: Any, deflection: FloatArray) -> FloatArray:
        """Return Δx, m/N, by the direction of travel of the contact point, which may be turned."""
        turned: FloatArray = math.copysign(1.0, tip.b @ self.deflection) * self.deflection
        return turned - deflection
