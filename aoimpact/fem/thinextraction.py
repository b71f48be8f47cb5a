"""Compliance that shell and beam elements have in place of a body's at a contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import FloatArray, IntArray
from ..linalg import LinearSolver
from .beams import Beam
from .compliance import ContactCompliance
from .composition import thin_parts
from .laminate import Layers
from .layer import (
    bending_length,
    contact_reach,
    layer_compliance_of,
    longest_edge,
    mesh_compliance,
)
from .shells import FOLD, element_frames

# The error is how much c changes from s = 0.87/T to 30/T, as shares of 10/T, where c is taken. What
# shear adds goes with ln s. The peak of a force follows from its value at 0.87/T under Hertz's law
# and at 0.62/T for half a sine, by the equation of motion for a small change of c that goes with
# ln s. In between c need not be monotonic.
_SPAN = (1.0, 0.087, 1.0 / 3.0, 3.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class ThinExtraction(ContactCompliance):
    """Compliances of a shell or beam at a contact point under a unit force.

    Here c is what the elements have in place of an elastic layer; 0 of a beam. It hardly depends on
    the radius of the contact. `error` is how much it changes over the frequencies of an impact:
    large where elements are longer than the bending wave. By c at both ends forces on sheets of
    elements up to three bending waves long are wrong by 1 to 1.3 times the error.

    Attributes
    ----------
    near : ndarray of bool, shape (n_cells,)
        Elements about the contact whose errors c makes good: none at a step of thickness, where c
        is not that of the infinite plate.
    edge_over_wave : float
        The longest edge of an element at the contact over λ = (D/(m s²))^(1/4); 0 of a beam.
    """

    near: npt.NDArray[np.bool_]
    edge_over_wave: float = 0.0


def extracted_from_shell(
    body: Any,
    layers: Layers,
    b: FloatArray,
    shares: FloatArray,
    couples: FloatArray,
    cosine: float,
    point: FloatArray,
    normal: FloatArray,
    radius: float,
    solver: LinearSolver,
) -> ThinExtraction:
    """Return the compliances at a place of a shell.

    Parameters
    ----------
    body : FEModel
    layers : Shell or Laminate
        Under the contact, which presses on its top.
    b : ndarray, shape (n_dofs,)
        The contact functional.
    shares, couples : ndarray, shape (n_nodes,) and (n_nodes, 3)
        Nodal forces and couples of the functional for a unit force along the normal.
    cosine : float
        Cosine of the angle between force and normal: along the surface the shell does not yield so.
    point, normal : ndarray, shape (3,)
    radius : float
        a, of the contact itself, m.
    solver : LinearSolver
        Factors of K + s²M.
    """
    mesh, s = body.mesh, math.sqrt(solver.pencil.s2)
    groups, near, edge = _around(body, layers, shares, point, normal, s)
    found = [
        mesh_compliance(mesh.nodes, groups, layers, shares, point, normal, f * s, couples)
        - layer_compliance_of(layers, radius, f * s, slowly=s)
        for f in _SPAN
    ]
    varying = 0.0
    if len(layers.plies) == 1:
        narrow, wide = (layer_compliance_of(layers, f * radius, s) for f in (0.5, 1.0))
        varying = abs(narrow - wide)
    share = cosine**2
    return ThinExtraction(
        removed=share * found[0],
        error=share * float(np.ptp(found)),
        varying=share * varying,
        radius=radius,
        near=near,
        edge_over_wave=edge / bending_length(layers, s),
        **_deflected(body, b, solver),
    )


def extracted_from_beam(
    body: Any, b: FloatArray, radius: float, solver: LinearSolver
) -> ThinExtraction:
    """Return the compliances at a place of a beam: it has a finite one, and nothing is removed."""
    none = np.zeros(body.mesh.n_cells, dtype=bool)
    return ThinExtraction(
        removed=0.0,
        error=0.0,
        varying=0.0,
        radius=radius,
        near=none,
        **_deflected(body, b, solver),
    )


def _deflected(body: Any, b: FloatArray, solver: LinearSolver) -> dict[str, Any]:
    x = solver.solve(b)
    return {"deflection": x, "strain": float(x @ (body.K @ x)), "s": math.sqrt(solver.pencil.s2)}


def _around(
    body: Any, layers: Layers, shares: FloatArray, point: FloatArray, normal: FloatArray, s: float
) -> tuple[list[IntArray], npt.NDArray[np.bool_], float]:
    """Elements of the smooth surface about a point, which of all these are, and their edge there.

    Elements belong to one surface if they share a node and their normals are alike.
    """
    mesh, loaded = body.mesh, shares != 0.0
    parts = [part for part in thin_parts(mesh, body.material) if not isinstance(part.of, Beam)]
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
    return [cells[own[cells[:, 0]]] for cells, _ in found], near, edge
