"""Normals of surface elements: the same side for all that are joined edge by edge."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import IntArray


def against_neighbours(groups: Sequence[IntArray]) -> list[npt.NDArray[np.bool_]]:
    """Return which elements lie the other way round than most of those they are joined with.

    Elements are joined by edges that belong to two of them. At an edge of three, as of a stiffener
    on a skin, each surface keeps its own side.

    Parameters
    ----------
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
    order = np.argsort(number.reshape(-1), kind="stable")
    order = order[count[number.reshape(-1)[order]] == 2]
    one, other = order[::2], order[1::2]
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
