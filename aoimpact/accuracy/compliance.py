"""Errors of a contact point's compliance: by the mesh, and by the half-space of the contact law.

The compliance of a body at its contact point is G = bᵀx with x = (K + s²M)⁻¹ b, s = 10/T for a
contact of duration T. It has two errors.

*Mesh.* Elements are too stiff: G is too small by the energy of the error of x, which is estimated
by the jumps of its stress between elements (`energy_error`).

*Contact.* The law contains the deflection of a half-space under the contact, and the half-space's
deflection under the patch is subtracted from it, c = 0.6/(r E*). The rest of the body's compliance,
R(r) = G - c, should not depend on the radius r of the patch. Where the body about the patch is no
half-space it does: then R(r) - R(a), with a the radius of the contact itself, is an error. It
follows from x. The difference of the body's displacement from the half-space's is smooth, w(ρ) = g₀
+ g₁ (ρ² + ⟨ρ²⟩) around the point, with the mean ⟨ρ²⟩ = 0.4 r² under the pressure and, by
reciprocity, with the same g₁ for both. So R(r) = g₀ + 0.8 g₁ r². On circles about the patch w
hardly depends on how well the mesh resolves the patch. (A second solution, with another radius, is
no better: its difference is mostly the mesh's error. Measured on plates, balls and blocks.)

A rough x is enough: on plates, blocks and a bar it changes G by 5e-8 and the estimates by .2 %.

The indentation by a point load at a node, or a point, grows without bound as the mesh is refined,
and the law contains all of the real one. On circles some elements away w is known for such points,
too, and with it g₀ and g₁.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, InputTypeError, nonnegative, positive
from ..fem import ContactPoint, contact_at, edge_length, image_field, room
from ..fields import energy_error, missing_energy
from ..linalg import LinearSolver
from ..reduction import SHIFT_TIMES_DURATION, ReducedModel, unbalanced

__all__ = ["ComplianceError", "best_radius", "compliance_error"]


# Median ratio of the mesh's error to its estimate by stress jumps, for linear and quadratic
# elements; and safety factors on the estimates. Measured on 39 patches on plates, beams and
# cylinders, free and constrained, at two frequencies, against meshes ten times finer at the
# contact: the true error is .4 to 1.35 times the scaled estimate, quadratic .6 to 1.65 (5 and
# 95 %). The sums of both errors of 40 other patches are 1.1 to 12 times the true one, 1.7 in the
# median.
_TYPICAL = {False: 0.75, True: 1.3}
_SAFETY_MESH, _SAFETY_CONTACT = 1.6, 1.5

# Circles on which the body is compared with a half-space, in radii of the patch, and factors on
# their radii where the surface has no room. Larger circles miss terms of r⁴ near edges, smaller
# ones have a larger error by the mesh.
_CIRCLES = np.array([0.85, 1.0, 1.25])
_CIRCLES_WITHIN = (1.0, 0.8, 0.6)

# Within this many radii the mesh's error is attributed to the patch. On the circles it changes the
# slope of R by this multiple of its estimate by stress jumps, over r².
_NEAR, _DISTURBS = 2.0, 1.2

# Distance from a point, in edges of elements, beyond which the mesh resolves the field of its load.
_AWAY_FROM_POINT = 1.5

# Radius of a contact of unknown radius, as a share of its patch's.
_CONTACT_WITHIN_PATCH = 0.5

# A reduced model's own field is used if at most this share of b remains unbalanced. Measured on
# plates, a beam, a block and a ball, with one to 16 oscillators fitted to the contact and to twice
# its time: below it the mesh's error is that of the solution to 2.6 %, and the contact's to 10 % of
# both; at .026 to .15 they are off by 5 to 120 %.
_BALANCED = 0.02

# Least ratio of a patch's radius to the contact's. The law less the patch's part has the compliance
# 0.5/(a E*) - 0.6/(r E*), which is 0 at r = 1.2 a: the law is correct above, but near that ratio
# its force hardly determines the depth.
_LEAST_OVER_CONTACT = 1.4

# Largest radius of a patch as a share of the free radius of the surface, whose edge is detected on
# a ring of quadrature points; and the same where circles about the patch must fit as well.
_WITHIN, _ROOMY = 0.95, 0.75

# Powers of 1/r with which the mesh's error near a patch decreases, for linear and quadratic
# elements.
_FALLS = {False: 3.0, True: 4.0}

# The search for the best radius begins at _START edges of elements, but at no more than _DEPTH of
# the body's thickness, beyond which R is no longer quadratic in r. It covers radii up to _MOST
# times that, and ends when two radii agree to _ALIKE: near its minimum the sum A/r⁴ + B r² is 1 + 4
# ln² times the least, 9 % more at that ratio. At .75 of the thickness a force is .3 to .7 % off.
_START = {False: 2.5, True: 1.4}
_DEPTH, _MOST, _RADII, _TRIES, _ALIKE = 0.5, 2.0, 40, 3, 0.15


@dataclass(frozen=True)
class ComplianceError:
    """Estimated errors of the compliance of a contact point, m/N.

    Attributes
    ----------
    mesh : float
        By which the finite elements make the body too stiff at the contact; not negative.
    contact : float
        By which the law and the body together are too soft because the body about the patch is no
        half-space, or a node takes the place of a patch; negative where they are too stiff.
    compliance : float
        bᵀx = bᵀ(K + s²M)⁻¹b of the contact point, to which these belong.
    strain : float
        xᵀKx, by which it would be more with springs softer by a unit share.
    """

    mesh: float
    contact: float
    compliance: float
    strain: float

    @property
    def total(self) -> float:
        """The sum of both sizes, m/N."""
        return self.mesh + abs(self.contact)


def compliance_error(
    tip: Any,
    *,
    contact_time: float,
    contact_radius: float | None = None,
    invert: Callable[[float], LinearSolver] | None = None,
    displacement: FloatArray | None = None,
    port: int = 0,
) -> ComplianceError | None:
    """Return the errors of a contact point's compliance; None where they are not known.

    It is known of bodies made from a mesh, at places where the surface has a normal and goes on for
    three quarters of the patch's radius; not of a model without oscillators, which leaves out all.

    Parameters
    ----------
    tip : ContactPoint, AOModel or InterfaceModel
        Of a model its own deflection is taken, without a linear solution, if that leaves little
        unbalanced; at the shift that it was fitted to, if it is better there.
    contact_time : float
        T, s.
    contact_radius : float, optional
        a, of the contact itself, m; half the patch's if left out.
    invert : callable, optional
        s² ↦ the solver of K + s²M; `FEModel.inverse` if left out. Called only where there is no
        displacement.
    displacement : ndarray, shape (n_dofs,), optional
        (K + s²M)⁻¹ b with s = 10/T, if it is known.
    port : int, optional
        Which contact point of an InterfaceModel.

    Raises
    ------
    InputError, InputTypeError
        If a number is out of range, or `tip` is none of these.
    """
    s = SHIFT_TIMES_DURATION / positive("contact_time", contact_time, unit="s")
    if contact_radius is not None:
        contact_radius = nonnegative("contact_radius", contact_radius, unit="m")
    model = None if isinstance(tip, ContactPoint) else tip
    if model is not None:
        if not isinstance(model, ReducedModel):
            raise InputTypeError(
                f"tip must be a contact point or a model made from one, got {tip!r}"
            )
        if not model.contact_points or model.n == 0:
            return None
        tip = model.contact_points[port]
    if tip.body.mesh is None or tip.point is None:
        return None
    if displacement is None and model is not None:
        displacement = _own_deflection(model, s, port)
    if displacement is None:
        displacement = (invert or tip.body.inverse)(s**2).solve_roughly(tip.b)[0]
    return _error_of(tip, displacement, contact_radius)


def _own_deflection(model: ReducedModel, s: float, port: int) -> FloatArray | None:
    """(K + s²M)⁻¹ b of a model, or at the shift that it was fitted to; None if both are poor."""
    fitted = SHIFT_TIMES_DURATION / model.contact_time if model.contact_time else s
    for shift in (s, fitted):
        if unbalanced(model, shift, port) <= _BALANCED:
            return model.deflection(shift, port)
    return None


@dataclass(frozen=True)
class _Found:
    """Estimates from one field x: errors by the mesh, and R as a function of the radius.

    Attributes
    ----------
    radius : float
        Of the patch, m; of a point, the least radius at which its field is evaluated.
    compliance : float
        bᵀx, m/N.
    near, far : float
        The mesh's error by elements near the patch, and by the others, m/N.
    level, slope : float
        R(a) = level + slope a², m/N and 1/(m N).
    """

    radius: float
    compliance: float
    near: float
    far: float
    level: float
    slope: float

    def total(self, radii: FloatArray, contact: float, falls: float) -> FloatArray:
        """Estimate the sum of both errors for patches of other radii, m/N."""
        mesh = self.far + self.near * (self.radius / radii) ** falls
        wide = np.abs(self.slope * (radii**2 - contact**2))
        return _SAFETY_MESH * mesh + _SAFETY_CONTACT * wide


def _found(tip: ContactPoint, x: FloatArray) -> _Found | None:
    """Estimates by x = (K + s²M)⁻¹ b; None on a sharp edge and where a patch has no room."""
    surface, patch, compliance = tip.body.surface, tip.patch, float(tip.b @ x)
    assert surface is not None
    assert tip.point is not None
    try:
        if patch is None:
            radius = _AWAY_FROM_POINT * edge_length(surface, tip.point)
            level, slope = _image(tip, x, radius, 0.0)
            return _Found(radius, compliance, *_energies(tip, x, radius)[:2], level, slope)
        level, slope = _image(tip, x, patch.radius, 0.4 * patch.radius**2)
    except InputError:
        return None
    near, far, shown = _energies(tip, x, patch.radius)
    slope -= _DISTURBS * shown / patch.radius**2
    return _Found(patch.radius, compliance, near, far, level, slope)


def _image(tip: ContactPoint, x: FloatArray, radius: float, second: float) -> tuple[float, float]:
    """Level and slope of R by circles about a patch with that mean of ρ²."""
    for within in _CIRCLES_WITHIN:
        rho, field = image_field(tip, x, within * radius * _CIRCLES)
        if len(rho) == len(_CIRCLES):
            g1, g0 = np.polyfit(rho**2 + second, field, 1)
            return float(g0), 0.8 * float(g1) / within**2  # smaller circles are less certain
    raise InputError(f"{tip!r}: the surface about it has no room for circles")


def _energies(tip: ContactPoint, x: FloatArray, radius: float) -> tuple[float, float, float]:
    """The energy that x lacks near a patch and elsewhere, and the stress jumps' near it, J."""
    mesh = tip.body.mesh
    assert mesh is not None
    assert tip.point is not None
    forces = np.zeros(3 * mesh.n_nodes)
    forces[tip.body.free] = tip.b
    difference, own = energy_error(tip.body, x, np.any(forces.reshape(-1, 3), axis=1))
    distance = np.linalg.norm(mesh.nodes - tip.point, axis=1)
    around = distance[mesh.cells].min(axis=1) < _NEAR * radius
    typical = _TYPICAL[mesh.quadratic]
    near, far = (typical * missing_energy(difference[of], own[of]) for of in (around, ~around))
    return near, far, float(difference[around].sum())


