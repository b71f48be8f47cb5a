"""Layers of a shell: a single layer, or the plies of a laminate.

In-plane strains are linear through the thickness, ε + z κ, and each ply is in plane stress
(classical laminate theory: R. M. Jones, Mechanics of composite materials, 1999). First-order shear
deformation has the energy of transverse shear stresses in equilibrium with the in-plane stresses
of cylindrical bending about both axes (R. Rolfes and K. Rohwer, Int. J. Num. Meth. Eng. 40, 51,
1997). For a single isotropic layer this gives Reissner's factor 5/6.
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

# Indices in the order xx, yy, zz, xy, yz, xz. `_PLANE`: of xx, yy, xy. `_SHEAR`: of xz, yz.
_PLANE, _SHEAR = [0, 1, 3], [5, 4]

# Accepted range of thicknesses, m, in which no stiffness overflows.
_thickness = partial(within, low=1e-9, high=1e3)

# Largest plausible ratio of an offset to the thickness, and of a rigid mass's distance or radius of
# gyration to the body's size; lengths in millimetres give about a thousand.
FAR_OFF = 100.0

# Gauss points and weights for a ply, exact for the energy of shear stresses quadratic in z.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class Ply:
    """One layer of a laminate.

    Parameters
    ----------
    thickness : float
        Thickness, m.
    material : Material or Orthotropic
        For an `Orthotropic`, axis 1 lies along the fibres, axis 2 across the fibres in the ply, and
        axis 3 normal to the ply. Its `axes` must be the default.
    angle_deg : float, optional
        Angle from the laminate's fibre axis to the ply's axis 1, right-handed about the normal,
        degrees.

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
                f"a ply's material must have default axes, got {self.material.axes}; give angle_deg"
            )

    @cached_property
    def compliance(self) -> FloatArray:
        """Compliance in the laminate's axes, 1/Pa, shape (6, 6), order xx, yy, zz, xy, yz, xz.

        :meta private:
        """
        material = self.material
        if isinstance(material, Orthotropic):
            material = material.turned(math.radians(self.angle_deg))
        return np.asarray(np.linalg.inv(material.stiffness), dtype=np.float64)


