"""Displacement and stress of an elastic half-space under Hertz's pressure.

The pressure p = p₀ √(1 - r²/a²), p₀ = 3F/(2πa²), acts on a disc of radius a. Coordinates are local:
z points into the half-space z > 0, and r is the distance from the axis.

Isotropic half-space: the potentials are elementary in spheroidal coordinates about the disc (M. T.
Huber, Ann. Phys. 14, 153, 1904). They are continued analytically to z < 0, where a body with a
concave surface has material.

Anisotropic half-space: the field is a single integral over the angle of plane waves (A. N. Stroh,
Phil. Mag. 3, 625, 1958; J. R. Willis, J. Mech. Phys. Solids 14, 163, 1966), for z ≥ 0 only.
"""

from __future__ import annotations

import copy
import math
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from ..base import ROUNDING, ArrayPair, FloatArray
from ..fem import PLACES, Material, hooke
from ..mesh import AT_NODE

# Number of angles in the integral of an anisotropic half-space. The integrand is periodic and,
# except for far points just below the surface, smooth: the error is 1e-4 at r = 8 a, z = 0.4 a.
_ANGLES = 128

# Ratio of the radius a to the distance below which the pressure's transform is a series, exact to
# 1e-7: the closed form loses digits by cancellation.
_FAR = 1.0 / 30.0


class HalfSpace:
    """The field of an elastic half-space under a unit force on a disc.

    Attributes
    ----------
    radius : float
        Radius a of the disc under pressure, m.
    stiffness : ndarray, shape (3, 3, 3, 3)
        Elastic tensor C_ijkl in local axes, Pa.
    modulus, nu : float
        Contact modulus E*, Pa, and Poisson's ratio; for anisotropic materials, those of the
        equivalent isotropic half-space.
    """

    radius: float
    stiffness: FloatArray
    modulus: float
    nu: float
    axis: ClassVar[int] = 2  # index of the local axis along which the force acts

    @property
    def mean_displacement(self) -> float:
        """Mean of u_z weighted with the pressure, m/N: 0.6/(a E*) (Johnson, eq. 3.42a)."""
        return 0.6 / (self.radius * self.modulus)

    def displacement(self, y: FloatArray) -> FloatArray:
        """Return the displacement u at local points `y`, m, shape (..., 3), for a force of 1 N."""
        return self._fields(y)[0]

    def displacement_stress(self, y: FloatArray) -> ArrayPair:
        """Return displacement, m, shape (..., 3), and stress, Pa, shape (..., 3, 3), for 1 N."""
        return self._fields(y, stress=True)

    @property
    def softness(self) -> FloatArray:
        """Compliance tensor S_ijkl in ε = S:σ, local axes, 1/Pa."""
        flat = np.linalg.pinv(self.stiffness.reshape(9, 9))
        return np.asarray(flat.reshape(self.stiffness.shape))

    def of_radius(self, radius: float) -> Self:
        """Return the same half-space under a disc of another radius, m."""
        other = copy.copy(self)
        other.radius = radius
        return other

    def _fields(self, y: FloatArray, *, stress: bool = False) -> ArrayPair:
        """Return displacement, m, and stress, Pa; the stress is empty unless requested."""
        raise NotImplementedError


