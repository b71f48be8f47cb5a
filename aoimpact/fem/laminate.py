"""Layers of a shell: one of an isotropic material, or the plies of a laminate.

Through the thickness the strains are linear, ε + z κ, and each ply is in plane stress (classical
laminate theory: R. M. Jones, Mechanics of composite materials, 1999). The transverse shear is that
of first order, with the energy of the shear stresses that are in equilibrium with the in-plane
ones in cylindrical bending about both axes (R. Rolfes and K. Rohwer, Int. J. Num. Meth. Eng. 40,
51, 1997). Of a single isotropic layer this is Reissner's factor 5/6.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, checked, finite_array, instances, real, within
from .material import Material, Orthotropic, Solid

_AXES = Orthotropic.axes

# Components of plane stress, and (xz, yz), in the order xx, yy, zz, xy, yz, xz.
_PLANE, _SHEAR = [0, 1, 3], [5, 4]

# Thicknesses, m, of which stiffness is computed.
_thickness = partial(within, low=1e-9, high=1e3)

# Offset over the thickness from which on it is in another unit: millimetres make it a thousand.
FAR_OFF = 100.0

# Gauss' points in a ply: the energy of shear stresses that are quadratic in z is of degree 4.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class Ply:
    """One layer of a laminate.

    Parameters
    ----------
    thickness : float
        m.
    material : Material or Orthotropic
        Axis 1 of an `Orthotropic` is along the fibres, axis 2 across them in the ply, and axis 3
        normal to it; its `axes` are left at their default.
    angle_deg : float, optional
        From the laminate's fibre axis to the ply's axis 1, right-handed about the normal, degrees.

    Examples
    --------
    >>> from aoimpact.fem import Orthotropic
    >>> carbon = Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
    >>> Ply(0.125e-3, carbon, angle_deg=45).angle_deg
    45.0
    """

    thickness: float
    material: Solid
    angle_deg: float = 0.0

    def __post_init__(self) -> None:
        checked(self, thickness=_thickness, material=(Material, Orthotropic), angle_deg=real)
        if isinstance(self.material, Orthotropic) and self.material.axes != _AXES:
            raise InputError(
                f"material of a ply has the axes {self.material.axes}; turn it by angle_deg instead"
            )

    @cached_property
    def compliance(self) -> FloatArray:
        """Strains of stresses in the laminate's axes, 1/Pa, shape (6, 6): xx, yy, zz, xy, yz, xz.

        :meta private:
        """
        material = self.material
        if isinstance(material, Orthotropic):
            material = material.turned(math.radians(self.angle_deg))
        return np.asarray(np.linalg.inv(material.stiffness), dtype=np.float64)


class Layers:
    """Stiffness, inertia and stresses of a stack of plies; z counts from the nodes' surface.

    Generalised strains are εxx, εyy, γxy of the nodes' surface, the curvatures κxx, κyy, κxy (of
    u = z θ×n), and the transverse shears γxz, γyz. They work on the forces N and moments M per
    length and on the shear forces Q.
    """

    plies: tuple[Ply, ...]
    offset: float

    def _check_offset(self) -> None:
        most = FAR_OFF * self.total_thickness
        checked(self, offset=partial(within, low=-most, high=most))

    @property
    def reference(self) -> FloatArray | None:
        """The direction whose projection is the local x axis; None if any is as good.

        :meta private:
        """
        raise NotImplementedError

    @cached_property
    def total_thickness(self) -> float:
        """Sum of the plies' thicknesses, m."""
        return math.fsum(ply.thickness for ply in self.plies)

    @property
    def rho(self) -> float:
        """Mean density, kg/m³."""
        return float(self.inertia[0]) / self.total_thickness

    @property
    def sided(self) -> bool:
        """True if it matters which side of the surface is the top.

        :meta private:
        """
        plies = [(ply.thickness, ply.material, ply.angle_deg % 180.0) for ply in self.plies]
        over = [(*of_ply, -angle % 180.0) for *of_ply, angle in plies[::-1]]
        return self.offset != 0.0 or over != plies

    @property
    def narrowest(self) -> float:
        """The whole thickness, m.

        :meta private:
        """
        return self.total_thickness

    @property
    def reach(self) -> float:
        """How far the faces are from the nodes, m.

        :meta private:
        """
        return float(np.abs(self.interfaces[[0, -1]]).max())

    def seen_from(self, *, top: bool) -> Layers:
        """Return the layers as a contact on the top, or on the bottom, finds them below it.

        :meta private:
        """
        if top or not self.sided:
            return self
        plies = [replace(ply, angle_deg=-ply.angle_deg) for ply in self.plies[::-1]]
        return Laminate(plies, self.reference, -self.offset)

    def half_space(self, normal: Any) -> Material:
        """Return the isotropic material that a contact on the top meets, whatever its normal.

        :meta private:
        """
        return self.plies[-1].material.half_space((0.0, 0.0, 1.0))

    @cached_property
    def interfaces(self) -> FloatArray:
        """z of the bottom, of each interface, and of the top, m, shape (n_plies + 1,)."""
        upto = np.cumsum([0.0, *(ply.thickness for ply in self.plies)])
        return upto - 0.5 * self.total_thickness + self.offset

    @cached_property
    def stiffness(self) -> FloatArray:
        """N, M, Q of the generalised strains, shape (8, 8): A, B, D in N/m, N, N m; then N/m."""
        matrix = np.zeros((8, 8))
        matrix[:6, :6] = self._plane
        flexibility = np.zeros((2, 2))
        for number, z, weight in self._points:
            by_force = self._shear_stress(number, z)
            shear = self.plies[number].compliance[np.ix_(_SHEAR, _SHEAR)]
            flexibility += weight * by_force.T @ shear @ by_force
        matrix[6:, 6:] = np.linalg.inv(flexibility)
        return 0.5 * (matrix + matrix.T)

    @cached_property
    def inertia(self) -> FloatArray:
        """∫ρ dz, ∫ρ z dz and ∫ρ z² dz: kg/m², kg/m, kg."""
        moments = np.zeros(3)
        for number, z, weight in self._points:
            moments += weight * self.plies[number].material.rho * z ** np.arange(3)
        return moments

    @property
    def _points(self) -> list[tuple[int, float, float]]:
        """Points of quadrature: number of the ply, z and weight, m."""
        return [
            (number, 0.5 * (low + high + x * (high - low)), 0.5 * w * (high - low))
            for number, (low, high) in enumerate(pairwise(self.interfaces.tolist()))
            for x, w in zip(_POINTS, _WEIGHTS, strict=True)
        ]

    @cached_property
    def _moduli(self) -> FloatArray:
        """Stiffness of each ply in plane stress, Pa, shape (n_plies, 3, 3)."""
        return np.array(
            [np.linalg.inv(ply.compliance[np.ix_(_PLANE, _PLANE)]) for ply in self.plies]
        )

    @cached_property
    def _plane(self) -> FloatArray:
        """The classical laminate's A, B, B, D, shape (6, 6)."""
        z = self.interfaces
        a, b, d = (
            np.einsum("p,pij->ij", (z[1:] ** n - z[:-1] ** n) / n, self._moduli) for n in (1, 2, 3)
        )
        return np.block([[a, b], [b, d]])

    @cached_property
    def _slopes(self) -> FloatArray:
        """ε and κ along x by Mxx,x = Qx, and along y by Myy,y = Qy; shape (2, 6), per newton/m."""
        return np.asarray(np.linalg.inv(self._plane)[:, 3:5].T, dtype=np.float64)

    @cached_property
    def _below(self) -> FloatArray:
        """-∫ over the plies below each, of what `_shear_stress` integrates, shape (n, 2, 2)."""
        steps = [
            self._change(number, low, high)
            for number, (low, high) in enumerate(pairwise(self.interfaces.tolist()))
        ]
        return np.cumsum([np.zeros((2, 2)), *steps[:-1]], axis=0)

    def _change(self, number: int, low: float, high: float) -> FloatArray:
        """-∫ of σxx,x + τxy,y and τxy,x + σyy,y within a ply, by (Qx, Qy)."""
        first, second = high - low, 0.5 * (high**2 - low**2)
        sums = self._slopes[:, :3] * first + self._slopes[:, 3:] * second
        along_x, along_y = sums @ self._moduli[number]  # of xx, yy, xy
        return -np.array([[along_x[0], along_y[2]], [along_x[2], along_y[1]]])

    def _shear_stress(self, number: int, z: float) -> FloatArray:
        """τxz and τyz at z in a ply by the shear forces, 1/m, shape (2, 2)."""
        return np.asarray(self._below[number] + self._change(number, self.interfaces[number], z))

    def stress_at(self, strains: FloatArray, number: int, z: float) -> FloatArray:
        """Return the stress at a height in a ply, in the element's axes, Pa, shape (..., 6).

        xx, yy, zz, xy, yz, xz; tension is positive, and zz is zero. The shear stresses xz and yz
        are those in equilibrium with the others: parabolas of z that vanish on both faces.

        Parameters
        ----------
        strains : ndarray, shape (..., 8)
            Generalised strains.
        number : int
            Number of the ply.
        z : float
            m.

        :meta private:
        """
        forces = strains[..., 6:] @ self.stiffness[6:, 6:]
        found = np.zeros((*strains.shape[:-1], 6))
        found[..., _PLANE] = (strains[..., :3] + z * strains[..., 3:6]) @ self._moduli[number]
        found[..., _SHEAR] = forces @ self._shear_stress(number, z).T
        return found

    def height(self, side: str, ply: int | None = None) -> float:
        """Return z of the bottom, middle or top of a ply by its number, or of all of them, m.

        :meta private:
        """
        low, high = self.interfaces[[0, -1] if ply is None else [ply, ply + 1]].tolist()
        return float({"bottom": low, "middle": 0.5 * (low + high), "top": high}[side])


