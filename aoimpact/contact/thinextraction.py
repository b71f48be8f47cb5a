"""Compliance that shell and beam elements have in place of a body's at a contact."""

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

# c is taken at s = 0.87/T, as a share of 10/T. A change of c that goes with ln s changes the peak
# of a force by its value at 0.87/T under Hertz's law, and at 0.62/T for half a sine, by the
# equation of motion. On thin sheets, whose force is that of a dashpot, the peak comes some three
# times sooner.
_SLOW = 0.087

# Largest c E* √A of full sections. At the depth of the axis, √A/2, a half-space sinks by
# (1 + ν)(3 - 2ν)/(π (1 - ν²)) = 1.1 (K. L. Johnson, Contact Mechanics, 1985, eq. 3.17). Infinite
# square prisms have 1.3 to 1.5. Balls of 5 and 10 mm on solids of 10 x 10, 20 x 6 and 6 x 20 mm
# have the force of beams with 0.9 to 2.0.
_OF_SECTION = 2.0

# Relative precision of the radius of a patch; c makes good what it is off.
_NEARLY = 1e-2

# The mesh about a contact at an edge reaches over so many of its edges: with 4 forces change by
# less than 0.5 %. It is halved so many times at most, and once more; the logarithm has the rest.
_ABOUT, _MOST = 2.0, 3


def patch_on_shell(layers: Layers, contact_radius: float, *, whole: bool = False) -> float:
    """Return the radius of the patch that a force on a shell is spread over, m.

    Under a patch of radius r a plate yields like the elastic layers under the contact, and c of the
    infinite plate is the same at all frequencies: bending adds (a² - r²)/(10π D) ln λ to c, and
    the plate's shear, which is softer than that of the layers by about ν/(1 - ν) t²/(5 D), the
    rest. So r² is about a² + ν/(1 - ν) t². Under a larger patch c is 0.

    Parameters
    ----------
    layers : Shell or Laminate
        The contact presses on their top.
    contact_radius : float
        a, m.
    whole : bool, optional
        True for the patch under which c is 0, which leaves the whole law.
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
    """Return what a shell yields more than its layers under a contact, and how unsure that is, m/N.

    Parameters
    ----------
    tip : ContactPoint
    layers : Shell or Laminate
        Under the contact, which presses on their top.
    radius : float
        a, of the contact itself, m.
    s : float
        rad/s.
    """
    body, point, normal, mesh = tip.body, tip.point, tip.normal, tip.body.mesh
    t = layers.total_thickness
    # A unit force along the normal: along the surface the shell does not yield in this way.
    cosine = float(tip.direction @ normal)
    pressed = _pressed(body.surface, tip)
    whole = np.abs(body.on_dofs(pressed) - tip.b / cosine).max() <= ROUNDING
    # Supports hold a part of it in the body; added functions of solids beside it are no nodes.
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
    # Compliance of infinite plates beyond that of their layers under a patch of some width.
    wide = max(0.5 * t, 0.0 if tip.patch is None else tip.patch.radius)
    excess = plate_compliance(layers, wide, slow) - of_layers
    at_edge = bool((rim_nodes(mesh.nodes, groups) & loaded).any())
    close = away < _ABOUT * edge
    about = [part.taken(close[part.cells].any(axis=1)) for part in parts]
    numbers = np.concatenate([of.numbers for of in about])
    halvings, unsure = min(max(0, round(math.log2(edge / t))), _MOST), 0.0
    if at_edge and whole:
        # The compliance of plates goes with the logarithm of the elements' size. At an edge it is
        # that of solids where these are as large as t, within a factor of 2.
        yields = _halved(tip, numbers, slow, halvings)
        unsure = abs(yields[-1] - yields[-2])
        finest = math.log2(edge / t) - halvings
        found = yields[0] - yields[-2] - (yields[-1] - yields[-2]) * finest
    else:
        found = mesh_compliance(mesh.nodes, groups, layers, shares, point, normal, slow, couples)
        found -= of_layers + excess
        joints = rigid_ends(mesh.nodes, [(of.cells, of.of) for of in about])
        if whole and any(len(strips) for _, strips, _ in joints):
            # Where plates meet, the mesh yields more than a fine one by this beyond the skin's own.
            alone = _halved(tip, numbers[level[numbers]], slow, halvings)
            yields = _halved(tip, numbers, slow, halvings) - alone
            unsure = abs(yields[-1] - yields[-2])
            found += yields[0] - yields[-1]
    over_webs = np.unique(ends[np.bincount(number)[number] > 2])
    known = 0.5 if at_edge else 1.0 - 0.5 * float(shares[over_webs].sum())
    # At an edge, or over a web, plates have none to all of what an interior has: half, ± half.
    found += known * excess
    unsure += (1.0 - known) * abs(excess)
    if len(layers.plies) == 1:
        narrow, wide = (layer_compliance_of(layers, f * radius, s) for f in (0.5, 1.0))
        unsure += abs(narrow - wide)
    return cosine**2 * float(found), cosine**2 * float(unsure)


def _pressed(surface: Surface, tip: Any) -> FloatArray:
    """Forces and couples, m, of a unit force along the normal on the nodes, (2, n_nodes, 3)."""
    radius = 0.0 if tip.patch is None else tip.patch.radius
    return touched(surface, tip.point, tip.normal, radius).forces


def _halved(tip: Any, about: IntArray, s: float, halvings: int) -> FloatArray:
    """Return what elements yield alone, halved so many times and once more, (times + 2,), m/N.

    Parameters
    ----------
    tip : ContactPoint
    about : ndarray of int
        The elements of shells about the contact.
    s : float
        rad/s.
    halvings : int
        How often, from 0.
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
    """Return what a beam yields more than the half-space of a law, none, and at most less, m/N.

    A full section yields less between the contact and its axis.
    """
    section = _OF_SECTION / (beam.material.plane_strain_modulus * math.sqrt(beam.numbers.area))
    return 0.0, 0.0 if beam.hollow else section


def _around(tip: Any, parts: list[Piece], close: BoolArray) -> BoolArray:
    """Which elements have close nodes and normals like the contact's."""
    mesh = tip.body.mesh
    own = np.zeros(mesh.n_cells, dtype=bool)
    for part in parts:
        level = np.abs(element_frames(mesh.nodes[part.cells], None)[0][:, 2] @ tip.normal) > FOLD
        own[part.numbers] = level & close[part.cells].any(axis=1)
    return own