class IsotropicHalfSpace(HalfSpace):
    """The field of an isotropic half-space under a unit force along its normal.

    With the potential ψ = ∫ p/ρ dA of the pressure, Ψ,z = ψ and F,z = Ψ, the displacement times 4πG
    (K. L. Johnson, Contact Mechanics, section 3.1) is, for p as a pressure (left, Boussinesq) and
    for p as a traction along x (right, Cerruti; see `ShearedHalfSpace`),

        u_x = -(1 - 2ν) Ψ,x - z ψ,x      u_x = 2 ψ + 2ν F,xx - z Ψ,xx
        u_y = -(1 - 2ν) Ψ,y - z ψ,y      u_y = 2ν F,xy - z Ψ,xy
        u_z = 2 (1 - ν) ψ - z ψ,z        u_z = (1 - 2ν) Ψ,x - z ψ,x.

    Derivatives in x and y are expressed by D = (1/r) ∂/∂r. D² f follows from D f, and D³ f from
    D² f, since r² D² f + 2 D f + f,zz = 0 for harmonic f. For a = 1, the spheroidal coordinates s
    and k satisfy z = s k and r² = (1 + s²)(1 - k²); in these ψ and Ψ suffer no cancellation.

    Parameters
    ----------
    material : Material
    radius : float
        Radius a of the disc under pressure, m.
    """

    # Ratio of the distance from the axis to √(a² + z²) below which points count as at this ratio;
    # the error of the field is the square of this ratio.
    on_axis: ClassVar[float] = 1e-4

    def __init__(self, material: Material, radius: float) -> None:
        self.material, self.radius = material, radius
        self.stiffness, self.nu = material.tensor, material.nu
        self.modulus = material.plane_strain_modulus

    def _fields(self, y: FloatArray, *, stress: bool = False) -> ArrayPair:
        nu, (x1, x2, z) = self.nu, np.moveaxis(y / self.radius, -1, 0)
        r2 = np.maximum(x1 * x1 + x2 * x2, self.on_axis**2 * (1.0 + z * z))
        s, k, root = _spheroidal(r2, z)
        alpha = np.arctan2(1.0, s)
        d_psi, psi_z = 0.5 * (s / (1.0 + s * s) - alpha), z * alpha - k
        psi = 0.5 * (alpha + r2 * d_psi + z * psi_z)
        d_whole = (1.0 - k**3) / (3.0 * r2) + z * d_psi  # D Ψ
        scale = 0.75 / (math.pi * self.material.shear_modulus * self.radius)
        dd_whole = -(psi_z + 2.0 * d_whole) / r2
        psi_zz, d_psi_z = alpha - s / root, k / ((1.0 + s * s) * root)
        dd_psi = -(psi_zz + 2.0 * d_psi) / r2
        if self.axis == 2:
            across, turned = (
                (2.0 * nu - 1.0) * whole - z * of
                for whole, of in ((d_whole, d_psi), (dd_whole, dd_psi))
            )
            moved = [x1 * across, x2 * across, 2.0 * (1.0 - nu) * psi - z * psi_z]
            along, aslant = (1.0 - 2.0 * nu) * psi_z - z * psi_zz, -z * d_psi_z
            strain = [across + x1 * x1 * turned, across + x2 * x2 * turned, along]
            strain += [x1 * x2 * turned, x2 * aslant, x1 * aslant]
        else:
            cubes = 3.0 * s * s * k - k**3, s**3 - 3.0 * s * k * k
            d_f = (0.5 + 0.5 * z * z - 0.125 * r2) * (s + z * k + r2 * alpha)
            d_f += 0.25 * cubes[1] - 5.0 / 12.0 * z * cubes[0]
            d_f = (z / 3.0 - 0.5 * d_f) / r2
            dd_f = -(psi + 2.0 * d_f) / r2
            once, twice = 2.0 * nu * d_f - z * d_whole, 2.0 * nu * dd_f - z * dd_whole
            down = (1.0 - 2.0 * nu) * d_whole - z * d_psi
            moved = [2.0 * psi + once + x1 * x1 * twice, x1 * x2 * twice, x1 * down]
            thrice = z * (d_psi_z + 4.0 * dd_whole) - 2.0 * nu * (d_psi + 4.0 * dd_f)
            thrice /= r2
            both = twice + x1 * x1 * thrice
            strain = [x1 * (2.0 * (d_psi + twice) + both), x1 * (twice + x2 * x2 * thrice)]
            strain += [-x1 * (2.0 * nu * d_psi + z * d_psi_z), x2 * (d_psi + both)]
            strain += [-x1 * x2 * z * dd_psi, psi_z - z * (d_psi + x1 * x1 * dd_psi)]
        u = scale * np.stack(moved, axis=-1)
        if not stress:
            return u, np.zeros(0)
        found = hooke(scale / self.radius * np.stack(strain), self.material)
        return u, np.moveaxis(found, 0, -1)[..., PLACES]


