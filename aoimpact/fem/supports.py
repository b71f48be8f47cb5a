"""Supports, added masses and springs to the ground of a body."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import (
    PRINTED,
    FloatArray,
    InputError,
    InputTypeError,
    IntArray,
    called,
    checked,
    inertia_tensor,
    nearest,
    place,
    positive,
    record,
    require,
    sp,
    warn,
)
from ..linalg import LARGEST
from ..mesh import Mesh, motions_at, open_edges
from .labels import SAME_PLACE, label_of, nodes_by_number
from .laminate import FAR_OFF

Selector = str | Callable[[FloatArray], npt.ArrayLike] | npt.ArrayLike
Support = tuple[Selector, str] | tuple[Selector, str, str]


def free_dofs(mesh: Mesh, fixed: Sequence[Support] | None) -> IntArray:
    """Return the dofs that no support holds, ascending.

    Parameters
    ----------
    mesh : Mesh
    fixed : sequence of (nodes, letters) or (nodes, letters, letters)
        Supports. Nodes: numbers, the name of a set, or a function of all coordinates that returns
        one bool per node. First letters, of "x", "y" and "z": the constrained displacements, or ""
        if rotations follow. Second letters: the constrained rotations about these axes.

    Raises
    ------
    InputError, InputTypeError
        If an entry selects nothing, names an unknown set or letter, or no dof is left free.
    """
    left = np.zeros((2, mesh.n_nodes, 3), dtype=bool)
    left[0], left[1, mesh.thin_nodes] = True, True
    how = (
        'give a list such as [("xmin", "xyz"), ([0, 7], "z")], of shells and beams also '
        '("rim", "xyz", "xyz"), or ("rim", "", "xyz"), to hold rotations'
    )
    for name, (selector, *letters) in entries("fixed", fixed, (2, 3), how):
        selected = nodes_of_mesh(name, selector, mesh)
        if len(letters) == 2 and not np.isin(selected, mesh.thin_nodes).any():
            raise InputError(f"{name}: only nodes of shells and beams have rotations to be held")
        for which, each in enumerate(letters):
            if each != "" or (which, len(letters)) != (0, 2):
                left[which, selected[:, None], components(name, each)] = False
    if not left.any():
        raise InputError("fixed holds every dof of the body; leave some free to move")
    return np.flatnonzero(left)


def entries(
    name: str, given: Any, lengths: tuple[int, ...], how: str, alone: Any = ()
) -> Iterator[tuple[str, Any]]:
    """Yield the name, for messages, and the value of each entry of a list of tuples.

    Parameters
    ----------
    name : str
        Name of the argument, for messages.
    given : sequence or None
        Entries.
    lengths : tuple of int
        Admissible lengths of the tuples.
    how : str
        Example, for messages.
    alone : type, optional
        Class of admissible entries that are not tuples.

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
    """Return the ascending indices of the components named by letters such as "xz"."""
    if not isinstance(letters, str):
        raise InputTypeError(f'{name}: letters must be text such as "xyz", got {letters!r}')
    if not 0 < len(letters) < 4 or set(letters) - set("xyz"):
        how = 'up to three of "x", "y" and "z"; rotations are a third entry, ("rim", "xyz", "xyz")'
        raise InputError(f"{name}: letters must be {how}, got {letters!r}")
    return sorted({"xyz".index(letter) for letter in letters})


def nodes_of_mesh(name: str, selector: Any, mesh: Mesh) -> IntArray:
    """Return the selected nodes of a mesh; see `selected_nodes`.

    Warns
    -----
    AOImpactWarning
        If given numbers contain both corners of edges, but not their midside nodes.
    """
    ids = selected_nodes(name, selector, mesh.nodes, mesh.node_sets, mesh.node_labels)
    if not (isinstance(selector, str) or callable(selector)) and (count := open_edges(mesh, ids)):
        warn(
            f"{name}: the nodes given lack the midside nodes of {count} edges between them. Name a "
            "set of nodes, or give a function of the coordinates"
        )
    return ids


