"""Displacement and strain of an elastic half-space under Hertz's pressure, in closed form.

The pressure p = p₀ √(1 - r²/a²), p₀ = 3F/(2πa²), acts on a disc of radius a. Coordinates are local:
z points into the half-space z > 0, and r is the distance from the axis.

Isotropic half-space: M. T. Huber, Ann. Phys. 14, 153 (1904), gives the stress; the displacement is
written so that no digits cancel, with the root u of r²/(a² + u) + z²/u = 1. Both are continued
analytically to z < 0, where a body with a concave surface has material.

Anisotropic half-space: one integral over the angle of plane waves (A. N. Stroh, Phil. Mag. 3, 625,
1958; J. R. Willis, J. Mech. Phys. Solids 14, 163, 1966), for z ≥ 0 only.
"""

from __future__ import annotations

import copy
import math
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from ..base import ArrayPair, FloatArray
from ..fem import Material

# Distances below these shares of a are replaced by them: they change the field by their square.
_ON_AXIS, _ON_RIM = 1e-4, 1e-9

# A distance from the axis below this share of that from the disc is replaced by it under shear: it
# changes the field by its square, where the third derivative by D has lost 6 powers of it.
_ON_AXIS_SHEARED = 2e-3

# Angles of the integral of an anisotropic half-space. The integrand is periodic and smooth, but for
# points far out just below the surface; at r = 8 a and z = 0.4 a the error is 1e-4.
_ANGLES = 128

# A rough displacement takes one of so many angles, for inertia: R of a ply changes by 1e-4 of
# itself (by 1e-2 with one of four).
_EVERY = 2

# Equal roots of Stroh's eigenvalue problem, as of an isotropic material, have no eigenvectors of
# their own. Shear moduli are changed by this share, which leaves half of the digits.
_APART = 1e-7

# Beyond so many radii the pressure's transform is expanded in a/|z|, to 1e-7.
_FAR = 30.0


class HalfSpace:
    """The field of an elastic half-space under a unit force on a disc.

    Attributes
    ----------
    radius : float
        a of the pressure's disc, m.
    stiffness : ndarray, shape (3, 3, 3, 3)
        C_ijkl in local axes, Pa.
    modulus, nu : float
        E*, Pa, and Poisson's ratio; of an anisotropic one those of its isotropic equivalent.
    """

    radius: float
    stiffness: FloatArray
    modulus: float
    nu: float
    axis: ClassVar[int] = 2  # of the force

    @property
    def mean_displacement(self) -> float:
        """Mean of u_z under the pressure itself, m/N: 0.6/(a E*) (Johnson, eq. 3.42a)."""
        return 0.6 / (self.radius * self.modulus)

    def displacement(self, y: FloatArray, *, rough: bool = False) -> FloatArray:
        """Return u at local points `y`, m, shape (..., 3), for a force of 1 N."""
        return self._fields(y, rough=rough)[0]

    def displacement_stress(self, y: FloatArray) -> ArrayPair:
        """Return u, m, shape (..., 3), and σ, Pa, shape (..., 3, 3), for a force of 1 N."""
        return self._fields(y, stress=True)

    @property
    def softness(self) -> FloatArray:
        """S_ijkl of ε = S:σ in local axes, 1/Pa."""
        flat = np.linalg.pinv(self.stiffness.reshape(9, 9))
        return np.asarray(flat.reshape(self.stiffness.shape))

    def of_radius(self, radius: float) -> Self:
        """Return the same half-space under a disc of another radius, m."""
        other = copy.copy(self)
        other.radius = radius
        return other

    def _fields(self, y: FloatArray, *, stress: bool = False, rough: bool = False) -> ArrayPair:
        """Displacement, and stress, which is empty where it is not asked for."""
        raise NotImplementedError


