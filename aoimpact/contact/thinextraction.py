"""Local compliance of shell and beam elements at a contact, in excess of that of elastic bodies."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import scipy

from ..base import ROUNDING, BoolArray, FloatArray, IntArray
from ..fem import (
    FOLD,
    Beam,
    Layers,
    Piece,
    element_frames,
    pieces,
    rigid_ends,
    taken_material,
    thin_stiffness_mass,
)
from ..linalg import factorize
from ..mesh import Surface, boundary, halved, sides, taken
from .layer import (
    contact_reach,
    layer_compliance_of,
    mesh_compliance,
    plate_compliance,
    rim_nodes,
    slow_bending,
)
from .touch import touched

# Ratio of the frequency at which c is evaluated, s = 0.87/T, to 10/T. If c varies as ln s, the
# equation of motion shows that the peak force depends on c at 0.87/T under Hertz's law, and at
# 0.62/T for a half-sine force. On thin sheets, whose force is that of a dashpot, the peak comes
# about three times sooner.
_SLOW = 0.087

# Largest c E* √A of full sections of area A, where c is the compliance between contact and axis,
# which beam elements leave out. At the axis, √A/2 deep, the field of a half-space gives
# (1 + ν)(3 - 2ν)/(π (1 - ν²)) = 1.1 (K. L. Johnson, Contact Mechanics, 1985, eq. 3.17). For
# infinite square prisms the value is 1.3 to 1.5. Forces of balls of 5 and 10 mm on solids of 10 x
# 10, 20 x 6 and 6 x 20 mm agree with those on beams for values of 0.9 to 2.0.
_OF_SECTION = 2.0

# Tolerance, relative to the radius, in the search for a patch's radius; c compensates for the
# deviation.
_NEARLY = 1e-2

# For a contact at an edge. `_ABOUT`: radius of the mesh in element edges (with 4 edges, forces
# change by less than 0.5 %). `_MOST`: largest number of halvings of the elements before the last
# one; results for smaller elements are extrapolated linearly in the logarithm of the elements'
# size.
_ABOUT, _MOST = 2.0, 3


def patch_on_shell(layers: Layers, contact_radius: float, *, whole: bool = False) -> float:
    """Return the radius of the patch over which the contact force on a shell is spread, m.

    The radius r is chosen so that the excess c of the infinite plate over elastic layers does not
    depend on frequency. Bending contributes (a² - r²)/(10π D) ln λ to c. This balances the
    contribution of transverse shear, in which the plate is softer than the layers by about
    ν/(1 - ν) t²/(5 D), for r² of about a² + ν/(1 - ν) t². A still larger patch makes c vanish.

    Parameters
    ----------
    layers : Shell or Laminate
        Layers under the contact, which acts on the top.
    contact_radius : float
        Contact radius a, m.
    whole : bool, optional
        True for the patch with c = 0, so that nothing is removed from the contact law.
    """
    slow_s, t = slow_bending(layers), layers.total_thickness
    span = slow_s, slow_s / _SLOW
    known = [layer_compliance_of(layers, contact_radius, each) for each in span]

    def excess(radius: float) -> float:
        slow, fast = (
            plate_compliance(layers, radius, each) - of_layers
            for each, of_layers in zip(span, known, strict=True)
        )
        return slow if whole else slow - fast

    narrow, wide = contact_radius, 3.0 * (contact_radius + t)
    if excess(narrow) <= 0.0 or excess(wide) >= 0.0:
        return narrow if excess(narrow) <= 0.0 else wide
    return float(scipy.optimize.brentq(excess, narrow, wide, rtol=_NEARLY))


def excess_of_shell(tip: Any, layers: Layers, radius: float, s: float) -> tuple[float, float]:
    """Return the excess compliance of a shell over its elastic layers, and its uncertainty, m/N.

    Parameters
    ----------
    tip : ContactPoint
    layers : Shell or Laminate
        Layers under the contact, which acts on the top.
    radius : float
        Contact radius a, m.
    s : float
        Frequency (Laplace variable), 10/T for the contact duration T, rad/s.
    """
    body, point, normal, mesh = tip.body, tip.point, tip.normal, tip.body.mesh
    t = layers.total_thickness
    # Only the component of the force along the normal causes the excess compliance.
    cosine = float(tip.direction @ normal)
    pressed = _pressed(body.surface, tip)
    whole = np.abs(body.on_dofs(pressed) - tip.b / cosine).max() <= ROUNDING
    # If supports carry a part of the force, b is used, which lacks this part. Loads on added shape
    # functions are left out.
    forces = (pressed if whole else tip.forces / cosine)[:, : mesh.n_nodes]
    shares, couples = forces[0] @ normal, forces[1]
    loaded = shares != 0.0
    parts, slow = pieces(mesh, body.material, Layers), _SLOW * s
    around = [part.cells[loaded[part.cells].any(axis=1)] for part in parts]
    ends, number = sides(mesh.nodes, around)[:2]
    edge = float(np.linalg.norm(np.diff(mesh.nodes[ends], axis=1), axis=2).max())
    away = np.linalg.norm(mesh.nodes - point, axis=1)
    away -= away[loaded].max()
    level = _around(tip, parts, away < contact_reach(layers, edge, slow))
    groups = [part.cells[level[part.numbers]] for part in parts]
    of_layers = layer_compliance_of(layers, radius, slow)
    # Excess compliance of the infinite plate over its layers, under a patch at least t/2 wide.
    wide = max(0.5 * t, 0.0 if tip.patch is None else tip.patch.radius)
    excess = plate_compliance(layers, wide, slow) - of_layers
    at_edge = bool((rim_nodes(mesh.nodes, groups) & loaded).any())
    close = away < _ABOUT * edge
    about = [part.taken(close[part.cells].any(axis=1)) for part in parts]
    numbers = np.concatenate([of.numbers for of in about])
    halvings, unsure = min(max(0, round(math.log2(edge / t))), _MOST), 0.0
    if at_edge and whole:
        # The compliance of a plate mesh is linear in the logarithm of the elements' size. At an
        # edge it equals the compliance of a solid if the size is t, within a factor of 2.
        yields = _halved(tip, numbers, slow, halvings)
        unsure = abs(yields[-1] - yields[-2])
        finest = math.log2(edge / t) - halvings
        found = yields[0] - yields[-2] - (yields[-1] - yields[-2]) * finest
    else:
        found = mesh_compliance(mesh.nodes, groups, layers, shares, point, normal, slow, couples)
        found -= of_layers + excess
        joints = rigid_ends(mesh.nodes, [(of.cells, of.of) for of in about])
        if whole and any(len(strips) for _, strips, _ in joints):
            # Add the part of the mesh's excess compliance over a fine mesh that the joint causes:
            # the excess with all plates minus the excess of the touched plate alone.
            alone = _halved(tip, numbers[level[numbers]], slow, halvings)
            yields = _halved(tip, numbers, slow, halvings) - alone
            unsure = abs(yields[-1] - yields[-2])
            found += yields[0] - yields[-1]
    over_webs = np.unique(ends[np.bincount(number)[number] > 2])
    known = 0.5 if at_edge else 1.0 - 0.5 * float(shares[over_webs].sum())
    # For the share of the force at an edge or over a web, the excess compliance is between 0 and
    # `excess`, its value inside a plate: `excess`/2 is taken, with the uncertainty `excess`/2.
    found += known * excess
    unsure += (1.0 - known) * abs(excess)
    if len(layers.plies) == 1:
        narrow, wide = (layer_compliance_of(layers, f * radius, s) for f in (0.5, 1.0))
        unsure += abs(narrow - wide)
    return cosine**2 * float(found), cosine**2 * float(unsure)


def _pressed(surface: Surface, tip: Any) -> FloatArray:
    """Return nodal forces and couples, m, of a unit normal force, shape (2, n_nodes, 3)."""
    radius = 0.0 if tip.patch is None else tip.patch.radius
    return touched(surface, tip.point, tip.normal, radius).forces


def _halved(tip: Any, about: IntArray, s: float, halvings: int) -> FloatArray:
    """Return the compliance of a part of the shell for repeatedly halved elements, m/N.

    Parameters
    ----------
    tip : ContactPoint
    about : ndarray of int
        Shell elements about the contact, which form the part.
    s : float
        Frequency (Laplace variable), rad/s.
    halvings : int
        Number of halvings before the last one.

    Returns
    -------
    ndarray, shape (halvings + 2,)
        Compliance after 0 … halvings + 1 halvings.
    """
    body, cells, found = tip.body, np.sort(about), []
    held = np.hstack(list(body.at_nodes(np.ones(body.n_dofs)) == 0.0)).astype(np.float64)
    held = held[np.unique(body.mesh.cells[cells])]
    local, of = taken(body.mesh, cells), taken_material(body.material, cells)
    for level in range(halvings + 2):
        if level:
            mean, local, parent = halved(local)
            of, held = taken_material(of, parent), mean @ held
        shells = [(part.cells, part.of) for part in pieces(local, of, Layers)]
        K, M = thin_stiffness_mass(local.nodes, shells)
        free = np.flatnonzero(held.ravel() < 1.0 - ROUNDING)
        b = np.hstack(list(_pressed(boundary(local), tip))).ravel()[free]
        found.append(b @ factorize((K + s * s * M)[free][:, free]).solve(b))
    return np.array(found)


def excess_of_beam(beam: Beam) -> tuple[float, float]:
    """Return a beam's excess compliance over a half-space, which is 0, and its uncertainty, m/N.

    The uncertainty is the compliance of a full section between the contact and the beam's axis.
    """
    section = _OF_SECTION / (beam.material.plane_strain_modulus * math.sqrt(beam.numbers.area))
    return 0.0, 0.0 if beam.hollow else section


def _around(tip: Any, parts: list[Piece], close: BoolArray) -> BoolArray:
    """Return a mask of elements with a node in `close` and almost the contact point's normal."""
    mesh = tip.body.mesh
    own = np.zeros(mesh.n_cells, dtype=bool)
    for part in parts:
        level = np.abs(element_frames(mesh.nodes[part.cells], None)[0][:, 2] @ tip.normal) > FOLD
        own[part.numbers] = level & close[part.cells].any(axis=1)
    return own
