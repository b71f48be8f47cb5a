"""Consistent orientation of surface elements that are joined edge by edge."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..base import BoolArray, FloatArray, IntArray, sp
from .surface import SHARP
from .vectors import dot, unit


def against_neighbours(nodes: FloatArray, groups: Sequence[IntArray]) -> list[BoolArray]:
    """Return which elements are oriented against the majority of the surface they belong to.

    Elements are joined at an edge that two of them share. At an edge of three or more, as between
    a skin and a stiffener, two elements are joined if they continue each other within 45°; all
    others there are not joined.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates, m.
    groups : sequence of ndarray of int, shape (n, 3) or (n, 4)
        Corner nodes of the elements, around each.

    Returns
    -------
    list of ndarray of bool
        For each group, True for elements to be turned over.
    """
    if not groups:
        return []
    edge, number, _, away = sides(nodes, groups)
    forward, size = edge[:, 0] < edge[:, 1], np.linalg.norm(away, axis=1)
    owner = np.repeat(
        np.arange(sum(map(len, groups))),
        np.concatenate([np.full(len(g), g.shape[1]) for g in groups]),
    )
    n = int(owner[-1]) + 1
    one, other = np.hstack([np.stack(some) for some in pairs(number)])
    # An element collapsed to a line (`away` = 0) continues no other element.
    straight = dot(away[one], away[other]) < -SHARP * size[one] * size[other]
    some = (np.bincount(number)[number[one]] == 2) | straight
    alone = np.bincount(one[some], minlength=len(number)) == 1
    some &= alone[one] & alone[other]
    one, other = one[some], other[some]
    alike = forward[one] != forward[other]
    # Each element is two nodes of a graph: as it is, and turned over. Elements of consistent
    # orientation form a connected component. A one-sided surface, such as a Möbius strip, has a
    # single component.
    row = np.concatenate([owner[one], owner[one] + n])
    column = np.where(np.tile(alike, 2), 0, n) + np.tile(owner[other], 2)
    column[len(one) :] = np.where(alike, owner[other] + n, owner[other])
    links: Any = sp.coo_array((np.ones(len(row)), (row, column)), shape=(2 * n, 2 * n))
    part = sp.csgraph.connected_components(links, directed=False)[1]
    as_is, turned = part[:n], part[n:]
    # Of the two orientations of a surface, take the one that turns fewer elements.
    low = np.minimum(as_is, turned)
    balance = np.bincount(low, np.sign(turned - as_is), minlength=len(part))
    flipped = np.where(balance[low] >= 0.0, as_is > turned, as_is < turned)
    return np.split(flipped, np.cumsum([*map(len, groups)])[:-1])


def sides(
    nodes: FloatArray, groups: Sequence[IntArray]
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Return the sides of all surface elements, one element after the other, n in all.

    Returns
    -------
    ends : ndarray of int, shape (n, 2)
        End nodes of each side, in the order of the element.
    number : ndarray of int, shape (n,)
        Number of the edge: sides of adjacent elements have the same number.
    inside : ndarray, shape (n, 3)
        Vector from the first end to the middle of the element, m.
    away : ndarray, shape (n, 3)
        Component of `inside` normal to the side, m.
    """
    ends = np.concatenate(
        [np.stack([of, np.roll(of, -1, axis=1)], axis=2).reshape(-1, 2) for of in groups]
    )
    number = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    middle = [np.repeat(nodes[of].mean(axis=1), of.shape[1], axis=0) for of in groups]
    inside, along = np.concatenate(middle) - nodes[ends[:, 0]], unit(np.diff(nodes[ends], axis=1))
    return ends, number, inside, inside - dot(inside, along[:, 0])[:, None] * along[:, 0]


def pairs(key: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield all ordered pairs of entries with equal keys, as pairs of index arrays.

    No index occurs twice in an array.
    """
    order = np.argsort(key, kind="stable")
    for step in range(1, max(2, int(np.bincount(key).max()))):  # without pairs, yield empty arrays
        first = np.flatnonzero(key[order[step:]] == key[order[:-step]])
        yield order[first], order[first + step]
        yield order[first + step], order[first]