class Layers:
    """Stiffness, inertia and stresses of a stack of plies, with z = 0 on the surface of the nodes.

    Generalised strains are εxx, εyy, γxy at z = 0, the curvatures κxx, κyy, κxy (of u = z θ×n), and
    the transverse shears γxz, γyz. Their work conjugates are the membrane forces N, the moments M
    and the shear forces Q, each per length.
    """

    plies: tuple[Ply, ...]
    offset: float

    def _check_offset(self) -> None:
        most = FAR_OFF * self.total_thickness
        checked(self, offset=partial(within, low=-most, high=most))

    @property
    def reference(self) -> FloatArray | None:
        """Direction whose projection is the local x axis; None if all plies are isotropic.

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
        """True if exchanging top and bottom changes the shell.

        :meta private:
        """
        plies = [(ply.thickness, ply.material, ply.angle_deg % 180.0) for ply in self.plies]
        over = [(*of_ply, -angle % 180.0) for *of_ply, angle in plies[::-1]]
        return self.offset != 0.0 or over != plies

    @property
    def narrowest(self) -> float:
        """Total thickness, m.

        :meta private:
        """
        return self.total_thickness

    @property
    def reach(self) -> float:
        """Largest distance of a face from the nodes, m.

        :meta private:
        """
        return float(np.abs(self.interfaces[[0, -1]]).max())

    def seen_from(self, *, top: bool) -> Layers:
        """Return the layers, turned over unless `top`, so that a contact is on their top.

        :meta private:
        """
        if top or not self.sided:
            return self
        plies = [replace(ply, angle_deg=-ply.angle_deg) for ply in self.plies[::-1]]
        return Laminate(plies, self.reference, -self.offset)

    def half_space(self, normal: Any) -> Material:
        """Return the isotropic half-space equivalent to the top ply; `normal` is not used.

        :meta private:
        """
        return self.plies[-1].material.half_space((0.0, 0.0, 1.0))

    @cached_property
    def interfaces(self) -> FloatArray:
        """z of the bottom, the interfaces and the top, m, shape (n_plies + 1,)."""
        upto = np.cumsum([0.0, *(ply.thickness for ply in self.plies)])
        return upto - 0.5 * self.total_thickness + self.offset

    @cached_property
    def stiffness(self) -> FloatArray:
        """Matrix from generalised strains to N, M and Q, shape (8, 8).

        It consists of A, B and D, in N/m, N and N m, and of the transverse shear stiffness, N/m.
        """
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
        """∫ρ dz, ∫ρ z dz and ∫ρ z² dz, in kg/m², kg/m and kg."""
        moments = np.zeros(3)
        for number, z, weight in self._points:
            moments += weight * self.plies[number].material.rho * z ** np.arange(3)
        return moments

    @property
    def _points(self) -> list[tuple[int, float, float]]:
        """Quadrature points through the thickness: ply index, z and weight, both m."""
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
        """Matrix [[A, B], [B, D]] of classical laminate theory, shape (6, 6)."""
        z = self.interfaces
        a, b, d = (
            np.einsum("p,pij->ij", (z[1:] ** n - z[:-1] ** n) / n, self._moduli) for n in (1, 2, 3)
        )
        return np.block([[a, b], [b, d]])

    @cached_property
    def _slopes(self) -> FloatArray:
        """∂(ε, κ)/∂x due to Qx = Mxx,x = 1, and ∂(ε, κ)/∂y due to Qy = Myy,y = 1; shape (2, 6)."""
        return np.asarray(np.linalg.inv(self._plane)[:, 3:5].T, dtype=np.float64)

    @cached_property
    def _below(self) -> FloatArray:
        """τxz, τyz at each ply's bottom due to unit Qx and Qy, 1/m, shape (n_plies, 2, 2)."""
        steps = [
            self._change(number, low, high)
            for number, (low, high) in enumerate(pairwise(self.interfaces.tolist()))
        ]
        return np.cumsum([np.zeros((2, 2)), *steps[:-1]], axis=0)

    def _change(self, number: int, low: float, high: float) -> FloatArray:
        """Return the increase of τxz, τyz from z = low to high in a ply, due to unit Qx and Qy.

        τxz = -∫ (σxx,x + τxy,y) dz and τyz = -∫ (τxy,x + σyy,y) dz by equilibrium; shape (2, 2),
        1/m.
        """
        first, second = high - low, 0.5 * (high**2 - low**2)
        sums = self._slopes[:, :3] * first + self._slopes[:, 3:] * second
        along_x, along_y = sums @ self._moduli[number]  # ∂σ/∂x, ∂σ/∂y
        return -np.array([[along_x[0], along_y[2]], [along_x[2], along_y[1]]])

    def _shear_stress(self, number: int, z: float) -> FloatArray:
        """Return τxz and τyz at z in a ply due to unit Qx and Qy, 1/m, shape (2, 2)."""
        return np.asarray(self._below[number] + self._change(number, self.interfaces[number], z))

    def stress_at(self, strains: FloatArray, number: int, z: float) -> FloatArray:
        """Return the stress at z in a ply, in the element's axes, Pa, shape (..., 6).

        Components xx, yy, zz, xy, yz, xz; tension is positive, and zz is zero. The shear stresses
        xz and yz are in equilibrium with the in-plane stresses: piecewise parabolas of z that
        vanish on both faces.

        Parameters
        ----------
        strains : ndarray, shape (..., 8)
            Generalised strains.
        number : int
            Index of the ply.
        z : float
            Height above the surface of the nodes, m.

        :meta private:
        """
        forces = strains[..., 6:] @ self.stiffness[6:, 6:]
        found = np.zeros((*strains.shape[:-1], 6))
        found[..., _PLANE] = (strains[..., :3] + z * strains[..., 3:6]) @ self._moduli[number]
        found[..., _SHEAR] = forces @ self._shear_stress(number, z).T
        return found

    def height(self, side: str, ply: int | None = None) -> float:
        """Return z of the bottom, middle or top of the ply with index `ply`, or of the stack, m.

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
        Thickness, m.
    material : Material or Orthotropic
        For an `Orthotropic`, the projection of axis 1 onto an element is the element's x axis, and
        axis 3 is assumed normal to the element.
    offset : float, optional
        Distance from the nodes to the middle surface along the elements' normals, m: +thickness/2
        if the nodes are on the lower face. The area at the nodes is used even if the surface is
        curved; a warning follows if this changes the mass by more than 1 %.

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
        """The single layer as a ply."""
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
        Direction of angle 0 of the plies; its projection onto an element is the element's x axis.
        Required if a ply is orthotropic.
    offset : float, optional
        Distance from the nodes to the middle surface along the elements' normals, m. The area at
        the nodes is used even if the surface is curved; a warning follows if this changes the mass
        by more than 1 %.

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

    plies: Sequence[Ply]  # type: ignore[assignment]  # stored as a tuple
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
    """Return a direction, any nonzero vector, as a tuple, or None for None."""
    if value is None:
        return None
    axis = finite_array(name, value, shape=(3,))
    if not axis.any():
        raise InputError(f"{name} must not be zero")
    return tuple(axis.tolist())
