"""What the compliance of a contact point leaves out: the mesh's error, and the half-space's.

The contact sees a body through G = bᵀx with x = (K + s²M)⁻¹ b, s = 10/T for a contact of duration
T. Two things are wrong with it.

*Mesh.* Elements are too stiff: G is too small by the energy of the error of x, which the jumps of
its stress between elements estimate (`energy_error`).

*Contact.* The law contains the deflection of a half-space under the contact, and that under the
patch is taken out, c = 0.6/(r E*). What is left of the body, R(r) = G - c, should be the same for
every r. It is not where the body about the patch is no half-space: R(r) - R(a) with a the radius of
the contact itself is then wrong. Of one field x the mean displacement under Hertz's pressure on
another radius r' at the same place, b'ᵀx, is known as well, and so is its value on a half-space.
In the image field that is left the pressures enter by their second moments alone, so R moves with
r² and by twice as much when both radii change.

A node, or a point, of a mesh is indented the more the finer the mesh is, and the law contains all
of that. By reciprocity the displacement under a patch r' due to the node is that of the node due to
the patch, which the mesh resolves: so R is known there from the same x.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, InputTypeError, nonnegative, positive
from ..fem import ContactPoint, contact_at, mutual_compliance, resolved_radius, room
from ..fields import energy_error
from ..linalg import LinearSolver
from ..reduction import SHIFT_TIMES_DURATION, AOModel, InterfaceModel, unbalanced

__all__ = ["ComplianceError", "best_radius", "compliance_error"]


# The estimate of the mesh's error is multiplied by this.
_SAFETY = 2.0

# R at a patch of another radius, so much larger, or smaller where the surface has no room.
_LARGER = 1.25

# A contact of unknown radius is taken to be half as wide as its patch.
_CONTACT_WITHIN_PATCH = 0.5

# A reduced model's own field serves if it leaves no more than this of b unbalanced.
_BALANCED = 0.02

# The law less the patch's part stands for contacts that are narrower by this at least.
_LEAST_OVER_CONTACT = 1.25

# The surface ends a little before the ring of quadrature points on which that is noticed.
_WITHIN = 0.95

# Radii that are tried: each so many times the one before, from this share of what the mesh resolves
# well to that.
_STEP, _FROM, _TO = 1.5, 0.4, 2.0


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
        bᵀ(K + s²M)⁻¹b of the contact point, to which these belong.
    """

    mesh: float
    contact: float
    compliance: float

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
    """Return what the compliance of a contact point leaves out; None where that is not known.

    It is known of bodies made from a mesh, at places where the surface has a normal.

    Parameters
    ----------
    tip : ContactPoint, AOModel or InterfaceModel
        Of a model its own deflection is taken, without a linear solution, if that leaves little
        unbalanced.
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
    model = None if isinstance(tip, ContactPoint) else tip
    if model is not None:
        if not isinstance(model, AOModel | InterfaceModel):
            raise InputTypeError(
                f"tip must be a contact point or a model made from one, got {tip!r}"
            )
        if not model.contact_points:
            return None
        tip = model.contact_points[port]
    if tip.body.mesh is None or tip.point is None:
        return None
    if displacement is None and model is not None:
        displacement = _own_deflection(model, s, port)
    if displacement is None:
        displacement = (invert or tip.body.inverse)(s**2).solve(tip.b)
    return _error_of(tip, displacement, contact_radius)


def _own_deflection(model: Any, s: float, port: int) -> FloatArray | None:
    """(K + s²M)⁻¹ b of a model, at the shift it was fitted to if there is one; None if poor."""
    if model.contact_time is not None:
        s = SHIFT_TIMES_DURATION / model.contact_time
    if unbalanced(model, s, port) > _BALANCED:
        return None
    found: FloatArray = model._deflection(s, port)
    return found


def _error_of(
    tip: ContactPoint, x: FloatArray, contact_radius: float | None
) -> ComplianceError | None:
    energy, compliance = _energy(tip, x), float(tip.b @ x)
    if tip.patch is None:
        resolved = _resolved_patch(tip)
        if resolved is None:
            return None
        assert resolved.patch is not None
        remaining = float(resolved.b @ x) - mutual_compliance(resolved.patch, 0.0)
        away = _distance(tip) > resolved.patch.radius
        mesh = _SAFETY * float(energy[away].sum())
        return ComplianceError(mesh, compliance - remaining, compliance)
    radius = tip.patch.radius
    contact = _CONTACT_WITHIN_PATCH * radius
    if contact_radius is not None:
        contact = nonnegative("contact_radius", contact_radius, unit="m")
    other = _other_patch(tip)
    assert other.patch is not None
    here = compliance - tip.patch.compliance
    there = float(other.b @ x) - mutual_compliance(tip.patch, other.patch.radius)
    slope = 2.0 * (there - here) / (other.patch.radius**2 - radius**2)
    wider = slope * (radius**2 - contact**2)
    return ComplianceError(_SAFETY * float(energy.sum()), wider, compliance)


def _energy(tip: ContactPoint, x: FloatArray) -> FloatArray:
    """The energy of the error of x in each element, J, shape (n_cells,)."""
    body = tip.body
    assert body.mesh is not None
    assert body.material is not None
    moved = np.zeros(3 * body.mesh.n_nodes)
    moved[body.free] = x
    return energy_error(body.mesh, body.material, moved.reshape(-1, 3))


def _distance(tip: ContactPoint) -> FloatArray:
    """From the contact to the middle of each element, m."""
    mesh = tip.body.mesh
    assert mesh is not None
    distance: FloatArray = np.linalg.norm(mesh.nodes[mesh.cells].mean(axis=1) - tip.point, axis=1)
    return distance


def _other_patch(tip: ContactPoint) -> ContactPoint:
    assert tip.patch is not None
    try:
        return contact_at(tip, _LARGER * tip.patch.radius)
    except InputError:  # no room
        return contact_at(tip, tip.patch.radius / _LARGER)


def _resolved_patch(tip: ContactPoint) -> ContactPoint | None:
    """The contact with a patch that the mesh resolves, as far as there is room; None on an edge."""
    surface = tip.body.surface
    assert surface is not None
    assert tip.point is not None
    try:
        radius = resolved_radius(surface, tip.point)
        return contact_at(tip, min(radius, _WITHIN * room(surface, tip.point, radius).free))
    except InputError:
        return None


def best_radius(
    tip: ContactPoint,
    *,
    contact_time: float,
    contact_radius: float,
    invert: Callable[[float], LinearSolver] | None = None,
) -> float:
    """Return the radius of the patch at a place for which both errors together are least, m.

    Some five radii are tried, in one solution with as many right-hand sides. Where the surface has
    no room for any that the law could stand for, it is the largest that fits.

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
    resolved = resolved_radius(surface, tip.point)
    start, end = max(least, _FROM * resolved), max(_STEP * least, _TO * resolved)
    count = 1 + math.ceil(math.log(end / start) / math.log(_STEP))
    radii: list[float] = (start * _STEP ** np.arange(count)).tolist()
    free = room(surface, tip.point, 1.1 * radii[-1]).free
    radii = [radius for radius in radii if radius < free] or [_WITHIN * free]
    tips = [contact_at(tip, radius) for radius in radii]
    if len(tips) == 1:
        return radii[0]
    loads = np.stack([one.b for one in tips], axis=1)
    found = (invert or tip.body.inverse)(s**2).solve(loads)
    totals = []
    for one, x in zip(tips, np.ascontiguousarray(found.T), strict=True):
        error = _error_of(one, x, contact_radius)
        assert error is not None
        totals.append(error.total)
    return radii[int(np.argmin(totals))]