class IsotropicHalfSpace(HalfSpace):
    """The field of an isotropic half-space under a unit force.

    Parameters
    ----------
    material : Material
    radius : float
        a of the pressure's disc, m.
    """

    def __init__(self, material: Material, radius: float) -> None:
        self.material, self.radius = material, radius
        self.stiffness, self.nu = material.tensor, material.nu
        self.modulus = material.plane_strain_modulus

    def _fields(self, y: FloatArray, *, stress: bool = False, rough: bool = False) -> ArrayPair:
        a, nu = self.radius, self.nu
        a2, p0 = a * a, 1.5 / (math.pi * a * a)
        x1, x2, z = y[..., 0], y[..., 1], y[..., 2]
        away = np.hypot(x1, x2)
        r = np.maximum(away, _ON_AXIS * a)
        q = r * r + z * z - a2
        root = np.maximum(np.sqrt(q * q + 4.0 * a2 * z * z), _ON_RIM * a2)
        # The root of u² - q u - a² z² that loses no digits, and by it the other one.
        within = q < 0.0
        h = np.maximum(0.5 * np.where(within, root - q, root + q), _ON_RIM**2 * a2)
        u = np.where(within, a2 * z * z / h, h)
        k = np.where(within, np.sqrt(h) / a, np.abs(z) / np.sqrt(h))
        s = np.sqrt(u)
        through_disc = (z < 0.0) & (r < a)
        k = np.where((z < 0.0) & ~through_disc, -k, k)
        s = np.where(through_disc, -s, s)
        alpha = np.arctan2(a, s)
        share = u / (a2 + u)
        b = (alpha / a - s / (a2 + u)) / a2
        zc = 2.0 / a2 * (k - z * alpha / a)
        v = 0.25 * a2 * p0 * (2.0 * alpha / a - r * r * b - z * zc)
        phi = p0 * (a2 / (3.0 * r * r) * (1.0 - k**3) - 0.5 * k * (s / a * alpha - share))
        twice_mu = 2.0 * self.material.shear_modulus
        across = (-(1.0 - 2.0 * nu) * phi + 0.5 * z * a2 * p0 * b) / twice_mu
        along = (2.0 * (1.0 - nu) * v + 0.5 * a2 * p0 * z * zc) / twice_mu
        moved = np.stack([across * x1, across * x2, along], axis=-1)
        if not stress:
            return moved, np.zeros(0)
        k3, qa = k**3, s / a * alpha
        bending = (1.0 - 2.0 * nu) / 3.0 * a2 / (r * r) * (1.0 - k3)
        hoop = share * (1.0 - nu) - (1.0 + nu) * qa
        rr = bending + k3 * a2 / root + k * (share * (1.0 - nu) + (1.0 + nu) * qa - 2.0)
        tt = -bending - k * (2.0 * nu + hoop)
        rz = -r * k * k * a2 * s / (root * (a2 + u))
        c = np.divide(x1, away, out=np.ones_like(away), where=away > 0.0)
        sn = np.divide(x2, away, out=np.zeros_like(away), where=away > 0.0)
        sigma = np.empty((*y.shape[:-1], 3, 3))
        sigma[..., 0, 0] = rr * c * c + tt * sn * sn
        sigma[..., 1, 1] = rr * sn * sn + tt * c * c
        sigma[..., 0, 1] = sigma[..., 1, 0] = (rr - tt) * c * sn
        sigma[..., 2, 2] = -k3 * a2 / root
        sigma[..., 0, 2] = sigma[..., 2, 0] = rz * c
        sigma[..., 1, 2] = sigma[..., 2, 1] = rz * sn
        return moved, p0 * sigma


