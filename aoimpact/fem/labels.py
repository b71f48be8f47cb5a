"""Labels of the rows of K: node number and component in the program that wrote K."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from ..base import FloatArray, InputError, IntArray, integers, node_ids, plain

# Largest component: 1, 2, 3 are displacements, 4, 5, 6 rotations; 0 has no direction.
_MOST = 6

# Rounding of coordinates in input files, relative to the body's size.
SAME_PLACE = 1e-5


def checked_labels(labels: Any, n_dofs: int) -> IntArray | None:
    """Return the labels, node and component 0 … 6, as distinct integer pairs, shape (n_dofs, 2).

    Raises
    ------
    InputTypeError, InputError
    """
    if labels is None:
        return None
    what = "pairs of integers, node and component"
    pairs = integers("labels", labels, what, shape=(n_dofs, 2))
    wrong = np.flatnonzero((pairs[:, 1] < 0) | (pairs[:, 1] > _MOST))
    if len(wrong):
        which = f"labels[{wrong[0]}] has component {pairs[wrong[0], 1]}"
        raise InputError(f"{which}, must be 1-3 (displacement), 4-6 (rotation) or 0 (neither)")
    order = np.lexsort(pairs.T)
    twice = np.flatnonzero((np.diff(pairs[order], axis=0) == 0).all(axis=1))
    if len(twice):
        first, second = sorted(order[twice[0] : twice[0] + 2].tolist())
        node, component = pairs[first]
        raise InputError(f"labels: rows {first} and {second} are both dof {node}.{component}")
    return pairs


def axes_of(free: IntArray | None, labels: IntArray | None, n_nodes: int) -> FloatArray | None:
    """Return unit translations along x, y, z, (n_dofs, 3); None without `free` and labels."""
    if free is not None:
        return np.where(free[:, None] < 3 * n_nodes, np.eye(3)[free % 3], 0.0)
    if labels is None:
        return None
    component = labels[:, 1]
    return np.where(component[:, None] == np.arange(1, 4), 1.0, 0.0)


def nodes_by_number(name: str, given: Any, count: int, labels: IntArray | None) -> IntArray:
    """Return the indices of the nodes with the given labels, or indices if there are no labels.

    Parameters
    ----------
    name : str
        Name of the argument, for messages.
    given : int or array_like of int
        Labels or, if `labels` is None, indices.
    count : int
        Number of nodes.
    labels : ndarray of int, shape (count,), or None
        Label of each node.

    Returns
    -------
    ndarray of int
        Distinct indices from 0, ascending.

    Raises
    ------
    InputTypeError, InputError
        If a number belongs to no node, or to several.
    """
    if labels is None:
        return node_ids(name, given, count)
    wanted = node_ids(name, given, None)
    order = np.argsort(labels, kind="stable")
    first = np.searchsorted(labels, wanted, sorter=order)
    after = np.searchsorted(labels, wanted, side="right", sorter=order)
    if (first == after).any():
        raise missing_node(name, labels, int(wanted[first == after][0]))
    several = after - first > 1
    if several.any():
        at = int(np.flatnonzero(several)[0])
        raise InputError(f"{name}: several nodes have the number {wanted[at]}; take a node set")
    return np.sort(order[first])


def label_of(node: int, labels: IntArray | None) -> int:
    """Return the label of a node, or its index if it has none."""
    return node if labels is None or labels[node] < 0 else int(labels[node])


def labelled_rows(labels: IntArray, node: int) -> IntArray:
    """Return the rows of K that belong to a node's displacements.

    Raises
    ------
    InputError
        If there is no such row.
    """
    rows = np.flatnonzero((labels[:, 0] == node) & (labels[:, 1] >= 1) & (labels[:, 1] <= 3))
    if not len(rows):
        raise missing_node("node", np.append(labels[:, 0], -1), node)
    return rows


def node_numbers(nodes: FloatArray, which: IntArray, of_mesh: FloatArray, size: float) -> IntArray:
    """Return the index of the mesh node at the place of each node `which` of a body.

    Raises
    ------
    InputError
        If there is no mesh node at the place of a node, or two nodes share a mesh node.
    """
    gap, found = scipy.spatial.cKDTree(of_mesh).query(nodes[which])
    if gap.max() > SAME_PLACE * size:
        worst = int(which[gap.argmax()])
        far = f"at {plain(nodes[worst])} m, is {gap.max():.3g} m from the nearest of the mesh"
        raise InputError(
            f"mesh: node {worst} of the body, {far}: are both in metres, of one model?"
        )
    if len(np.unique(found)) < len(np.unique(which)):
        raise InputError("mesh: each node of the body needs its own, but two lie at the same one")
    return np.asarray(found, dtype=np.int64)


def missing_node(name: str, labels: IntArray, node: int) -> InputError:
    """Return the error for an unknown label; a label of -1 means a node without a row in K."""
    known = np.unique(labels[labels > 0])
    if not len(known):
        return InputError(f"{name} {node}: no row of K is labelled with a node")
    near = known[np.abs(known - node).argmin()]
    held = " with a row in K, supports may hold it" if (labels < 0).any() else ""
    run = f"the {len(known)} labelled nodes run from {known[0]} to {known[-1]}"
    return InputError(f"{name}: there is no node {node}{held}; {run}, the nearest number is {near}")
