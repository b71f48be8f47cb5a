"""Nested dissection: elimination order of a sparse matrix, and the estimated cost of its factors.

George, SIAM J. Numer. Anal. 10 (1973): a separator cuts the body in two and is eliminated after
both halves, which are cut in the same way. Each cut is across the longest side, at the median.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base import BoolArray, FloatArray, IntArray, sp

# Number of nodes up to which a part is not cut.
_LEAF = 64


class Fill(NamedTuple):
    """Estimate of the factors L Lᵀ of a sparse matrix.

    Attributes
    ----------
    entries : float
        Number of entries of L.
    operations : float
        Number of multiplications of the factorisation.
    """

    entries: float
    operations: float


def fill(matrix: Any, places: FloatArray | None = None) -> Fill:
    """Estimate the factors of a symmetric matrix by nested dissection of a box.

    The middle cross-sections of the box have as many rows as those of the body, s₁, s₂, s₃. Each
    cut, across the longest side, has the smallest cross-section as separator and halves the other
    two. A separator of s rows, in a part bordered by r rows of earlier separators, adds s²/2 + s r
    entries and s³/3 + s² r + s r² multiplications. After k cuts along an axis, a part has on
    average 2 - 2^(1-k) separators as faces normal to the axis. On balls, cubes, plates, sheets and
    bars of 20 000 to 120 000 dofs, actual dissection has 0.6 to 1.1 times the estimated numbers.

    Parameters
    ----------
    matrix : scipy.sparse matrix, shape (n, n)
    places : ndarray, shape (n, 3), optional
        Coordinates of the rows. If left out, the order of Cuthill and McKee gives one
        cross-section, and the other two are those of a square bar with three rows per node.
    """
    n, pieces, cuts = float(matrix.shape[0]), 1.0, np.zeros(3)
    if places is None:
        along = np.empty(matrix.shape[0])
        along[sp.csgraph.reverse_cuthill_mckee(matrix.tocsr(), symmetric_mode=True)] = np.arange(n)
        first = max(1.0, _cross_section(matrix, along))
        sections = np.array([first, n * (3.0 / first) ** 0.5, n * (3.0 / first) ** 0.5])
    else:
        sections = np.array([_cross_section(matrix, along) for along in places.T])
    entries = operations = 0.0
    while True:
        around = float((2.0 - 2.0 * 0.5**cuts) @ sections)
        axis = int(sections.argmin())
        is_leaf = n / pieces <= 3 * _LEAF
        s = n / pieces if is_leaf else float(sections[axis])
        entries += pieces * (s * s / 2 + s * around)
        operations += pieces * (s**3 / 3 + s * s * around + s * around * around)
        if is_leaf:
            return Fill(entries, operations)
        sections[np.arange(3) != axis] *= 0.5
        cuts[axis] += 1.0
        pieces *= 2.0


def _cross_section(matrix: Any, along: FloatArray) -> float:
    """Return the size of a separator at the median of `along`, or n if `along` is constant."""
    below = _below(along[:, None])
    mark = 1.0 + np.random.default_rng(0).random(len(below))  # random: no sums cancel
    up = np.count_nonzero((matrix @ (mark * below))[~below])
    down = np.count_nonzero((matrix @ (mark * ~below))[below])
    return float(min(up, down)) if np.ptp(along) > 0.0 else float(len(along))


def nested_dissection(matrix: Any, places: FloatArray) -> IntArray:
    """Return the rows of a symmetric matrix in order of elimination, the rows of a node together.

    Parameters
    ----------
    matrix : scipy.sparse.csr_array or csc_array, shape (n, n)
    places : ndarray, shape (n, 3)
        Coordinates of the rows.
    """
    node, graph = _nodes(matrix)
    order: list[IntArray] = []
    first = np.flatnonzero(np.diff(node, prepend=-1))
    _cut(graph, places[first], np.arange(len(first)), np.zeros(len(first), np.float32), order)
    place = np.empty(len(first), dtype=np.int64)
    place[np.concatenate(order)] = np.arange(len(first))
    # Uncoupled pieces, such as stretching and bending of a flat sheet, are put one after the other:
    # SuperLU forms supernodes only of adjacent columns.
    piece = sp.csgraph.connected_components(graph, directed=False)[1]
    return np.lexsort((place[node], piece[node]))


def _nodes(matrix: Any) -> tuple[IntArray, Any]:
    """Return each row's node and the graph of nodes; adjacent rows of equal pattern form a node."""
    pattern = _graph(matrix.indices, matrix.indptr)
    mark = pattern @ np.random.default_rng(0).random(pattern.shape[0])
    node = np.cumsum(np.diff(mark, prepend=-1.0) != 0.0) - 1
    rows = pattern[np.flatnonzero(np.diff(node, prepend=-1))]
    return node, _graph(node[rows.indices], rows.indptr)


def _graph(columns: Any, starts: Any) -> Any:
    n = len(starts) - 1
    graph = sp.csr_array((np.ones(len(columns), dtype=np.float32), columns, starts), shape=(n, n))
    graph.sum_duplicates()
    return graph


def _cut(
    graph: Any, places: FloatArray, nodes: IntArray, is_in: FloatArray, order: list[IntArray]
) -> None:
    """Append `nodes` to `order`: two halves, each cut recursively, then their separator."""
    if len(nodes) <= _LEAF:
        order.append(nodes)
        return
    rows, below = graph[nodes], _below(places[nodes])
    is_in[nodes[below]] = 1.0
    touches_below = ~below & (rows @ is_in > 0.0)
    is_in[nodes] = ~below
    touches_above = below & (rows @ is_in > 0.0)
    is_in[nodes] = 0.0
    between = min(touches_below, touches_above, key=np.count_nonzero)
    for half in (nodes[below & ~between], nodes[~below & ~between]):
        if len(half):
            _cut(graph, places, half, is_in, order)
    order.append(nodes[between])


def _below(places: FloatArray) -> BoolArray:
    """Return which nodes lie below the median along the longest side of their bounding box."""
    along = places[:, np.ptp(places, axis=0).argmax()]
    middle = np.partition(along, len(along) // 2)[len(along) // 2]
    below: BoolArray = along < middle
    if not below.any():
        below = along <= middle
    return below if not below.all() else np.arange(len(along)) < len(along) // 2