class ShearedHalfSpace(IsotropicHalfSpace):
    """The field of an isotropic half-space under a unit force along its surface.

    The traction q = q₀ √(1 - r²/a²), q₀ = 3F/(2πa²), acts along x on a disc of radius a.

    By Cerruti's potentials (K. L. Johnson, Contact Mechanics, section 3.1) with F₁ = ∫ q Ω dA,
    Ω = z ln(ρ + z) - ρ, the displacement times 4πG is

        u_x = 2 F₁,zz + 2ν F₁,xx - z F₁,xxz
        u_y = 2ν F₁,xy - z F₁,xyz
        u_z = (1 - 2ν) F₁,xz - z F₁,xzz.

    The disc has the potential of sources at the depths -it, -a < t < a, of the strength
    3 (a² - t²)/(4a³): F₁ and its derivatives are then elementary integrals over t. With
    D = (1/r) ∂/∂r derivatives across the axis are written in D f, D² f and D³ f. These follow from
    each other, since r² D² f + 2 D f + f,zz = 0 for a harmonic f. The field is continued
    analytically to z < 0, where a body with a concave surface has material.

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

    def _fields(self, y: FloatArray, *, stress: bool = False, rough: bool = False) -> ArrayPair:
        a, nu = self.radius, self.nu
        x1, x2, z = y[..., 0], y[..., 1], y[..., 2]
        r2 = np.maximum(x1 * x1 + x2 * x2, _ON_AXIS_SHEARED**2 * (a * a + z * z))
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


class AnisotropicHalfSpace(HalfSpace):
    """The field of a half-space of any anisotropy under a unit force.

    Parameters
    ----------
    stiffness, radius, modulus, nu
        As of any `HalfSpace`.
    """

    def __init__(self, stiffness: FloatArray, radius: float, modulus: float, nu: float) -> None:
        self.stiffness, self.radius, self.modulus, self.nu = stiffness, radius, modulus, nu

    @cached_property
    def _waves(self) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
        """Direction n, roots p and amplitudes A of Stroh's eigenvalue problem for each angle."""
        sheared = 1.0 - np.eye(3)
        C = self.stiffness * (1.0 + _APART * np.einsum("ij,kl->ijkl", sheared, sheared))
        m, waves = np.array([0.0, 0.0, 1.0]), []
        for angle in (np.arange(_ANGLES) + 0.5) * math.pi / _ANGLES:
            n = np.array([math.cos(angle), math.sin(angle), 0.0])
            Q, R, T = (np.einsum("ijkl,j,l", C, *ends) for ends in ((n, n), (n, m), (m, m)))
            lower = -np.linalg.solve(T, np.hstack([Q, R + R.T]))
            p, modes = np.linalg.eig(np.block([[np.zeros((3, 3)), np.eye(3)], [lower]]))
            down = p.imag > 0.0
            p, a = p[down], modes[:3, down]
            traction = R.T @ a + T @ a * p
            waves.append((n, p, a * np.linalg.solve(traction, -m.astype(complex))))
        return waves

    def _fields(self, y: FloatArray, *, stress: bool = False, rough: bool = False) -> ArrayPair:
        a, points = self.radius, y.reshape(-1, 3)
        depth = np.maximum(points[:, 2:], 1e-7 * a)
        u, slope = np.zeros(points.shape), np.zeros((len(points), 3, 3))
        for n, p, amplitude in self._waves[_EVERY // 2 if rough else 0 :: _EVERY if rough else 1]:
            place = (points @ n)[:, None] + p * depth
            far = np.abs(place) > _FAR * a
            z = np.where(far, _FAR * a * 1j, place)
            logarithm = np.log((z + a) / (z - a))
            series = 1.0 / place
            f = np.where(
                far,
                4.0 * a**3 / 3.0 * (series + a * a / 5.0 * series**3),
                (a * a - z * z) * logarithm + 2.0 * a * z,
            )
            u += 2.0 * np.real(f @ amplitude.T)
            if not stress:
                continue
            df = np.where(
                far,
                -4.0 * a**3 / 3.0 * (series**2 + 0.6 * a * a * series**4),
                4.0 * a - 2.0 * z * logarithm,
            )
            slope[:, :, :2] += 2.0 * np.real(df @ amplitude.T)[:, :, None] * n[:2]
            slope[:, :, 2] += 2.0 * np.real((df * p) @ amplitude.T)
        scale = 3.0 / (16.0 * math.pi**2 * a**3) * math.pi / _ANGLES * (_EVERY if rough else 1)
        of_slope = np.einsum("ijkl,nkl->nij", self.stiffness, slope)
        return scale * u.reshape(y.shape), scale * of_slope.reshape(*y.shape, 3)