def selected_nodes(
    name: str,
    selector: Any,
    nodes: FloatArray,
    node_sets: Mapping[str, IntArray],
    labels: IntArray | None,
) -> IntArray:
    """Return the nodes selected by the name of a set, a function of all coordinates, or numbers.

    Parameters
    ----------
    name : str
        Name of the argument, for messages.
    selector : str, callable or array_like
        Nodes; see `free_dofs`.
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates, m.
    node_sets : mapping of str to array of int
        Nodes of each named set.
    labels : ndarray of int, shape (n_nodes,), or None
        Number of each node for the user; None if numbers count from 0.

    Returns
    -------
    ndarray of int
        Distinct indices, ascending.

    Raises
    ------
    InputError, InputTypeError
        If the selector selects nothing, or names an unknown set or number.
    """
    if isinstance(selector, str):
        found = called(selector, node_sets)
        if found is None:
            known = ", ".join(map(repr, node_sets)) or "none"
            hint = nearest(selector, node_sets)
            raise InputError(f"{name}: the mesh has no node set {selector!r}{hint}; it has {known}")
        return node_sets[found]
    function = callable(selector)
    of_mask = "the function" if function else "the mask of nodes"
    must = f"{name}: {of_mask} must give one bool for each of {len(nodes)} nodes"
    try:
        given = selector(nodes) if function else selector
    except Exception as error:
        raised = f"raised {type(error).__name__}: {error}"
        raise InputError(f"{must} of coordinates, shape {nodes.shape}, but {raised}") from error
    try:
        mask = np.asarray(given)
    except ValueError as error:
        must = must if function else f"{name}: nodes must be a flat list of numbers"
        raise InputTypeError(f"{must}: {error}") from None
    if mask.dtype != bool and not function:
        return nodes_by_number(f"{name}: nodes", selector, len(nodes), labels)
    if mask.dtype != bool:
        raise InputTypeError(f"{must}, got dtype {mask.dtype}")
    if mask.shape != (len(nodes),):
        raise InputError(f"{must}, got shape {mask.shape}")
    if not mask.any():
        low, high = nodes.min(axis=0), nodes.max(axis=0)
        box = ", ".join(f"{c} {a:g}…{b:g}" for c, a, b in zip("xyz", low, high, strict=True))
        raise InputError(f"{name}: {of_mask} selects no nodes; the mesh spans {box} m")
    return np.flatnonzero(mask)


