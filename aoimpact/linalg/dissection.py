"""Nested dissection: the order of elimination of a sparse matrix, and how much its factors cost.

George, SIAM J. Numer. Anal. 10 (1973): a separator cuts the body in two and is eliminated after
both halves, which are cut likewise. Each cut is across the longest side, at the median.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import FloatArray, IntArray

# Nodes of a part that is not cut further.
_LEAF = 64

# Multiplications of all separators over those of the first one, at least.
_LEAST_RATIO = 10.0

# Distances in the graph, from as many places, stand for coordinates that are not known.
_ENDS = 3


@dataclass(frozen=True, eq=False)
class Dissection:
    """An order of elimination and its cost.

    Attributes
    ----------
    order : ndarray of int, shape (n,)
        Rows of the matrix in the order of elimination.
    separator : float
        Rows of the first separator.
    entries : float
        Entries of L, where parts that are not cut further count as dense.
    operations : float
        Multiplications of the factorisation.
    """

    order: IntArray
    separator: float
    entries: float
    operations: float


def nested_dissection(matrix: Any, places: FloatArray | None = None) -> Dissection:
    """Order the rows of a symmetric matrix, those of a node together.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array, csc_array or bsr_array, shape (n, n)
    places : ndarray, shape (n, 3), optional
        Coordinates of the rows; distances in the matrix's graph if left out.
    """
    node, parts = _parts(matrix, places)
    count = int(node[-1]) + 1
    parts.cut(np.arange(count))
    place = np.empty(count, dtype=np.int64)
    place[np.concatenate(parts.order)] = np.arange(count)
    size = len(node) / count
    # SuperLU joins columns that follow each other. Pieces that share no entries, such as stretching
    # and bending of a flat sheet, would come between each other's.
    piece = sp.csgraph.connected_components(parts.graph, directed=False)[1]
    return Dissection(
        np.lexsort((place[node], piece[node])),
        size * len(parts.order[-1]),
        size**2 * parts.entries,
        size**3 * parts.operations,
    )


def first_cut(matrix: Any, places: FloatArray | None = None) -> Dissection:
    """Return the first separator, and the least that the whole dissection may cost.

    Of s rows it takes s³/3 multiplications, a 17th of all in cubes and balls, less in other bodies.
    """
    node, parts = _parts(matrix, places)
    count = int(node[-1]) + 1
    s = len(parts.halves(np.arange(count))[1]) * len(node) / count
    return Dissection(np.arange(0), s, s**2 / 2, _LEAST_RATIO * s**3 / 3)


def _parts(matrix: Any, places: FloatArray | None) -> tuple[IntArray, _Parts]:
    node, graph = _nodes(matrix)
    first = np.flatnonzero(np.diff(node, prepend=-1))
    return node, _Parts(graph, _distances(graph) if places is None else places[first])


def _nodes(matrix: Any) -> tuple[IntArray, Any]:
    """Return the node of each row, and which nodes share entries: rows of one pattern are one."""
    if matrix.format == "bsr":
        node = np.repeat(np.arange(len(matrix.indptr) - 1), matrix.blocksize[0])
        return node, _graph(matrix.indices, matrix.indptr)
    pattern = _graph(matrix.indices, matrix.indptr)
    mark = pattern @ np.random.default_rng(0).random(pattern.shape[0])
    node = np.cumsum(np.diff(mark, prepend=-1.0) != 0.0) - 1
    rows = pattern[np.flatnonzero(np.diff(node, prepend=-1))]
    return node, _graph(node[rows.indices], rows.indptr)


class _Parts:
    """The recursion, over the nodes of a graph."""

    def __init__(self, graph: Any, places: FloatArray) -> None:
        self.graph, self.places = graph, places
        self.order: list[IntArray] = []
        self.entries, self.operations = 0.0, 0.0
        self._is_in = np.zeros(len(places), dtype=np.float32)

    def cut(self, nodes: IntArray) -> None:
        """Append these nodes, a part that separators surround, to the order."""
        around, separator, halves = self.halves(nodes)
        for half in halves:
            self.cut(half)
        self.order.append(separator)
        s, r = float(len(separator)), float(around)
        self.entries += s * s / 2 + s * r
        self.operations += s**3 / 3 + s * s * r + s * r * r

    def halves(self, nodes: IntArray) -> tuple[int, IntArray, list[IntArray]]:
        """Return how many nodes surround a part, its separator, and what that leaves of it."""
        rows, is_in = self.graph[nodes], self._is_in
        is_in[nodes] = 1.0
        around = len(np.unique(rows.indices[is_in[rows.indices] == 0.0]))
        is_in[nodes] = 0.0
        if len(nodes) <= _LEAF:
            return around, nodes, []
        below = _below(self.places[nodes])
        is_in[nodes[below]] = 1.0
        touches_below = ~below & (rows @ is_in > 0.0)
        is_in[nodes] = ~below
        touches_above = below & (rows @ is_in > 0.0)
        is_in[nodes] = 0.0
        between = min(touches_below, touches_above, key=np.count_nonzero)
        halves = [nodes[below & ~between], nodes[~below & ~between]]
        return around, nodes[between], [half for half in halves if len(half)]


def _below(places: FloatArray) -> npt.NDArray[np.bool_]:
    """The half of some nodes that is below the median along their longest side."""
    along = places[:, np.ptp(places, axis=0).argmax()]
    middle = np.partition(along, len(along) // 2)[len(along) // 2]
    below: npt.NDArray[np.bool_] = along < middle
    if not below.any():
        below = along <= middle
    return below if not below.all() else np.arange(len(along)) < len(along) // 2


def _graph(columns: Any, starts: Any) -> Any:
    n = len(starts) - 1
    graph = sp.csr_array((np.ones(len(columns), dtype=np.float32), columns, starts), shape=(n, n))
    graph.sum_duplicates()
    return graph


def _distances(graph: Any) -> FloatArray:
    """Return the distances of each node from ends of the graph that are far apart, shape (n, 3)."""
    count, piece = sp.csgraph.connected_components(graph, directed=False)
    if count > 1:  # pieces are put in a row
        first = np.unique(piece, return_index=True)[1]
        links = (np.ones(count - 1, dtype=np.float32), (first[:-1], first[1:]))
        graph = sp.csr_array(graph + sp.csr_array(links, shape=graph.shape))
        graph = sp.csr_array(graph + graph.T)
    found = [_distance(graph, int(np.argmax(_distance(graph, 0))))]
    while len(found) < _ENDS:
        found.append(_distance(graph, int(np.argmax(np.min(found, axis=0)))))
    return np.stack(found, axis=1)


def _distance(graph: Any, start: int) -> FloatArray:
    """Return how many steps each node is away from one."""
    order, before = sp.csgraph.breadth_first_order(graph, start)
    place = np.empty(len(before), dtype=np.int64)
    place[order] = np.arange(len(order))
    reached_from = place[before[order[1:]]]  # ascending
    ends = [0, 1]
    while ends[-1] < len(order):
        ends.append(1 + int(np.searchsorted(reached_from, ends[-1])))
    distance = np.empty(len(before))
    distance[order] = np.repeat(np.arange(len(ends) - 1.0), np.diff(ends))
    return distance
