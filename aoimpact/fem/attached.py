"""Attachments to the nodes of a body: masses, and springs to the ground."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import (
    PRINTED,
    FloatArray,
    InputError,
    IntArray,
    checked,
    inertia_tensor,
    place,
    positive,
    warn,
)
from ..linalg import LARGEST
from ..mesh import Mesh, motions_at
from .labels import label_of
from .supports import Selector, components, constrained, entries, nodes_of_mesh

# A rotation that nodes tell less well than this from none, by singular values of their motions.
_UNKNOWN = 1e-5

# The mass of a rigid attachment couples all of its nodes: a matrix of (3 · nodes)².
_MOST_NODES = 500

# Sizes of the body beyond which a rigid mass is given in millimetres in messages.
_FAR = 50.0


@dataclass(frozen=True, eq=False)
class RigidMass:
    """A rigid part of a machine on some nodes: a mass with a centre and moments of inertia.

    It takes part in the mean rigid motion of its nodes, the one that fits their displacements best,
    and does not stiffen them (Nastran's RBE3, Abaqus' distributing coupling); where the seat is to
    be stiff, mesh it. The body's mass, centre of mass and moments of inertia come out exactly.

    Parameters
    ----------
    nodes : str, callable or array_like
        As in `fixed`: at most 500, not all on one line unless there is neither inertia nor a centre
        off their middle.
    mass : float
        kg.
    centre : array_like, shape (3,), optional
        Its centre of mass, m; the middle of the nodes if left out.
    inertia : array_like, shape (3,) or (3, 3), optional
        Moments of inertia about axes x, y, z through its centre of mass, or their tensor, kg m²;
        none if left out.

    Raises
    ------
    InputError, InputTypeError
        If the mass is not positive, or the inertia is none of a body.

    Examples
    --------
    >>> RigidMass("seat", 5.0, centre=(0, 0, 0.15), inertia=(0.02, 0.02, 0.01)).mass
    5.0
    """

    nodes: Selector
    mass: float
    centre: npt.ArrayLike | None = None
    inertia: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        checked(self, mass=partial(_bounded, unit="kg"))
        if self.centre is not None:
            checked(self, centre=place)
        if self.inertia is not None:
            checked(self, inertia=partial(inertia_tensor, most=LARGEST))


Mounted = tuple[Selector, float] | RigidMass
SpringSupport = tuple[Selector, str, float]


def added_mass(mesh: Mesh, masses: Sequence[Mounted] | None, free: IntArray) -> sp.csr_array | None:
    """Return what is added to M over all dofs, shape (3 n_nodes, 3 n_nodes); None for nothing.

    Parameters
    ----------
    mesh : Mesh
    masses : sequence of (nodes, kg) or RigidMass
        A mass is shared equally by its nodes, in all three directions.
    free : ndarray of int
        The dofs that no support holds.

    Raises
    ------
    InputError, InputTypeError
        If an entry is none of these or selects nothing, or a mass is not positive.
    """
    how = 'give a list of pairs such as [("carriage", 5.0)], or of RigidMass'
    added = None
    for name, entry in entries("masses", masses, (2,), how, RigidMass):
        if isinstance(entry, RigidMass):
            one = _rigid(name, entry, mesh)
        else:
            selector, mass = entry
            ids = nodes_of_mesh(name, selector, mesh)
            share = np.zeros((mesh.n_nodes, 3))
            share[ids] = _bounded(f"{name}: the mass", mass, "kg") / len(ids)
            one = sp.diags_array(share.reshape(-1), format="csr")
            one.eliminate_zeros()
        on = np.unique(np.flatnonzero(one.diagonal()) // 3)
        held = len(on) - np.count_nonzero(np.isin(on, free // 3))
        if held:
            warn(
                f"{name}: {held} of the {len(on)} nodes that carry it are constrained by "
                "fixed, and their shares do not move; take other nodes, or release these"
            )
        added = one if added is None else added + one
    return added


def _rigid(name: str, mount: RigidMass, mesh: Mesh) -> sp.csr_array:
    """WᵀJW with q = W u the rigid motion about its centre that fits its nodes best."""
    ids, nodes = nodes_of_mesh(name, mount.nodes, mesh), mesh.nodes
    if len(ids) > _MOST_NODES:
        raise InputError(
            f"{name}: the rigid mass is on {len(ids)} nodes, {_MOST_NODES} are the most: take some "
            "of them, well spread over the seat"
        )
    middle = nodes[ids].mean(axis=0)
    centre = middle if mount.centre is None else np.asarray(mount.centre)
    inertia = np.zeros((3, 3)) if mount.inertia is None else np.asarray(mount.inertia)
    size = float(np.abs(nodes[ids] - middle).max()) or 1.0
    motions = motions_at((nodes[ids] - middle) / size).reshape(-1, 6)
    values, vectors = np.linalg.eigh(motions.T @ motions)
    known = values > _UNKNOWN**2 * values[-1]
    fit = (vectors[:, known] / values[known]) @ (motions @ vectors[:, known]).T
    # From translation and rotation · size about the middle of the nodes to those about the centre.
    to_centre = np.eye(6)
    to_centre[:3, 3:] = motions_at((centre - middle)[None] / size)[0, :, 3:]
    weights = np.zeros((6, 6))
    weights[:3, :3] = mount.mass * np.eye(3)
    weights[3:, 3:] = inertia / size**2
    weights = to_centre.T @ weights @ to_centre
    lost = vectors[:, ~known].T @ weights
    if np.abs(lost).max(initial=0.0) > PRINTED * mount.mass:
        raise InputError(
            f"{name}: its {len(ids)} nodes lie on one line, or are one, and tell no rotation about "
            "it, which has inertia there; give nodes spread over the seat, or leave centre and "
            "inertia out"
        )
    body, radius = float(np.ptp(nodes, axis=0).max()), math.sqrt(np.trace(inertia))
    radius /= math.sqrt(mount.mass)
    off = float(np.linalg.norm(centre - nodes.mean(axis=0)))
    for what, value in (
        (f"centre is {off:.3g} m from", off),
        (f"inertia reaches {radius:.3g} m beyond", radius),
    ):
        if value > _FAR * body > 0.0:
            warn(
                f"{name}: its {what} a body of {body:.3g} m: centre is in m, inertia in kg m² "
                "(1 kg mm² is 1e-6)"
            )
    block = fit.T @ weights @ fit
    dofs = (3 * ids[:, None] + np.arange(3)).reshape(-1)
    row, column = np.repeat(dofs, len(dofs)), np.tile(dofs, len(dofs))
    entries = (0.5 * (block + block.T)).reshape(-1)
    return sp.csr_array((entries, (row, column)), shape=(nodes.size, nodes.size))


def spring_stiffness(
    mesh: Mesh, springs: Sequence[SpringSupport] | None, free: IntArray
) -> FloatArray | None:
    """Return what is added to the diagonal of K over all dofs, shape (3 n_nodes,); None for none.

    Parameters
    ----------
    mesh : Mesh
    springs : sequence of (nodes, letters, N/m)
        The stiffness is that of all the nodes together, in each of the directions named.
    free : ndarray of int
        The dofs that no support holds.

    Raises
    ------
    InputError, InputTypeError
        If an entry is none of these or selects nothing, a stiffness is not positive, or a support
        holds a node against its spring.
    """
    how = 'give a list such as [("mounts", "z", 1e6)]: nodes, letters, N/m'
    total = np.zeros((mesh.n_nodes, 3))
    held = constrained(free, mesh.n_nodes)
    for name, (selector, letters, stiffness) in entries("springs", springs, (3,), how):
        ids = nodes_of_mesh(name, selector, mesh)
        share = _bounded(f"{name}: the stiffness", stiffness, "N/m") / len(ids)
        for component in components(name, letters):
            on_support = held[ids, component]
            if on_support.any():
                first = label_of(int(ids[on_support][0]), mesh.node_labels)
                raise InputError(
                    f"{name}: {int(on_support.sum())} of its {len(ids)} nodes, the first is "
                    f"{first}, are constrained in {'xyz'[component]} by fixed, so "
                    "that the spring would not act there; release them, or take other nodes"
                )
            total[ids, component] += share
    return total.reshape(-1) if total.any() else None


def _bounded(name: str, value: Any, unit: str) -> float:
    number = positive(name, value, unit=unit)
    if number > LARGEST:
        raise InputError(
            f"{name} is {number:g} {unit}, whose products cannot be computed; give it in {unit}, "
            "and what does not move as a support, fixed"
        )
    return number
