"""Mechanisms: parts of a mesh that move against each other without elastic force.

Elements that share a whole face cannot move against each other without strain. So each part, a set
of elements connected by whole faces, has six rigid motions. Shared edges, shared nodes and supports
constrain these motions. What they leave free, apart from rigid motions of the whole body, are
mechanisms: a part swings about an edge or a node. Curved edges of second order, several edges
together, or parts in a ring may prevent this, so that a rank is computed.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import PRINTED, ROUNDING, FloatArray, IntArray, plain, record, sp
from ..linalg import m_orthonormal, null_space
from ..mesh import Surface, motions_at

# Motions of parts count as free if the square of their normalised misfit at joints and supports is
# below this. So nodes off a hinge line by less than 1e-4 of a part's size count as on it, since
# mesh files are rounded to about six digits. The resistance due to such an offset is about 1e-8 of
# the body's stiffness.
_UNRESISTED = 1e-8


@record
class Mechanism:
    """Motions of a body without elastic force that are not rigid-body motions.

    Attributes
    ----------
    motions : ndarray, shape (n_dofs, m)
        Basis, M-orthonormal and M-orthogonal to the rigid motions. Without a mesh: a single
        combination of these motions.
    """

    motions: FloatArray
    # With a mesh: coordinates of its nodes, m; the part of each element; the links, (3, n_links),
    # each a shared node and two parts that it joins; each part's rotation in each motion,
    # (n_parts, 3, m).
    _known: tuple[FloatArray, IntArray, IntArray, FloatArray] | None = None

    def moved_by(self, b: FloatArray) -> bool:
        """Return whether a force along b, shape (n_dofs,), moves the parts against each other."""
        size = np.linalg.norm(b) * np.linalg.norm(self.motions)
        return float(np.linalg.norm(b @ self.motions)) > PRINTED * float(size)

    def where(self, b: FloatArray) -> str:
        """Describe the joint that turns most under a force along b, and its smaller part."""
        if self._known is None:
            return "see body.mechanism.motions"
        places, part, (joint, *sides), turns = self._known
        turn = turns @ (b @ self.motions)
        apart = np.linalg.norm(turn[sides[0]] - turn[sides[1]], axis=1)
        most, sizes = apart.argmax(), np.bincount(part)
        node, small = joint[most], min((side[most] for side in sides), key=sizes.__getitem__)
        which = f"{sizes[small]} of {len(part)} elements, the first is {(part == small).argmax()}"
        return f"{which}, share nodes with others near {plain(places[node])} m, but no face"


def mechanism_of(
    surface: Surface,
    free: IntArray,
    M: Any,
    rigid: FloatArray,
    springs: FloatArray | None = None,
) -> Mechanism | None:
    """Return the mechanism of a mesh; None if there is none.

    Parameters
    ----------
    surface : Surface
        Surface of the mesh, with the part of each element.
    free : ndarray of int, shape (n_dofs,)
        Dofs 3·node + component that no support holds.
    M : scipy.sparse.csr_array, shape (n_dofs, n_dofs)
    rigid : ndarray, shape (n_dofs, r)
        M-orthonormal rigid motions that the supports leave free.
    springs : ndarray, shape (n_dofs,), optional
        Stiffness of springs to the ground, N/m; here they count as supports.
    """
    if not surface.part.any():
        return None
    mesh, part, parts = surface.mesh, surface.part, int(surface.part.max()) + 1
    node, of = np.divmod(np.unique(mesh.cells * parts + part[:, None]), parts)
    link = np.flatnonzero(node[1:] == node[:-1])  # two parts that share a node
    if not len(link):
        return None
    members, corners, centre = np.bincount(part), mesh.nodes[mesh.cells], np.zeros((parts, 3))
    np.add.at(centre, part, corners.mean(axis=1))
    centre /= members[:, None]
    spread = ((corners - centre[part][:, None]) ** 2).mean(axis=1).sum(axis=1)
    size = np.sqrt(np.bincount(part, spread) / members)
    # Displacement of each part's nodes due to its unit translations and rotations about its centre.
    blocks = motions_at((mesh.nodes[node] - centre[of]) / size[of][:, None])
    shape = 3 * len(node), 6 * parts
    moved = sp.bsr_array((blocks, of, np.arange(len(node) + 1)), shape=shape).tocsr()
    firsts, ends = np.flatnonzero(np.diff(node, prepend=-1)), (link, link + 1)
    own, *joined = (moved[(3 * at[:, None] + np.arange(3)).ravel()] for at in (firsts, *ends))
    held = np.setdiff1d(np.arange(own.shape[0]), free if springs is None else free[springs == 0.0])
    rows = sp.vstack([own[held], joined[0] - joined[1]])
    gram = rows.T @ rows
    sizes = np.sqrt(gram.diagonal())
    scale = sp.diags_array(1.0 / np.where(sizes > 0.0, sizes, 1.0))
    scaled, unit = (scale @ gram @ scale).tocsr(), sp.eye_array(len(sizes), format="csr")
    unresisted = np.asarray(scale @ null_space(scaled, unit, _UNRESISTED))
    count = unresisted.shape[1] - rigid.shape[1]
    if count <= 0:
        return None
    motions = (own @ unresisted)[free]
    motions -= rigid @ (rigid.T @ (M @ motions))
    inertia, y = np.linalg.eigh(motions.T @ (M @ motions))
    y = y[:, -count:] / np.sqrt(inertia[-count:])
    turns = unresisted.reshape(parts, 6, -1)[:, 3:] / size[:, None, None]
    links = np.stack([node[link], of[link], of[link + 1]])
    return Mechanism(motions @ y, (mesh.nodes, part, links, turns @ y))


def mechanism_in(motion: FloatArray, K: Any, M: Any, rigid: FloatArray) -> Mechanism | None:
    """Return the mechanism in a motion without elastic force; None if the motion is rigid.

    Parameters
    ----------
    motion : ndarray, shape (n_dofs,)
        Motion from `check_stiffness`.
    K, M : scipy.sparse.csr_array, shape (n_dofs, n_dofs)
    rigid : ndarray, shape (n_dofs, r)
        M-orthonormal rigid motions.
    """
    found = m_orthonormal(rigid, motion[:, None], M)
    if not found.size or np.linalg.norm(K @ found) > ROUNDING * np.linalg.norm(
        abs(K) @ np.abs(found)
    ):
        return None
    return Mechanism(found)
