"""Compliance that shell and beam elements have in place of a body's at a contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy
import scipy.sparse as sp

from ..base import FloatArray, IntArray
from ..linalg import LinearSolver
from .beams import Beam
from .compliance import ContactCompliance
from .composition import pieces
from .laminate import Layers
from .layer import (
    contact_reach,
    layer_compliance_of,
    longest_edge,
    mesh_compliance,
    plate_compliance,
    shared_edges,
    slow_bending,
)
from .shells import FOLD, element_frames

# c is taken at s = 0.87/T, and compared with that at 3.3/T and 10/T, as shares of 10/T. A change of
# c that goes with ln s changes the peak of a force by its value at 0.87/T under Hertz's law, and at
# 0.62/T for half a sine, by the equation of motion. On thin sheets, whose force is that of a
# dashpot, the peak comes some three times sooner.
_SPAN = (0.087, 1.0 / 3.0, 1.0)

# Largest c E* √A of full sections. At the depth of the axis, √A/2, a half-space sinks by
# (1 + ν)(3 - 2ν)/(π (1 - ν²)) = 1.1 (K. L. Johnson, Contact Mechanics, 1985, eq. 3.17). Infinite
# square prisms have 1.3 to 1.5. Balls of 5 and 10 mm on solids of 10 x 10, 20 x 6 and 6 x 20 mm
# have the force of beams with 0.9 to 2.0.
_OF_SECTION = 2.0

# Relative precision of the radius of a patch; c makes good what it is off.
_NEARLY = 1e-2


@dataclass(frozen=True, eq=False, kw_only=True)
class ThinExtraction(ContactCompliance):
    """Compliances of a shell or beam at a contact point under a unit force.

    Here c is what the elements have in place of an elastic layer; it is taken to be 0 of beams. It
    hardly depends on the radius of the contact. `error` is how much it changes over the frequencies
    of a rising force, and `lagging` by how much for each power of e in frequency: large where
    elements are longer than the bending wave.

    Attributes
    ----------
    near : ndarray of bool, shape (n_cells,)
        Elements about the contact whose errors c makes good: none at a step of thickness, where c
        is not that of the infinite plate.
    doubtful : float
        c, m/N, where it is not taken out: at the edge of a shell, and over a web.
    """

    near: npt.NDArray[np.bool_]
    doubtful: float = 0.0


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
    span = slow_s, slow_s / min(_SPAN)
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


def extracted_from_shell(
    tip: Any, layers: Layers, radius: float, solver: LinearSolver
) -> ThinExtraction:
    """Return the compliances at a contact point on a shell.

    Parameters
    ----------
    tip : ContactPoint
    layers : Shell or Laminate
        Under the contact, which presses on their top.
    radius : float
        a, of the contact itself, m.
    solver : LinearSolver
        Factors of K + s²M.
    """
    body, point, normal = tip.body, tip.point, tip.normal
    # A unit force along the normal: along the surface the shell does not yield in this way.
    cosine = float(tip.direction @ normal)
    shares, couples = tip.forces[0] @ normal / cosine, tip.forces[1] / cosine
    mesh, s = body.mesh, math.sqrt(solver.pencil.s2)
    groups, near = _around(body, layers, shares, point, normal, min(_SPAN) * s)
    several = s * np.array(_SPAN)
    of_mesh = mesh_compliance(mesh.nodes, groups, layers, shares, point, normal, several, couples)
    found = of_mesh - [layer_compliance_of(layers, radius, each) for each in several]
    steps, varying, removed, doubtful = np.diff(found), 0.0, float(found[0]), 0.0
    loaded, surfaces = (
        shares != 0.0,
        [of.cells for of in mesh.blocks if of.kind in ("quad", "triangle")],
    )
    edges, count = shared_edges([cells[loaded[cells].any(axis=1)] for cells in surfaces])
    if loaded[edges[count != 2]].any():
        # c is that of an interior, and would take more or less out of the law than an edge or a web
        # yields.
        removed, doubtful = 0.0, removed
    if len(layers.plies) == 1:
        narrow, wide = (layer_compliance_of(layers, f * radius, s) for f in (0.5, 1.0))
        varying = abs(narrow - wide)
    share = cosine**2
    return ThinExtraction(
        removed=share * removed,
        doubtful=share * doubtful,
        error=share * abs(float(steps[0])),
        varying=share * varying,
        lagging=share * float(np.abs(steps / np.diff(np.log(_SPAN))).max()),
        radius=radius,
        near=near,
        **_deflected(tip, solver),
    )


def extracted_from_beam(
    tip: Any, beam: Beam, radius: float, solver: LinearSolver
) -> ThinExtraction:
    """Return the compliances at a contact point on a beam.

    A full section yields less between the contact and its axis than the half-space of a law:
    `varying` is by how much at most. Parameters as for `extracted_from_shell`.
    """
    section = _OF_SECTION / (beam.material.plane_strain_modulus * math.sqrt(beam.numbers.area))
    return ThinExtraction(
        removed=0.0,
        error=0.0,
        varying=0.0 if beam.hollow else section,
        radius=radius,
        near=np.zeros(tip.body.mesh.n_cells, dtype=bool),
        **_deflected(tip, solver),
    )


def _deflected(tip: Any, solver: LinearSolver) -> dict[str, Any]:
    x, s = solver.solve(tip.b), math.sqrt(solver.pencil.s2)
    return {"deflection": x, "strain": float(x @ (tip.body.K @ x)), "s": s}


def _around(
    body: Any, layers: Layers, shares: FloatArray, point: FloatArray, normal: FloatArray, s: float
) -> tuple[list[IntArray], npt.NDArray[np.bool_]]:
    """Elements of the smooth surface about a point, and which of all these are.

    Elements belong to one surface if they share a node and their normals are alike.
    """
    mesh, loaded = body.mesh, shares != 0.0
    parts = pieces(mesh, body.material, Layers)
    edge = longest_edge(mesh.nodes, [part.cells for part in parts], loaded)
    away = np.linalg.norm(mesh.nodes - point, axis=1)
    close = away < contact_reach(layers, edge, s) + float(away[loaded].max())
    found = []
    for part in parts:
        inside = close[part.cells].any(axis=1)
        cells, numbers = part.cells[inside], part.numbers[inside]
        level = np.abs(element_frames(mesh.nodes[cells], None)[0][:, 2] @ normal) > FOLD
        found.append((cells[level], numbers[level]))
    row = np.concatenate([np.repeat(cells[:, 0], cells.shape[1]) for cells, _ in found])
    column = np.concatenate([cells.ravel() for cells, _ in found])
    links = sp.coo_array((np.ones(len(row)), (row, column)), shape=(mesh.n_nodes,) * 2)
    label = sp.csgraph.connected_components(links, directed=False)[1]
    own = np.isin(label, label[loaded])
    near = np.zeros(mesh.n_cells, dtype=bool)
    for part, (cells, numbers) in zip(parts, found, strict=True):
        others = [one.cells.ravel() for one in parts if one.of != part.of]
        step = np.isin(cells, np.concatenate([*others, [-1]])).any(axis=1)
        near[numbers[own[cells[:, 0]] & ~step]] = True
    return [cells[own[cells[:, 0]]] for cells, _ in found], near
