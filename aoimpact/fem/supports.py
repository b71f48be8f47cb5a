"""Supports: which degrees of freedom of a mesh are constrained."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, InputError, InputTypeError, IntArray, called, nearest, warn
from ..mesh import Mesh, open_edges
from .labels import nodes_by_number

Selector = str | Callable[[FloatArray], npt.ArrayLike] | npt.ArrayLike
Support = tuple[Selector, str] | tuple[Selector, str, str]


def constrained(free: IntArray, n_nodes: int) -> npt.NDArray[np.bool_]:
    """Return True for each component of a node that a support holds, shape (n_nodes, 3)."""
    mask = np.ones(3 * n_nodes, dtype=bool)
    mask[free[free < len(mask)]] = False
    return mask.reshape(-1, 3)


def free_dofs(mesh: Mesh, fixed: Sequence[Support] | None) -> IntArray:
    """Return the dofs that no support holds, ascending; see `dofs`.

    Parameters
    ----------
    mesh : Mesh
    fixed : sequence of (nodes, letters) or (nodes, letters, letters)
        The nodes by number, by the name of a set, or by a function of all coordinates that returns
        one bool for each; the letters, of "x", "y" and "z", say which displacements are
        constrained, and the second ones which rotations about these axes. With rotations the first
        letters may be "".

    Raises
    ------
    InputError, InputTypeError
        If an entry selects nothing, names an unknown set or letter, or nothing is left free.
    """
    left = np.zeros((2, mesh.n_nodes, 3), dtype=bool)
    left[0], left[1, mesh.thin_nodes] = True, True
    how = (
        'give a list such as [("xmin", "xyz"), ([0, 7], "z")], of shells and beams also '
        '("rim", "xyz", "xyz"), or ("rim", "", "xyz"), to hold rotations'
    )
    for name, (selector, *letters) in entries("fixed", fixed, (2, 3), how):
        wanted = [
            [] if each == "" and (place, len(letters)) == (0, 2) else components(name, each)
            for place, each in enumerate(letters)
        ]
        selected = nodes_of_mesh(name, selector, mesh)
        if len(letters) == 2 and not np.isin(selected, mesh.thin_nodes).any():
            raise InputError(
                f"{name}: letters of rotations are for shells and beams, none of which has "
                "these nodes; give the displacements alone"
            )
        for which, axes in enumerate(wanted):
            left[which, selected[:, None], axes] = False
    if not left.any():
        raise InputError("fixed holds every dof of the body; leave some free to move")
    return np.flatnonzero(left)


def entries(
    name: str, given: Any, lengths: tuple[int, ...], how: str, alone: Any = ()
) -> Iterator[tuple[str, Any]]:
    """Yield the entries of a list of tuples of so many items, and the name of each for messages.

    Parameters
    ----------
    name : str
        Name of the argument, for messages.
    given : sequence or None
    lengths : tuple of int
    how : str
        An example, for messages.
    alone : type, optional
        Class of entries that are no tuples.

    Raises
    ------
    InputTypeError
    """
    if given is None:
        return
    if isinstance(given, (str, Mapping)) or not isinstance(given, Sequence):
        raise InputTypeError(f"{name}: {how}; got {type(given).__name__}")
    for i, entry in enumerate(given):
        several = isinstance(entry, Sequence) and not isinstance(entry, str)
        if not isinstance(entry, alone) and not (several and len(entry) in lengths):
            raise InputTypeError(f"{name}[{i}]: {how}; got {entry!r}")
        yield f"{name}[{i}]", entry


def components(name: str, letters: Any) -> list[int]:
    """Return the components, ascending, that letters such as "xz" mean."""
    if not isinstance(letters, str):
        raise InputTypeError(f'{name}: letters must be text such as "xyz", got {letters!r}')
    if not letters or set(letters) - set("xyz"):
        raise InputError(
            f'{name}: letters must be of "x", "y" and "z", got {letters!r}; to hold rotations '
            'alone give ("rim", "", "xyz")'
        )
    if len(letters) > 3:
        raise InputError(
            f"{name}: letters must be at most three, got {letters!r}. Rotations of shells and "
            'beams are a third entry: ("rim", "xyz", "xyz")'
        )
    return sorted({"xyz".index(letter) for letter in letters})


def nodes_of_mesh(name: str, selector: Any, mesh: Mesh) -> IntArray:
    """Return the nodes of a mesh that are selected; see `selected_nodes`.

    Warns
    -----
    AOImpactWarning
        If numbers name the corners of edges whose midside nodes they leave out.
    """
    ids = selected_nodes(name, selector, mesh.nodes, mesh.node_sets, mesh.node_labels)
    if not (isinstance(selector, str) or callable(selector)) and (count := open_edges(mesh, ids)):
        warn(
            f"{name}: the numbers are those of corners, without the midside nodes of {count} edges "
            "between them. Name a set of nodes, or give a function of the coordinates"
        )
    return ids


def selected_nodes(
    name: str,
    selector: Any,
    nodes: FloatArray,
    node_sets: Mapping[str, IntArray],
    labels: IntArray | None,
) -> IntArray:
    """Return the nodes that a set's name, a function of all coordinates, or numbers select.

    Parameters
    ----------
    name : str
        Of the argument, for messages.
    selector : str, callable or array_like
        As the nodes of `free_dofs`.
    nodes : ndarray, shape (n_nodes, 3)
        m.
    node_sets : mapping of str to array of int
    labels : ndarray of int, shape (n_nodes,), or None
        By which numbers name nodes; None: from 0.

    Returns
    -------
    ndarray of int
        Ascending, each once.

    Raises
    ------
    InputError, InputTypeError
        If it selects nothing, or names an unknown set or number.
    """
    if isinstance(selector, str):
        found = called(selector, node_sets)
        if found is None:
            known = ", ".join(map(repr, node_sets)) or "none"
            raise InputError(
                f"{name}: the mesh has no node set {selector!r}{nearest(selector, node_sets)}; "
                f"it has {known}"
            )
        return node_sets[found]
    of_mask, given = "the mask of nodes", selector
    if callable(selector):
        of_mask = "the function"
        try:
            given = selector(nodes)
        except Exception as error:
            raise InputError(
                f"{name}: the function raised {type(error).__name__}: {error}; it is called with "
                f"the coordinates of all nodes, an array of shape {nodes.shape}, and should return "
                "one bool for each"
            ) from error
    try:
        mask = np.asarray(given)
    except ValueError as error:
        wanted = "the function must return one bool for each node"
        wanted = wanted if callable(selector) else "nodes must be a flat list of numbers"
        raise InputTypeError(f"{name}: {wanted}: {error}") from None
    if mask.dtype != bool and callable(selector):
        what = type(given).__name__ if mask.ndim == 0 else f"dtype {mask.dtype}"
        raise InputTypeError(f"{name}: the function must return one bool for each node, got {what}")
    if mask.dtype != bool:
        return nodes_by_number(f"{name}: nodes", selector, len(nodes), labels)
    if mask.shape != (len(nodes),):
        raise InputError(
            f"{name}: {of_mask} must give one bool for each of {len(nodes)} nodes, got shape "
            f"{mask.shape}"
        )
    if not mask.any():
        low, high = nodes.min(axis=0), nodes.max(axis=0)
        box = ", ".join(f"{c} {a:g}…{b:g}" for c, a, b in zip("xyz", low, high, strict=True))
        raise InputError(
            f"{name}: {of_mask} selects no nodes; the mesh spans {box} m: compare coordinates with "
            "a tolerance"
        )
    return np.flatnonzero(mask)
