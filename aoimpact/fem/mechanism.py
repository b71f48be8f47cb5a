"""Mechanisms: parts of a mesh that move against each other without elastic force.

Elements that share a whole side cannot move against each other without strain. So what hangs
together by whole sides has six rigid motions, of which shared edges, shared nodes and supports take
some away. Those that are left, beside the rigid motions of the body as a whole, are a mechanism: a
piece that swings about an edge or a node. An edge of second order may hold where it is curved,
several edges together may, and so may pieces around a ring: that is a question of rank.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import ROUNDING, FloatArray, IntArray
from ..linalg import lowest, m_orthonormal
from ..mesh import Surface, motions_at

# bᵀφ of a motion that b moves, over ‖b‖‖φ‖.
_MOVED = 1e-10

# Square of the share of the parts' motions that joints and supports do not resist: nodes off a line
# by less than 1e-4 of the parts' size count as on it, as mesh files round to six digits or so. Such
# an offset holds like a spring of 1e-8 of the body's stiffness.
_UNRESISTED = 1e-8

# Motions that are asked for at first.
_FIRST_BLOCK = 32


@dataclass(frozen=True, eq=False)
class Mechanism:
    """Motions of a body without elastic force that are not rigid-body motions.

    Attributes
    ----------
    motions : ndarray, shape (n_dofs, m)
        M-orthonormal, and M-orthogonal to the rigid motions. Without a mesh one of them, with a
        part of every one.
    """

    motions: FloatArray
    _parts: _Parts | None = None
    _turns: FloatArray | None = None  # of the parts, (n_parts, 3, m)

    def moved_by(self, b: FloatArray) -> bool:
        """True if a force along b, shape (n_dofs,), moves the parts against each other."""
        size = np.linalg.norm(b) * np.linalg.norm(self.motions)
        return float(np.linalg.norm(b @ self.motions)) > _MOVED * float(size)

    def where(self, b: FloatArray) -> str:
        """Name the joint that a force along b turns most, and what hangs on it, if it is known."""
        parts = self._parts
        if parts is None or self._turns is None:
            return "see body.mechanism.motions"
        turn = self._turns @ (b @ self.motions)
        apart = np.linalg.norm(turn[parts.one] - turn[parts.other], axis=1)
        pair = [int(side[apart.argmax()]) for side in (parts.one, parts.other)]
        sizes = np.bincount(parts.part)
        small, large = sorted(pair, key=sizes.__getitem__)
        first = int(np.flatnonzero(parts.part == small)[0])
        here = np.isin(parts.one, pair) & np.isin(parts.other, pair)
        nodes = np.unique(parts.joint[here])
        place = ", ".join(f"{x:.4g}" for x in parts.surface.mesh.nodes[nodes[0]])
        shared = f"node {nodes[0]}" if len(nodes) == 1 else f"{len(nodes)} nodes on a line"
        return (
            f"{sizes[small]} of {len(parts.part)} elements, the first is element {first}, share no "
            f"side with the others, but {shared} near ({place}) m with {sizes[large]} of them"
        )


def mechanism_of(
    surface: Surface,
    free: IntArray,
    M: Any,
    rigid: FloatArray,
    springs: FloatArray | None = None,
) -> Mechanism | None:
    """Return the mechanism of a mesh; None if there is none.

    Parameters
    ----------
    surface : Surface
    free : ndarray of int, shape (n_dofs,)
        The dofs 3·node + component that no support holds.
    M : scipy.sparse.csr_array, shape (n_dofs, n_dofs)
    rigid : ndarray, shape (n_dofs, r)
        M-orthonormal rigid motions that the supports leave free.
    springs : ndarray, shape (n_dofs,), optional
        To the ground, which hold as supports do.
    """
    if not surface.part.any():
        return None
    parts = _Parts.of(surface)
    if not len(parts.joint):
        return None
    rows = parts.constraints(free if springs is None else free[springs == 0.0])
    unresisted = _null_space((rows.T @ rows).tocsr())
    count = unresisted.shape[1] - rigid.shape[1]
    if count <= 0:
        return None
    null = unresisted.shape[1]
    each = unresisted.reshape(-1, 6, null)
    at_nodes = parts.motions_at(np.arange(len(parts.owner)), parts.owner) @ each[parts.owner]
    motions = at_nodes.reshape(-1, null)[free]
    motions -= rigid @ (rigid.T @ (M @ motions))
    size, y = np.linalg.eigh(motions.T @ (M @ motions))
    y = y[:, -count:] / np.sqrt(size[-count:])
    turns = each[:, 3:] / parts.size[:, None, None]
    return Mechanism(motions @ y, parts, turns @ y)


def _null_space(gram: sp.csr_array) -> FloatArray:
    """Return a basis of the null space, however large, of a positive semidefinite matrix."""
    n = gram.shape[0]
    size = np.sqrt(gram.diagonal())
    scale = sp.diags_array(1.0 / np.where(size > 0.0, size, 1.0))
    scaled, wanted = (scale @ gram @ scale).tocsr(), min(n, _FIRST_BLOCK)
    while True:
        values, x = lowest(scaled, sp.eye_array(n, format="csr"), wanted)
        null = values <= _UNRESISTED
        if not null.all() or wanted == n:
            return np.asarray(scale @ x[:, null])
        wanted = min(n, 4 * wanted)


def mechanism_in(motion: FloatArray, K: Any, M: Any, rigid: FloatArray) -> Mechanism | None:
    """Return what a motion from `motion_without_force` has beside the rigid ones, if anything.

    Parameters
    ----------
    motion : ndarray, shape (n_dofs,)
    K, M : scipy.sparse.csr_array, shape (n_dofs, n_dofs)
    rigid : ndarray, shape (n_dofs, r)
        M-orthonormal.
    """
    found = m_orthonormal(rigid, motion[:, None], M)
    if not found.size or np.linalg.norm(K @ found) > ROUNDING * np.linalg.norm(
        abs(K) @ np.abs(found)
    ):
        return None
    return Mechanism(found)


@dataclass(frozen=True, eq=False)
class _Parts:
    """The parts that hang together by whole sides, and the nodes where they meet without one.

    Attributes
    ----------
    part : ndarray of int, shape (n_cells,)
        Of each element.
    owner : ndarray of int, shape (n_nodes,)
        A part that each node is in.
    joint, one, other : ndarrays of int, shape (n_links,)
        Nodes in more than one part, and two parts that each is in: a chain through all of them.
    centre, size : ndarrays, shapes (n_parts, 3) and (n_parts,)
        m.
    """

    surface: Surface
    part: IntArray
    owner: IntArray
    joint: IntArray
    one: IntArray
    other: IntArray
    centre: FloatArray
    size: FloatArray

    @classmethod
    def of(cls, surface: Surface) -> _Parts:
        mesh, part = surface.mesh, surface.part
        owner = np.empty(mesh.n_nodes, dtype=np.int64)
        owner[mesh.cells] = part[:, None]
        shared = np.zeros(mesh.n_nodes, dtype=bool)
        shared[mesh.cells[owner[mesh.cells] != part[:, None]]] = True
        count = int(part.max()) + 1
        cell, local = np.nonzero(shared[mesh.cells])
        node, of_node = np.divmod(np.unique(mesh.cells[cell, local] * count + part[cell]), count)
        link = np.flatnonzero(node[1:] == node[:-1])
        where = mesh.nodes[mesh.cells].mean(axis=1)
        members = np.bincount(part)
        centre = _sums(part, where) / members[:, None]
        spread = mesh.nodes[mesh.cells] - centre[part][:, None]
        size = np.sqrt(_sums(part, (spread**2).mean(axis=1)).sum(axis=1) / members)
        return cls(surface, part, owner, node[link], of_node[link], of_node[link + 1], centre, size)

    def constraints(self, free: IntArray) -> sp.csr_array:
        """Constraints by shared nodes and supports: rows on the motions, shape (any, 6 n_parts).

        The motions are translations and rotations about the parts' own middles.
        """
        fixed_dofs = np.setdiff1d(np.arange(3 * len(self.owner)), free)
        node, component = np.divmod(fixed_dofs, 3)
        fixed = self.motions_at(node, self.owner[node])[np.arange(len(fixed_dofs)), component]
        joints = [self.motions_at(self.joint, side) for side in (self.one, self.other)]
        values = np.concatenate([fixed, joints[0].reshape(-1, 6), -joints[1].reshape(-1, 6)])
        links = len(fixed_dofs) + np.arange(3 * len(self.joint))
        row = np.concatenate([np.arange(len(fixed_dofs)), links, links])
        part = np.concatenate([self.owner[node], np.repeat(self.one, 3), np.repeat(self.other, 3)])
        column = 6 * part[:, None] + np.arange(6)
        shape = (len(fixed_dofs) + 3 * len(self.joint), 6 * len(self.size))
        return sp.csr_array((values.ravel(), (np.repeat(row, 6), column.ravel())), shape=shape)

    def motions_at(self, node: IntArray, part: IntArray) -> FloatArray:
        """The motions of parts at nodes, shape (n, 3, 6)."""
        offset = self.surface.mesh.nodes[node] - self.centre[part]
        return motions_at(offset / self.size[part][:, None])


def _sums(part: IntArray, values: FloatArray) -> FloatArray:
    return np.stack([np.bincount(part, weights=column) for column in values.T], axis=1)