@record
class RigidMass:
    """A rigid attachment to some nodes, with mass, centre of mass and moments of inertia.

    The attachment follows the mean rigid motion of its nodes, a least-squares fit to their
    displacements, without stiffening them (as Nastran's RBE3 and Abaqus' distributing coupling). A
    stiff seat must be meshed. The mass, centre of mass and moments of inertia of the body are
    exact.

    Parameters
    ----------
    nodes : str, callable or array_like
        Nodes, given as in `fixed`; their mass matrix is full. They must not all lie on one line,
        unless `inertia` is zero and `centre` is their middle.
    mass : float
        Mass, kg.
    centre : array_like, shape (3,), optional
        Centre of mass, m; by default the middle of the nodes.
    inertia : array_like, shape (3,) or (3, 3), optional
        Moments of inertia about axes x, y, z through the centre of mass, or the inertia tensor,
        kg m²; by default zero.

    Raises
    ------
    InputError, InputTypeError
        If the mass is not positive, or no rigid body can have the inertia.

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
    """Return the mass matrix to add to M, shape (3 n_nodes, 3 n_nodes); None without masses.

    Parameters
    ----------
    mesh : Mesh
    masses : sequence of (nodes, kg) or RigidMass
        Each mass is shared equally by its nodes, and acts in all three directions.
    free : ndarray of int
        Dofs that no support holds.

    Raises
    ------
    InputError, InputTypeError
        If an entry has another form or selects nothing, or a mass is not positive.
    """
    how = 'give a list of pairs such as [("carriage", 5.0)], or of RigidMass'
    added = None
    for name, entry in entries("masses", masses, (2,), how, RigidMass):
        if isinstance(entry, RigidMass):
            one = _rigid(name, entry, mesh)
        else:
            ids = nodes_of_mesh(name, entry[0], mesh)
            share = np.zeros((mesh.n_nodes, 3))
            share[ids] = _bounded(f"{name}: the mass", entry[1], "kg") / len(ids)
            one = sp.diags_array(share.reshape(-1), format="csr")
            one.eliminate_zeros()
        on = np.unique(np.flatnonzero(one.diagonal()) // 3)
        held = len(on) - np.count_nonzero(np.isin(on, free // 3))
        if held:
            warn(
                f"{name}: {held} of the {len(on)} nodes that carry the mass are constrained by "
                "fixed, and their part does not move; take other nodes, or release these"
            )
        added = one if added is None else added + one
    return added


def _rigid(name: str, mount: RigidMass, mesh: Mesh) -> sp.csr_array:
    """Return the mass matrix WᵀJW of a rigid attachment with the inertia matrix J.

    q = W u, the rigid motion at its centre, is the least-squares fit to the displacements u of its
    nodes.
    """
    ids, nodes = nodes_of_mesh(name, mount.nodes, mesh), mesh.nodes
    require(100.0 * (3 * len(ids)) ** 2, f"{name} on {len(ids)} nodes", "take fewer nodes")
    middle = nodes[ids].mean(axis=0)
    centre = middle if mount.centre is None else np.asarray(mount.centre)
    inertia = np.zeros((3, 3)) if mount.inertia is None else np.asarray(mount.inertia)
    size = float(np.abs(nodes[ids] - middle).max()) or 1.0
    motions = motions_at((nodes[ids] - middle) / size).reshape(-1, 6)
    values, vectors = np.linalg.eigh(motions.T @ motions)
    known = values > SAME_PLACE**2 * values[-1]  # rotations that the nodes determine
    fit = (vectors[:, known] / values[known]) @ (motions @ vectors[:, known]).T
    # Transformation of a rigid motion (translation, size · rotation) from the middle of the nodes
    # to the centre.
    to_centre = np.eye(6)
    to_centre[:3, 3:] = motions_at((centre - middle)[None] / size)[0, :, 3:]
    weights = np.zeros((6, 6))
    weights[:3, :3] = mount.mass * np.eye(3)
    weights[3:, 3:] = inertia / size**2
    weights = to_centre.T @ weights @ to_centre
    lost = vectors[:, ~known].T @ weights
    if np.abs(lost).max(initial=0.0) > PRINTED * mount.mass:
        why = f"its {len(ids)} nodes lie on one line, about which there is inertia"
        raise InputError(
            f"{name}: {why}; give nodes spread over the seat, or no inertia and centre"
        )
    body, radius = float(np.ptp(nodes, axis=0).max()), math.sqrt(np.trace(inertia) / mount.mass)
    off = float(np.linalg.norm(centre - nodes.mean(axis=0)))
    if max(off, radius) > FAR_OFF * body > 0.0:
        warn(
            f"{name}: the centre of mass is {off:.3g} m from the middle of a body of {body:.3g} m, "
            f"the radius of gyration {radius:.3g} m: give m and kg m² (1 kg mm² is 1e-6)"
        )
    block = fit.T @ weights @ fit
    dofs = (3 * ids[:, None] + np.arange(3)).reshape(-1)
    place = np.repeat(dofs, len(dofs)), np.tile(dofs, len(dofs))
    shape = nodes.size, nodes.size
    return sp.csr_array(((0.5 * (block + block.T)).reshape(-1), place), shape=shape)


def spring_stiffness(
    mesh: Mesh, springs: Sequence[SpringSupport] | None, free: IntArray
) -> FloatArray | None:
    """Return the stiffness to add to the diagonal of K, N/m, (n_dofs,); None without springs.

    Parameters
    ----------
    mesh : Mesh
    springs : sequence of (nodes, letters, N/m)
        Total stiffness of the nodes in each of the named directions.
    free : ndarray of int
        Dofs that no support holds.

    Raises
    ------
    InputError, InputTypeError
        If an entry has another form or selects nothing, a stiffness is not positive, or a support
        holds a node in the direction of its spring.
    """
    how = 'give a list such as [("mounts", "z", 1e6)]: nodes, letters, N/m'
    total, held = np.zeros((2, mesh.n_nodes, 3)), np.ones((2, mesh.n_nodes, 3), dtype=bool)
    held.reshape(-1)[free] = False
    for name, (selector, letters, stiffness) in entries("springs", springs, (3,), how):
        ids = nodes_of_mesh(name, selector, mesh)
        share = _bounded(f"{name}: the stiffness", stiffness, "N/m") / len(ids)
        at = 0, ids[:, None], components(name, letters)
        if (on_support := held[at].any(axis=1)).any():
            first = label_of(int(ids[on_support][0]), mesh.node_labels)
            raise InputError(
                f"{name}: {int(on_support.sum())} of its {len(ids)} nodes, the first is {first}, "
                "are constrained by fixed against the spring; release them, or take others"
            )
        total[at] += share
    return total.reshape(-1)[free] if total.any() else None


def _bounded(name: str, value: Any, unit: str) -> float:
    number = positive(name, value, unit=unit)
    if number > LARGEST:
        raise InputError(f"{name}, {number:g} {unit}, is too large to compute with; check the unit")
    return number