def _error_of(
    tip: ContactPoint, x: FloatArray, contact_radius: float | None
) -> ComplianceError | None:
    found = _found(tip, x)
    if found is None:
        return None
    strain = float(x @ (tip.body.K @ x))
    if tip.patch is None:  # the error near a point belongs to its own indentation
        contact = contact_radius or 0.0
        local = found.compliance - found.level - found.slope * contact**2
        return ComplianceError(_SAFETY_MESH * found.far, local, found.compliance, strain)
    contact = _CONTACT_WITHIN_PATCH * found.radius if contact_radius is None else contact_radius
    wide = found.slope * (found.radius**2 - contact**2)
    mesh = _SAFETY_MESH * (found.near + found.far)
    return ComplianceError(mesh, _SAFETY_CONTACT * wide, found.compliance, strain)


def best_radius(
    tip: ContactPoint,
    *,
    contact_time: float,
    contact_radius: float,
    invert: Callable[[float], LinearSolver] | None = None,
) -> float:
    """Return the radius of the patch at a place for which both errors together are least, m.

    One solution, with a patch that the mesh resolves, gives a rough estimate for other radii. The
    best of these is solved for next, at most three in all, and the best of these is returned. Where
    the surface has no room for a radius for which the law holds, it is the largest that fits.

    Parameters
    ----------
    tip : ContactPoint
        At the place; its own patch does not matter.
    contact_time, contact_radius, invert
        As for `compliance_error`.

    Raises
    ------
    InputError
        If the body has no mesh, or its surface no normal at the place.
    """
    s = SHIFT_TIMES_DURATION / positive("contact_time", contact_time, unit="s")
    least = _LEAST_OVER_CONTACT * positive("contact_radius", contact_radius, unit="m")
    surface = tip.body.surface
    if surface is None or tip.point is None:
        raise InputError(f"{tip!r} is not on the surface of a mesh; give the radius")
    quadratic = surface.mesh.quadratic
    radius = max(least, _START[quadratic] * edge_length(surface, tip.point))
    about = room(surface, tip.point, _MOST * radius)
    largest = min(_MOST * radius, _ROOMY * about.free)
    if largest <= least:
        return min(least, _WITHIN * about.free)
    radius = max(least, min(radius, _DEPTH * about.depth))
    solver, falls = (invert or tip.body.inverse)(s**2), _FALLS[quadratic]
    radii = np.geomspace(least, largest, _RADII)
    radius, found = min(radius, largest), {}
    for _ in range(_TRIES):
        estimate = _found_with(tip, radius, solver)
        if estimate is None:  # the surface has no room for this patch
            radii = radii[radii < _WITHIN * radius]
            if not len(radii):
                break
            radius = float(radii[-1])
            continue
        found[radius] = float(estimate.total(np.array([radius]), contact_radius, falls)[0])
        foreseen = float(radii[np.argmin(estimate.total(radii, contact_radius, falls))])
        if min(abs(math.log(foreseen / tried)) for tried in found) < _ALIKE:
            break
        radius = foreseen
    return min(found, key=lambda tried: found[tried], default=radius)


def _found_with(tip: ContactPoint, radius: float, solver: LinearSolver) -> _Found | None:
    try:
        one = contact_at(tip, radius)
    except InputError:
        return None
    return _found(one, solver.solve_roughly(one.b)[0])