@dataclass(frozen=True)
class Shell(Layers):
    """A shell of one layer.

    Parameters
    ----------
    thickness : float
        m.
    material : Material or Orthotropic
        Axis 1 of an `Orthotropic`, projected on each element, is the element's x axis; axis 3 is
        taken as the normal.
    offset : float, optional
        Distance of the middle surface from the nodes along the elements' normals, m: +thickness/2
        where the nodes are on the lower face. Area is that of the nodes' surface also where it is
        curved, which warns above 1 % of mass.

    Examples
    --------
    >>> from aoimpact.fem import Material
    >>> sheet = Shell(thickness=1e-3, material=Material(E=210e9, nu=0.3, rho=7800))
    >>> round(float(sheet.stiffness[3, 3]), 3)  # D = E t³/(12 (1 - ν²)), N m
    19.231
    """

    thickness: float
    material: Solid
    offset: float = 0.0

    def __post_init__(self) -> None:
        checked(self, thickness=_thickness, material=(Material, Orthotropic))
        self._check_offset()

    @cached_property
    def plies(self) -> tuple[Ply, ...]:  # type: ignore[override]
        """The single layer."""
        material = self.material
        if isinstance(material, Orthotropic):
            material = replace(material, axes=_AXES)
        return (Ply(self.thickness, material),)

    @property
    def reference(self) -> FloatArray | None:
        """Axis 1 of an orthotropic material.

        :meta private:
        """
        return np.array(self.material.axes[0]) if isinstance(self.material, Orthotropic) else None


