"""Rows of a body's dofs at places on it: motion, stress, strain and the strain of a gauge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray, InputError, IntArray
from ..contact import motion_between, to_nodes
from ..fem import AnyMaterial, FEModel, Layer, Strain, StressRows, body_stress_rows, compliances
from ..mesh import Mesh, node_at, weights_at

# Places along a gauge on a shell at which its strain is taken.
_ALONG = 8


@dataclass(frozen=True, eq=False)
class TensorRows:
    """Stress or strain at places on a body.

    Attributes
    ----------
    elements : StressRows
        By its dofs.
    places : ndarray, shape (p, 3)
        m.
    compliance : ndarray, shape (p, 6, 6), or None
        Of strain, by which it follows from stress, 1/Pa.
    """

    elements: StressRows
    places: FloatArray
    compliance: FloatArray | None = None


def tensor_rows(
    body: FEModel, weights: sp.csr_array, layer: Layer, *, strain: bool = False
) -> TensorRows:
    """Return stress or strain at places with the nodes' `weights`, shape (p, n_nodes)."""
    assert body.nodes is not None
    assert body.free is not None
    rows = stress_rows(body, weights, body.free, layer, strain=strain)
    return TensorRows(rows, weights @ body.nodes, compliance(body, weights) if strain else None)


def shell_gauge_rows(
    body: FEModel, ends: FloatArray, along: FloatArray, layer: Layer
) -> sp.csr_array | None:
    """Return the strain of a gauge on a layer of a shell by a body's dofs, (1, n_dofs).

    It is the mean along the gauge. None of a body of solids, whose gauge is the change of distance
    between its ends.
    """
    assert body.free is not None
    if body.mesh is None or not body.mesh.thin:
        return None
    x, w = np.polynomial.legendre.leggauss(_ALONG)
    places = ends[0] + np.outer(0.5 + 0.5 * x, ends[1] - ends[0])
    rows = stress_rows(body, place_rows(body, places), body.free, layer, strain=True)
    if not rows.linear:
        raise InputError(
            "a gauge sits on a surface, and beams have only an axis; take the strain of a side, "
            "probe(point, layer=, part=).strain"
        )
    component = Strain(np.eye(6), places).along(along)
    return sp.csr_array(sp.kron(0.5 * w[None], component[None]) @ rows.rows)


def place_rows(body: FEModel, places: FloatArray) -> sp.csr_array:
    """Return the nodes' weights at places (p, 3), m, of a body, shape (p, n_nodes)."""
    assert body.nodes is not None
    weights = sp.lil_array((len(places), len(body.nodes)))
    for i, place in enumerate(places):
        if body.mesh is None:
            weights[i, node_at(body.nodes, place)] = 1.0
        else:
            where, shares = weights_at(body.mesh, to_nodes(body, place))
            weights[i, where] = shares
    return weights.tocsr()


def stress_rows(
    body: FEModel,
    weights: sp.csr_array,
    free: IntArray,
    layer: Layer,
    *,
    strain: bool = False,
) -> StressRows:
    """Return the stress, or strain, at places with the nodes' `weights`, shape (p, n_nodes)."""
    mesh, material = solid(body, "stress")
    rows = body_stress_rows(mesh, material, weights, layer, strain=strain)
    if not rows.known.all():
        raise InputError(
            f"{layer}: the body has no such place at the point (of a beam without orientation the "
            "sides are not known)"
        )
    return rows.of_dofs(free)


def compliance(body: FEModel, weights: sp.csr_array) -> FloatArray:
    """Return strain by stress at places with the nodes' `weights`, 1/Pa, shape (p, 6, 6)."""
    mesh, material = solid(body, "strain")
    if mesh.thin:  # under whose contacts there is no half-space
        return np.zeros((weights.shape[0], 6, 6))
    near = np.unique(weights.indices)
    found: FloatArray = weights[:, near].toarray() @ compliances(mesh, material, near).reshape(
        -1, 36
    )
    return found.reshape(-1, 6, 6)


def motion_rows(body: FEModel, weights: sp.csr_array, axes: FloatArray) -> sp.csr_array:
    """Return the motion along axes (k, 3) at places with the nodes' weights, (p k, n_dofs)."""
    assert body.free is not None
    rows = sp.csr_array(sp.kron(weights, axes))
    if body.mesh is None or not body.mesh.thin:
        return rows[:, body.free]
    n, own = rows.shape[1], np.arange(len(axes))
    rows.resize((rows.shape[0], 2 * n))  # rotations move no node, but places between nodes
    rows = rows.tolil()
    for place in np.flatnonzero(np.diff(weights.indptr) > 1):
        held = slice(*weights.indptr[place : place + 2])
        known = motion_between(body, weights.indices[held], weights.data[held])
        if known is not None:
            nodes, motion = known
            dofs = 3 * nodes[:, None, None] + np.array([[0], [n]]) + np.arange(3)
            at = np.ix_(place * len(axes) + own, dofs.ravel())
            rows[at] = np.tensordot(axes, motion, 1).reshape(len(axes), -1)
    return rows.tocsr()[:, body.free]


def solid(body: FEModel, what: str) -> tuple[Mesh, AnyMaterial]:
    """Return the body's mesh and material; `what` needs them."""
    if body.mesh is None or body.material is None:
        raise InputError(
            f"{what} needs elements and a material, and this body was given by its matrices K and "
            "M: make it with FEModel.from_mesh(mesh, material)"
        )
    return body.mesh, body.material
