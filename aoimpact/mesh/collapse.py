"""Elements with repeated nodes, as the wedges, pyramids and tetrahedra that they are.

Programs without elements of these shapes write them as bricks of which edges have no length. What
is integrated on such a brick is right, but its sides are not those of the body.
"""

from __future__ import annotations

from functools import cache
from itertools import permutations

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, IntArray
from .elements import ReferenceElement, reference_element, reference_faces

__all__ = ["Solids", "collapse", "edges_of"]

# Elements of one kind: the kind, their nodes, and their numbers among the cells of the file.
Solids = tuple[str, IntArray, IntArray]

# What elements of a number of distinct corners may be.
_SHAPES = {4: ("tetra", "tetra10"), 5: ("pyramid", "pyramid13"), 6: ("wedge", "wedge15")}


def collapse(kind: str, cells: IntArray, numbers: IntArray) -> tuple[list[Solids], IntArray]:
    """Return elements with those that repeat corners as what they are.

    Parameters
    ----------
    kind : str
    cells : ndarray of int, shape (n, nodes per cell)
    numbers : ndarray of int, shape (n,)

    Returns
    -------
    list of Solids
        Those that repeat nothing first.
    ndarray of int
        Rows of the elements that are no solid of another kind.
    """
    element = reference_element(kind)
    corners = cells[:, : element.n_corners]
    first = (corners[:, :, None] == corners[:, None, :]).argmax(axis=2)
    repeats = (first != np.arange(element.n_corners)).any(axis=1)
    found: list[Solids] = []
    if not repeats.all():
        found.append((kind, cells[~repeats], numbers[~repeats]))
    wrong = [np.zeros(0, np.int64)]
    for pattern in np.unique(first[repeats], axis=0):
        rows = np.flatnonzero((first == pattern).all(axis=1))
        plan = _plan(kind, tuple(pattern.tolist()))
        if plan is None:
            wrong.append(rows)
            continue
        target, order, same = plan
        of = cells[rows]
        alike = np.ones(len(rows), dtype=bool)
        for one, other in same:
            alike &= of[:, one] == of[:, other]
        wrong.append(rows[~alike])
        found.append((target, of[alike][:, order], numbers[rows[alike]]))
    return found, np.sort(np.concatenate(wrong))


# A kind, the order of its nodes, and pairs of nodes that must be the same.
_Plan = tuple[str, list[int], list[tuple[int, int]]]


@cache
def _plan(kind: str, pattern: tuple[int, ...]) -> _Plan | None:
    """Say what an element is of whose corners some are others, as `pattern` says."""
    element = reference_element(kind)
    if len(element.nodes) == 27:  # nodes within collapsed sides have no place in other kinds
        return None
    distinct = sorted(set(pattern))
    linear, quadratic = _SHAPES.get(len(distinct), ("", ""))
    sides = []
    for face in reference_faces(element.cell.linear):
        around = [pattern[node] for node in face.nodes[: face.n_corners]]
        corners = [around[i] for i in range(len(around)) if around[i] != around[i - 1]]
        if len(set(corners)) < len(corners):  # folded
            return None
        if len(corners) > 2:
            sides.append(frozenset(corners))
    if not linear or len(set(sides)) < len(sides):
        return None
    places = np.stack(
        [
            element.cell.corners[[p == corner for p in pattern]].mean(axis=0)
            for corner in range(element.n_corners)
            if corner in distinct
        ]
    )
    order = _corners(linear, distinct, set(sides), places)
    if order is None or not element.quadratic:
        return None if order is None else (linear, order, [])
    middles: dict[frozenset[int], list[int]] = {}
    for i, ends in enumerate(edges_of(element).tolist(), element.n_corners):
        middles.setdefault(frozenset(pattern[end] for end in ends), []).append(i)
    same = [(nodes[0], other) for nodes in middles.values() for other in nodes[1:]]
    same += [(*ends, nodes[0]) for ends, nodes in middles.items() if len(ends) == 1]  # type: ignore[misc]
    edges = edges_of(reference_element(quadratic)).tolist()
    order = order + [middles[frozenset(order[end] for end in ends)][0] for ends in edges]
    return quadratic, order, same


def _corners(
    kind: str, distinct: list[int], sides: set[frozenset[int]], places: FloatArray
) -> list[int] | None:
    """Return the order of corners that makes an element of these sides, right-handed."""
    element = reference_element(kind)
    faces = [face.nodes[: face.n_corners] for face in reference_faces(kind)]
    middle = element.gradient(element.cell.corners.mean(axis=0, keepdims=True))[0]
    for order in permutations(range(len(distinct))):
        fits = {frozenset(distinct[order[n]] for n in face) for face in faces} == sides
        if fits and np.linalg.det(places[list(order)].T @ middle) > 0.0:
            return [distinct[i] for i in order]
    return None


def edges_of(element: ReferenceElement) -> npt.NDArray[np.int64]:
    """Return the corners at both ends of the edges on which nodes lie, shape (n_edges, 2)."""
    weights = element.linear.shape(element.nodes[element.n_corners :])
    on_edge = (weights > 1e-12).sum(axis=1) == 2
    found: IntArray = np.nonzero(weights[on_edge] > 1e-12)[1].reshape(-1, 2)
    return found
