"""Displacement and stress of an elastic half-space under a tangential force, in closed form.

The traction q = q₀ √(1 - r²/a²), q₀ = 3F/(2πa²), acts along x on a disc of radius a. Coordinates
are local: z points into the half-space z > 0, and r is the distance from the axis.

By Cerruti's potentials (K. L. Johnson, Contact Mechanics, section 3.1) with F₁ = ∫ q Ω dA,
Ω = z ln(ρ + z) - ρ, the displacement times 4πG is

    u_x = 2 F₁,zz + 2ν F₁,xx - z F₁,xxz
    u_y = 2ν F₁,xy - z F₁,xyz
    u_z = (1 - 2ν) F₁,xz - z F₁,xzz.

The disc has the potential of sources at the depths -it, -a < t < a, of the strength
3 (a² - t²)/(4a³): F₁ and its derivatives are then elementary integrals over t. With D = (1/r) ∂/∂r
derivatives across the axis are written in D f, D² f and D³ f. These follow from each other, since
r² D² f + 2 D f + f,zz = 0 for a harmonic f. The field is continued analytically to z < 0, where a
body with a concave surface has material.
"""

from __future__ import annotations

import math

import numpy as np

from ..base import FloatArray
from .halfspace import IsotropicHalfSpace

# A distance from the axis below this share of that from the disc is replaced by it: it changes the
# field by its square, where the third derivative by D has lost 6 powers of it.
_ON_AXIS = 2e-3

# Distances from the rim below this share of a, where the stress is singular.
_ON_RIM = 1e-9


class ShearedHalfSpace(IsotropicHalfSpace):
    """The field of an isotropic half-space under a unit force along its surface.

    Parameters
    ----------
    material : Material
    radius : float
        a of the traction's disc, m.
    """

    axis = 0

    @property
    def mean_displacement(self) -> float:
        """Mean of u_x under the traction itself, m/N: 0.6 (2 - ν)/(4 G a)."""
        return 0.6 * (2.0 - self.nu) / (4.0 * self.material.shear_modulus * self.radius)

    def _fields(
        self, y: FloatArray, *, stress: bool = False, rough: bool = False
    ) -> tuple[FloatArray, FloatArray]:
        a, nu = self.radius, self.nu
        x1, x2, z = y[..., 0], y[..., 1], y[..., 2]
        r2 = np.maximum(x1 * x1 + x2 * x2, _ON_AXIS**2 * (a * a + z * z))
        # Integrals over the sources: the imaginary part at the depth t = z + ia of one over t.
        t, c, p = z + 1j * a, 1.5 / a**3, a * a + z * z
        q = r2 + t * t
        root = np.sqrt(np.where(np.abs(q) < (_ON_RIM * a) ** 2, (_ON_RIM * a) ** 2, q))
        root = np.where((z < 0.0) & (r2 < a * a), -root, root)  # continued through the disc
        log, cube = np.log(root + t), root**3
        less, more = t * root - r2 * log, t * root + r2 * log
        fzz = c * np.imag(p * log - 2.0 * z * root + 0.5 * less)
        fzzz = -2.0 * c * np.imag(root - z * log)
        fzzzz = -2.0 * c * np.imag((t - z) / root - log)
        d_fzz = -c * np.imag(p * t / (r2 * root) + 2.0 * z / root + log - t / root)
        d_fzzz = -2.0 * c * np.imag((1.0 - z / (root + t)) / root)
        d_fz = (1.0 - c * np.imag(p * root - z * less + cube / 3.0 - r2 * root)) / r2
        d_f = c * np.imag(
            0.5 * p * more - 2.0 / 3.0 * z * cube + 0.25 * t * cube - 0.125 * r2 * more
        )
        d_f = (z - d_f) / r2
        dd_f, dd_fz = -(fzz + 2.0 * d_f) / r2, -(fzzz + 2.0 * d_fz) / r2
        once, twice = 2.0 * nu * d_f - z * d_fz, 2.0 * nu * dd_f - z * dd_fz
        down = (1.0 - 2.0 * nu) * d_fz - z * d_fzz
        u = [2.0 * fzz + once + x1 * x1 * twice, x1 * x2 * twice, x1 * down]
        scale = 1.0 / (4.0 * math.pi * self.material.shear_modulus)
        moved = scale * np.stack(u, axis=-1)
        if not stress:
            return moved, np.zeros(0)
        dd_fzz = -(fzzzz + 2.0 * d_fzz) / r2
        thrice = -2.0 * nu * (d_fzz + 4.0 * dd_f) / r2 + z * (d_fzzz + 4.0 * dd_fz) / r2
        deeper = -(1.0 - 2.0 * nu) * dd_fz - z * dd_fzz
        steeper = (1.0 - 2.0 * nu) * dd_fz - z * dd_fzz
        across = x1 * x1 * thrice + twice
        slope = np.empty((*y.shape[:-1], 3, 3))  # ∂u_i/∂x_j
        slope[..., 0, 0] = x1 * (2.0 * d_fzz + 2.0 * twice + across)
        slope[..., 0, 1] = x2 * (2.0 * d_fzz + across)
        slope[..., 0, 2] = 2.0 * fzzz - (1.0 - 2.0 * nu) * d_fz - z * d_fzz + x1 * x1 * deeper
        slope[..., 1, 0] = x2 * across
        slope[..., 1, 1] = x1 * (twice + x2 * x2 * thrice)
        slope[..., 1, 2] = x1 * x2 * deeper
        slope[..., 2, 0] = down + x1 * x1 * steeper
        slope[..., 2, 1] = x1 * x2 * steeper
        slope[..., 2, 2] = x1 * (-2.0 * nu * d_fzz - z * d_fzzz)
        strain = 0.5 * (slope + slope.swapaxes(-1, -2))
        return moved, scale * np.einsum("ijkl,...kl->...ij", self.stiffness, strain)
