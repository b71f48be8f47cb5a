"""Normals of surface elements: the same side for all that are joined edge by edge."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import FloatArray, IntArray
from .surface import SHARP


def against_neighbours(
    nodes: FloatArray, groups: Sequence[IntArray]
) -> list[npt.NDArray[np.bool_]]:
    """Return which elements lie the other way round than most of those they are joined with.

    Elements are joined by edges that belong to two of them. At an edge of more, as of a stiffener
    on a skin, two are joined that go on straight, by less than 45°; others keep their own side.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        m.
    groups : sequence of ndarray of int, shape (n, 3) or (n, 4)
        Nodes of elements in turn.
    """
    if not groups:
        return []
    first = np.cumsum([0, *map(len, groups)])
    n, ends = int(first[-1]), [np.stack([g, np.roll(g, -1, axis=1)], axis=2) for g in groups]
    edge = np.concatenate([each.reshape(-1, 2) for each in ends])
    owner = np.concatenate(
        [np.repeat(first[i] + np.arange(len(g)), g.shape[1]) for i, g in enumerate(groups)]
    )
    forward = edge[:, 0] < edge[:, 1]
    _, number, count = np.unique(
        np.sort(edge, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    number = number.reshape(-1)
    order = np.argsort(number, kind="stable")
    several = order[count[number[order]] > 2]
    order = order[count[number[order]] == 2]
    pairs = np.stack([order[::2], order[1::2]])
    if len(several):
        middle = np.concatenate([nodes[g].mean(axis=1) for g in groups])[owner[several]]
        pairs = np.hstack(
            [pairs, several[_going_on(nodes[edge[several]], middle, number[several])]]
        )
    one, other = pairs
    alike = forward[one] != forward[other]
    # Elements are nodes of a graph and every one is there twice, as it is and turned: components of
    # this graph say which agree. A surface with one side only, as of Möbius, has a single one.
    row = np.concatenate([owner[one], owner[one] + n])
    column = np.where(np.tile(alike, 2), 0, n) + np.tile(owner[other], 2)
    column[len(one) :] = np.where(alike, owner[other] + n, owner[other])
    links: Any = sp.coo_array((np.ones(len(row)), (row, column)), shape=(2 * n, 2 * n))
    part = sp.csgraph.connected_components(links, directed=False)[1]
    as_is, turned = part[:n], part[n:]
    # A surface has two sides: take the one that turns fewer elements.
    low = np.minimum(as_is, turned)
    balance = np.bincount(low, np.sign(turned - as_is), minlength=len(part))
    flipped = np.where(balance[low] >= 0.0, as_is > turned, as_is < turned)
    return np.split(flipped, first[1:-1])


def _going_on(ends: FloatArray, middle: FloatArray, number: IntArray) -> IntArray:
    """Return the pairs of elements, shape (2, any), that go on straight at edges of several.

    Parameters
    ----------
    ends : ndarray, shape (n, 2, 3)
        Ends of the edge of each element, m.
    middle : ndarray, shape (n, 3)
        Centre of the element, m.
    number : ndarray of int, shape (n,)
        Number of the edge, ascending.
    """
    along = ends[:, 1] - ends[:, 0]
    away = middle - ends[:, 0]
    with np.errstate(invalid="ignore", divide="ignore"):  # collapsed elements go on nowhere
        share = np.einsum("ni,ni->n", away, along) / np.einsum("ni,ni->n", along, along)
        away -= share[:, None] * along
        away /= np.linalg.norm(away, axis=1, keepdims=True)
    found = []
    for apart in range(1, int(np.bincount(np.unique(number, return_inverse=True)[1]).max())):
        one = np.arange(len(number) - apart)
        straight = np.einsum("ni,ni->n", away[one], away[one + apart]) < -SHARP
        one = one[(number[one] == number[one + apart]) & straight]
        found.append(np.stack([one, one + apart]))
    pairs = np.hstack(found)
    alone = np.bincount(pairs.ravel(), minlength=len(number)) == 1
    return pairs[:, alone[pairs].all(axis=0)]