@dataclass(frozen=True)
class Laminate(Layers):
    """A shell of several plies.

    Parameters
    ----------
    plies : sequence of Ply
        From the bottom to the top, along the elements' normals.
    fibre_axis : array_like, shape (3,), optional
        The direction from which the plies' angles count; its projection on each element is the
        element's x axis. Needed if a ply is orthotropic.
    offset : float, optional
        Distance of the middle surface from the nodes along the elements' normals, m. Area is that
        of the nodes' surface also where it is curved, which warns above 1 % of mass.

    Examples
    --------
    A cross-ply of 1 mm:

    >>> from aoimpact.fem import Orthotropic
    >>> carbon = Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
    >>> stack = [Ply(0.25e-3, carbon, angle) for angle in (0, 90, 90, 0)]
    >>> laminate = Laminate(stack, fibre_axis=(1, 0, 0))
    >>> laminate.total_thickness, round(float(laminate.inertia[0]), 3)  # m, kg/m²
    (0.001, 1.55)
    """

    plies: Sequence[Ply]  # type: ignore[assignment]  # a tuple, once it is there
    fibre_axis: Any = None
    offset: float = 0.0

    def __post_init__(self) -> None:
        checked(self, plies=partial(instances, kind=Ply), fibre_axis=direction_or_none)
        if not self.plies:
            raise InputError("plies must have at least one Ply, got none")
        fibrous = any(isinstance(ply.material, Orthotropic) for ply in self.plies)
        if self.fibre_axis is None and fibrous:
            raise InputError("fibre_axis: orthotropic plies need the direction of 0 degrees")
        self._check_offset()

    @property
    def reference(self) -> FloatArray | None:
        """The fibre axis.

        :meta private:
        """
        return None if self.fibre_axis is None else np.array(self.fibre_axis)


def direction_or_none(name: str, value: Any) -> tuple[float, ...] | None:
    """Return a direction, of any length but zero, as a tuple; None as it is."""
    if value is None:
        return None
    axis = finite_array(name, value, shape=(3,))
    if not axis.any():
        raise InputError(f"{name} must not be zero")
    return tuple(axis.tolist())
