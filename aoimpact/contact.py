"""The contact functional: the one displacement u = bᵀX by which a body is seen from its contact.

The paper takes the unit vector of a dof i₀ (eq. 1); any other vector b serves as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .checks import finite_array, integer, nonnegative, unit_vector
from .errors import InputError, InputTypeError, warn

__all__ = ["Body", "ContactPoint", "contact_point"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_COMPONENTS = "xyz"

# A point closer to a node than this fraction of the body's size is that node.
_AT_NODE = 1e-6


class Body(Protocol):
    """What a functional needs to know of a finite-element model."""

    @property
    def K(self) -> Any: ...
    @property
    def M(self) -> Any: ...
    @property
    def n_dofs(self) -> int: ...
    @property
    def nodes(self) -> FloatArray | None: ...
    @property
    def free(self) -> IntArray | None: ...
    @property
    def mass(self) -> float | None: ...
    @property
    def rigid_modes(self) -> FloatArray: ...
    def translation(self, direction: npt.ArrayLike) -> FloatArray: ...
    def com_functional(self, direction: npt.ArrayLike) -> FloatArray: ...


@dataclass(frozen=True, eq=False)
class ContactPoint:
    """A place on a body, and the direction in which it is touched there.

    Made by `FEModel.contact`. It stands for the full finite-element model wherever `simulate` takes
    a body.

    Attributes
    ----------
    body : FEModel
    b : ndarray, shape (n_dofs,)
        Contact functional on the free dofs: u = bᵀX.
    direction : ndarray, shape (3,), or None
        Unit vector of the projectile's direction of travel; None for a body without nodes.
    point : ndarray, shape (3,), or None
        Where, m.
    node : int or None
        The node touched.
    """

    body: Body
    b: FloatArray
    direction: FloatArray | None
    point: FloatArray | None
    node: int | None

    def __repr__(self) -> str:
        if self.point is None or self.direction is None:
            return f"ContactPoint(dof {int(np.argmax(np.abs(self.b)))} of {self.body!r})"
        where = ", ".join(f"{x:g}" for x in self.point)
        along = ", ".join(f"{x:.4g}" for x in self.direction)
        return f"ContactPoint(node {self.node} at ({where}) m along ({along}) of {self.body!r})"


def contact_point(
    body: Body,
    *,
    point: npt.ArrayLike | None = None,
    direction: npt.ArrayLike | None = None,
    dof: int | None = None,
    radius: float = 0.0,
) -> ContactPoint:
    """Return the functional of a node in a direction, or of a single dof.

    Parameters
    ----------
    body : FEModel
    point : array_like, shape (3,), optional
        A node's place, m. A contact is at a node: a point off the nodes goes, with a warning, to
        the nearest one within half the distance between nodes there.
    direction : array_like, shape (3,), optional
        Direction of travel; any length but zero.
    dof : int, optional
        Row of K, in place of `point` and `direction`.
    radius : float, optional
        Of the patch that carries the contact, m; 0, a single node, is what there is.

    Raises
    ------
    InputError
        If the place is not on the body, or cannot move in the direction.

    Warns
    -----
    AOImpactWarning
        If the point is not the node's place.
    """
    if nonnegative("radius", radius, unit="m") > 0.0:
        raise InputError(
            f"radius={radius:g} m: contact spread over a patch is not in this version; use radius=0"
        )
    if dof is not None:
        if point is not None or direction is not None:
            raise InputError("give either dof, or point and direction, not both")
        return _at_dof(body, integer("dof", dof, low=0, high=body.n_dofs - 1))
    if point is None or direction is None:
        raise InputTypeError("contact needs dof, or both point and direction")
    if body.nodes is None or body.free is None:
        raise InputError(
            "point: this body has no nodes; give dof, or build it with FEModel(K=, M=, nodes=)"
        )
    return _at_node(body, finite_array("point", point, shape=(3,), unit="m"), direction)


def _at_dof(body: Body, dof: int) -> ContactPoint:
    b = np.zeros(body.n_dofs)
    b[dof] = 1.0
    b.flags.writeable = False
    if body.nodes is None or body.free is None:
        return ContactPoint(body, b, None, None, None)
    node, component = divmod(int(body.free[dof]), 3)
    return ContactPoint(body, b, np.eye(3)[component], body.nodes[node], node)


def _at_node(body: Body, point: FloatArray, direction: npt.ArrayLike) -> ContactPoint:
    assert body.nodes is not None
    assert body.free is not None
    along = unit_vector("direction", direction)
    node = _nearest_node(body.nodes, point)
    b = np.zeros(3 * len(body.nodes))
    b[3 * node : 3 * node + 3] = along
    b = b[body.free]
    if np.linalg.norm(b) < 1e-12:
        raise InputError(
            f"point {_plain(point)} m with direction {_plain(along)}: node {node} is held by the "
            "supports in that direction, so no impact there can move it; choose another node or "
            "direction, or release the node in fixed"
        )
    b.flags.writeable = False
    return ContactPoint(body, b, along, body.nodes[node], node)


def _nearest_node(nodes: FloatArray, point: FloatArray) -> int:
    distance = np.linalg.norm(nodes - point, axis=1)
    node = int(np.argmin(distance))
    size = float(np.linalg.norm(np.ptp(nodes, axis=0)))
    if distance[node] <= _AT_NODE * size:
        return node
    around = np.linalg.norm(nodes - nodes[node], axis=1)
    spacing = float(np.sort(around)[1]) if len(nodes) > 1 else 0.0
    if distance[node] > 0.5 * spacing:
        raise InputError(
            f"point {_plain(point)} m is {distance[node]:.3g} m from the nearest "
            f"node ({node}, at {_plain(nodes[node])} m), where nodes are "
            f"{spacing:.3g} m apart: give the coordinates of a node (are they in metres?)"
        )
    warn(
        f"point {_plain(point)} m is no node; in this version a contact is at a node, and node "
        f"{node} at {_plain(nodes[node])} m, {distance[node]:.3g} m off, is taken: give its "
        "coordinates if it is meant, or mesh the body with a node at the point"
    )
    return node


def _plain(vector: FloatArray) -> str:
    return f"({', '.join(f'{x:.6g}' for x in vector)})"