class ShearedHalfSpace(IsotropicHalfSpace):
    """The field of an isotropic half-space under a unit force along its surface, in direction x.

    The traction q = q₀ √(1 - r²/a²), q₀ = 3F/(2πa²), acts on a disc of radius a. For parameters and
    formulas see `IsotropicHalfSpace`.
    """

    axis = 0
    on_axis = 2e-3  # larger than for a normal force: rounding errors of D³ f grow as 1/r⁶

    @property
    def mean_displacement(self) -> float:
        """Mean of u_x weighted with the traction, m/N: 0.6 (2 - ν)/(4 G a)."""
        return 0.6 * (2.0 - self.nu) / (4.0 * self.material.shear_modulus * self.radius)


def _spheroidal(r2: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return spheroidal coordinates s, k about a disc of radius 1, and s² + k², from r² and z."""
    q = r2 + z * z - 1.0
    root = np.maximum(np.sqrt(q * q + 4.0 * z * z), ROUNDING)  # 0 on the rim of the disc
    # s² and -k² are the roots of u² - q u - z²; the larger of s² and k² is computed without
    # cancellation.
    within = q < 0.0
    large = np.sqrt(np.maximum(0.5 * np.where(within, root - q, root + q), ROUNDING**2))
    small = np.abs(z) / large
    sign, through_disc = np.where(z < 0.0, -1.0, 1.0), r2 < 1.0
    s = np.where(within, small, large) * np.where(through_disc, sign, 1.0)
    k = np.where(within, large, small) * np.where(through_disc, 1.0, sign)
    return s, k, root


class AnisotropicHalfSpace(HalfSpace):
    """The field of a half-space of any anisotropy under a unit force.

    Parameters
    ----------
    stiffness, radius, modulus, nu
        Attributes of `HalfSpace`.
    """

    def __init__(self, stiffness: FloatArray, radius: float, modulus: float, nu: float) -> None:
        self.stiffness, self.radius, self.modulus, self.nu = stiffness, radius, modulus, nu

    @cached_property
    def _waves(self) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
        """Return directions n, roots p and amplitudes A of Stroh's eigenproblem for each angle."""
        # Equal roots, as isotropic materials have, lack independent eigenvectors. A relative change
        # of the shear moduli separates them, and leaves half of the digits.
        sheared, apart = 1.0 - np.eye(3), math.sqrt(np.finfo(float).eps)
        C = self.stiffness * (1.0 + apart * np.einsum("ij,kl->ijkl", sheared, sheared))
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

    def _fields(self, y: FloatArray, *, stress: bool = False) -> ArrayPair:
        a, points = self.radius, y.reshape(-1, 3)
        depth = np.maximum(points[:, 2:], AT_NODE * a)
        u, slope = np.zeros(points.shape), np.zeros((len(points), 3, 3))
        for n, p, amplitude in self._waves:
            z = (points @ n)[:, None] + p * depth
            w = a / z
            far, logarithm = np.abs(w) < _FAR, 2.0 * np.arctanh(w)
            near = (1.0 - 1.0 / w**2) * logarithm + 2.0 / w
            f = a * a * np.where(far, w * (4.0 + 0.8 * w * w) / 3.0, near)
            u += 2.0 * np.real(f @ amplitude.T)
            if not stress:
                continue
            df = a * np.where(far, -w * w * (4.0 + 2.4 * w * w) / 3.0, 4.0 - 2.0 * logarithm / w)
            slope[:, :, :2] += 2.0 * np.real(df @ amplitude.T)[:, :, None] * n[:2]
            slope[:, :, 2] += 2.0 * np.real((df * p) @ amplitude.T)
        scale = 3.0 / (16.0 * math.pi**2 * a**3) * math.pi / _ANGLES
        of_slope = np.einsum("ijkl,nkl->nij", self.stiffness, slope)
        return scale * u.reshape(y.shape), scale * of_slope.reshape(*y.shape, 3)
