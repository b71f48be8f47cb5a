"""Shell elements of three and four nodes with six degrees of freedom at each.

Each element is flat and lies in the mean plane of its nodes; rigid links join nodes off that plane
to it, as in R. H. MacNeal (Computers & Structures 8, 175, 1978). In this plane

- bending and transverse shear follow MITC4 (K.-J. Bathe and E. N. Dvorkin, Int. J. Num. Meth. Eng.
  21, 367, 1985) and, for triangles, MITC3+ with a bubble function of the rotations (Y. Lee,
  P.-S. Lee and K.-J. Bathe, Computers & Structures 138, 12, 2014);
- the membrane of four nodes has incompatible modes (R. L. Taylor, P. J. Beresford and E. L. Wilson,
  Int. J. Num. Meth. Eng. 10, 1211, 1976); a weak penalty ties its nodal rotation about the normal
  to the in-plane rotation of the displacements (T. J. R. Hughes and F. Brezzi, Comp. Meth. Appl.
  Mech. Eng. 72, 105, 1989);
- the membrane of three nodes is the optimal triangle with drilling freedoms (C. A. Felippa, Comp.
  Meth. Appl. Mech. Eng. 192, 2125, 2003).

Each element is defined by its strain matrix B at the quadrature points: nine rows, the eight
generalised strains of `Layers` and the drilling strain. Inner freedoms are condensed into B, so
that K = Σ w Bᵀ C B. The same B gives the strains of a deformed body.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import PRINTED, ArrayPair, FloatArray, InputError, IntArray, plain, record
from ..mesh import AT_NODE, dot, pairs, parted, sides, unit
from .laminate import Layers

# Ratio of the drilling stiffness to the membrane's shear stiffness. A small value avoids locking in
# in-plane bending (1e-3 costs 1 % for elements with aspect ratio 10), and keeps folds from
# transmitting moments about the normal.
_DRILLING = 1e-4

# Smallest cosine between normals of elements of one surface; below it (35°) they meet at a fold.
FOLD = 0.82

# Largest rigid part of an element next to a junction of plates, relative to the element's length:
# elements shorter than the width of the junction keep an elastic part.
_ENDS = 0.8

# Weights of the rigid link at the four corners of a strip between an element's edge and the line of
# the junction: 1 at the element, 0 on the line.
_ON_ELEMENT = np.array([0.0, 0.0, 1.0, 1.0])[:, None]

_GAUSS = 1.0 / np.sqrt(3.0)
_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])

# Derivatives along r and s of a triangle's linear shape functions.
_LINEAR = np.array([(-1.0, 1.0, 0.0), (-1.0, 0.0, 1.0)])

# Quadrature of six points on a triangle, in area coordinates, with weights relative to the area;
# exact to degree 4 (D. A. Dunavant, Int. J. Num. Meth. Eng. 21, 1129, 1985).
_OUTER, _INNER = 0.091576213509770743, 0.445948490915964886
_SHARES = np.repeat([0.109951743655321868, 0.223381589678011466], 3)
_AREAS = np.array([np.roll([1.0 - 2.0 * a, a, a], i) for a in (_OUTER, _INNER) for i in range(3)])

# Felippa's natural strains due to unit corner rotations, times 3 l²/(2 A), with the edge's length l
# and the triangle's area A; shape (corner of the strain, edge, rotated corner).
_NATURAL = np.array(
    [
        [(1, 2, 1), (0, 1, -1), (-1, -1, -2)],
        [(-2, -1, -1), (1, 1, 2), (-1, 0, 1)],
        [(1, -1, 0), (-1, -2, -1), (2, 1, 1)],
    ],
    dtype=np.float64,
)


@record
class Strains:
    """Generalised strains of shell elements at quadrature points as functions of nodal dofs.

    Attributes
    ----------
    rows : ndarray, shape (n, points, 9, 6 nodes)
        Strain matrix B for (u, v, w, θx, θy, θz) in global axes; row 9 is the drilling strain.
    weights : ndarray, shape (n, points)
        Area that belongs to each point, m².
    shape : ndarray, shape (points, nodes)
        Shape functions at the points.
    frames : ndarray, shape (n, 3, 3)
        Elements' axes as rows; the third is the normal.
    """

    rows: FloatArray
    weights: FloatArray
    shape: FloatArray
    frames: FloatArray


def element_stiffness(
    corners: FloatArray,
    layers: Layers,
    normals: FloatArray | None = None,
    ends: FloatArray | None = None,
    *,
    constant: bool = False,
) -> FloatArray:
    """Return the stiffness of elements, shape (n, 6 nodes, 6 nodes), exactly symmetric.

    Parameters
    ----------
    corners : ndarray, shape (n, 3 or 4, 3)
        Coordinates of the nodes, m.
    layers : Shell or Laminate
    normals : ndarray, shape (n, 3 or 4, 3), optional
        Unit normals of the surface at the nodes, from `nodal_normals`; by default the elements'
        own normals.
    ends : ndarray, shape (n, 3 or 4, 3), optional
        Rigid links from the nodes to the elements' corners, from `rigid_ends`, m.
    constant : bool, optional
        True gives triangles a constant membrane strain, for bodies that contain quadrilaterals too.
        Under constant stress, the optimal triangle has nodal moments about the normal that only
        adjacent triangles balance.
    """
    strains = strain_rows(corners, layers, normals, ends, constant=constant)
    forces = strains.weights[..., None, None] * (_stiffness(layers) @ strains.rows)
    shape = (len(corners), -1, 6 * corners.shape[1])
    matrix = strains.rows.reshape(shape).swapaxes(1, 2) @ forces.reshape(shape)
    symmetric: FloatArray = 0.5 * (matrix + matrix.swapaxes(1, 2))
    return symmetric


def element_mass(corners: FloatArray, layers: Layers) -> FloatArray:
    """Return the consistent mass with rotary inertia, shape (n, 6 nodes, 6 nodes).

    The displacement at height z is u + z θ×n. Rotation about the normal has no inertia.
    """
    n, nodes = corners.shape[:2]
    normal = element_frames(corners, layers)[0][:, 2]
    shape, weights = _areas(corners, normal)
    pairs = np.einsum("nq,qab->nab", weights, shape[:, :, None] * shape[:, None, :])
    m0, m1, m2 = layers.inertia
    six = np.zeros((n, 6, 6))
    six[:, :3, :3] = m0 * np.eye(3)
    six[:, 3:, 3:] = m2 * (np.eye(3) - normal[:, :, None] * normal[:, None, :])
    x, y, z = normal.T
    for i, j, value in ((0, 1, z), (1, 2, x), (2, 0, y)):  # terms of u·(θ×n)
        six[:, i, 3 + j] = six[:, 3 + j, i] = m1 * value
        six[:, j, 3 + i] = six[:, 3 + i, j] = -m1 * value
    matrix: FloatArray = np.einsum("nab,nij->naibj", pairs, six)
    return matrix.reshape(n, 6 * nodes, 6 * nodes)


def element_frames(corners: FloatArray, layers: Layers | None) -> ArrayPair:
    """Return the elements' axes as rows, (n, 3, 3), and their nodes in these axes, (n, nodes, 3).

    x is the projection of the layers' reference direction or, without it, roughly the first edge.
    """
    if corners.shape[1] == 3:
        first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    else:  # tangents along r and s at the centre
        first = corners[:, 1] + corners[:, 2] - corners[:, 0] - corners[:, 3]
        second = corners[:, 2] + corners[:, 3] - corners[:, 0] - corners[:, 1]
    normal = unit(np.cross(first, second))
    reference = None if layers is None else layers.reference
    along = unit(first if reference is None else np.broadcast_to(reference, first.shape))
    across = along - dot(along, normal)[:, None] * normal
    if count := np.count_nonzero(np.linalg.norm(across, axis=1) < AT_NODE):
        raise InputError(
            f"fibre_axis or axis 1, {plain(along[0])}, is normal to {count} elements; "
            "give a direction along the surface"
        )
    x = unit(across)
    frames = np.stack([x, np.cross(normal, x), normal], axis=1)
    local = np.einsum("nij,naj->nai", frames, corners - corners.mean(axis=1, keepdims=True))
    return frames, local


def nodal_normals(nodes: FloatArray, groups: Sequence[IntArray]) -> list[FloatArray]:
    """Return the surface's unit normals at the nodes of elements, (n, 3 or 4, 3) for each group.

    Each normal is the mean of the normals of those elements at the node whose normals, turned to
    the element's side, differ from the element's by less than the angle of `FOLD`. Other elements
    belong to another surface, joined at a fold.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates, m.
    groups : sequence of ndarray of int, shape (n, 3) or (n, 4)
        Nodes of the elements of each group.
    """
    at, normal = np.concatenate([cells.ravel() for cells in groups]), _facets(nodes, groups)
    total = normal.copy()
    for one, other in pairs(at):
        cosine = dot(normal[one], normal[other])
        total[one] += np.where(np.abs(cosine) > FOLD, np.sign(cosine), 0.0)[:, None] * normal[other]
    return parted(unit(total), groups)


def _facets(nodes: FloatArray, groups: Sequence[IntArray]) -> FloatArray:
    """Return each element's own normal, repeated for its corners, shape (all corners, 3)."""
    own = [element_frames(nodes[cells], None)[0][:, 2] for cells in groups]
    return np.concatenate(
        [np.repeat(each, cells.shape[1], axis=0) for each, cells in zip(own, groups, strict=True)]
    )


def rigid_ends(
    nodes: FloatArray, parts: Sequence[tuple[IntArray, Layers]]
) -> list[tuple[FloatArray, IntArray, FloatArray]]:
    """Return the rigid offsets of elements at junctions of plates, and strips that fill the gaps.

    If plates meet at an angle θ and their faces lie at heights f over the nodes, the faces meet at
    a distance of (f_other + f cos θ)/sin θ from the line of the nodes. A plate that ends at the
    line is rigid over this distance. A plate that continues beyond the line is held on one face
    only. By the theorems of minimum energy, its stiffness is between those with an elastic and with
    a rigid distance; half the distance is taken as rigid. Plane elasticity gives a rigid share of
    0.25, 0.47 and 0.70 for bending, for webs of 1, 2 and 4 thicknesses.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates, m.
    parts : sequence of (ndarray of int, Shell or Laminate)
        Nodes of the elements, shape (n, 3) or (n, 4), and their section.

    Returns
    -------
    list of (ends, strips, links)
        One entry per part. ends: rigid links from the nodes to the elements' corners, m, shape
        (n, 3 or 4, 3). strips: nodes of elements between these corners and the line, which stretch,
        bend and twist along the line, shape (any, 4). links: their rigid links, m, (any, 4, 3).
    """
    groups = [cells for cells, _ in parts]
    at, edge, inside, away = sides(nodes, groups)
    depth = np.linalg.norm(away, axis=1)
    m = away / depth[:, None]
    n, rows = _facets(nodes, groups), parted(np.arange(len(at)), groups)
    half, offset = np.empty((2, len(at)))
    for of, (_, layers) in zip(rows, parts, strict=True):
        half[of], offset[of] = 0.5 * layers.total_thickness, layers.offset
    reach, through = np.zeros(len(at)), np.zeros(len(at), dtype=bool)
    for one, other in pairs(edge):
        cosine = dot(m[one], m[other])
        f = half[one] + offset[one] * np.sign(dot(n[one], m[other]))
        g = half[other] + offset[other] * np.sign(dot(n[other], m[one]))
        start = (g + f * cosine) / np.sqrt(np.maximum(1.0 - cosine**2, 1.0 - FOLD**2))
        reach[one] = np.maximum(reach[one], np.where(np.abs(cosine) <= FOLD, start, 0.0))
        through[one] |= cosine < -FOLD
    moved = np.minimum(np.where(through, 0.5, 1.0) * reach, 2.0 * _ENDS * depth)[:, None] * m
    ends = np.zeros_like(m)
    for of in rows:
        ends[of] = moved[of] + np.roll(moved[of], 1, axis=1)
    # Elements with a single node on the line take the mean offset of their neighbours.
    own, total, count = ends.any(axis=1), np.zeros_like(ends), np.zeros(len(at))
    for one, other in pairs(at[:, 0]) if own.any() else ():
        alike = np.abs(dot(n[one], n[other])) > FOLD
        follows = alike & ~own[one] & own[other] & (dot(inside[one], ends[other]) > 0.0)
        total[one[follows]] += ends[other[follows]]
        count[one[follows]] += 1.0
    ends[~own] = total[~own] / np.maximum(count[~own], 1.0)[:, None]
    found = []
    for of in rows:
        on = of[moved[of].any(axis=2)]
        found.append((ends[of], at[on][:, [0, 1, 1, 0]], moved[on][:, None] * _ON_ELEMENT))
    return found


def linked(corners: FloatArray, normals: FloatArray, shape: FloatArray) -> FloatArray:
    """Return the displacements of points in an element due to unit rotations of its nodes.

    If the ends of an edge e rotate by θ_i and θ_j, the edge deflects along the interpolated normal
    by the parabola (θ_i·(e × n_i) - θ_j·(e × n_j)) λ(1 - λ)/2 (linked interpolation: O. C.
    Zienkiewicz et al., Int. J. Num. Meth. Eng. 36, 3043, 1993). Displacements in bending waves are
    then accurate to fourth order; without this deflection, to second order. With the facet's normal
    instead of the n_i, nodal moments would have a component about the n_i, which only the weak
    drilling stiffness resists.

    Parameters
    ----------
    corners : ndarray, shape (3 or 4, 3)
        Coordinates of the nodes, m.
    normals : ndarray, shape (3 or 4, 3)
        Unit normals of the surface at the nodes, from `nodal_normals`.
    shape : ndarray, shape (p, 3 or 4)
        Shape functions at the points.

    Returns
    -------
    ndarray, shape (p, 3, 3 or 4, 3)
        Displacement, m. Axes: point, component, node, axis of the node's rotation.
    """
    after = np.roll(shape, -1, axis=1)
    # λ(1 - λ) on the edge, decaying linearly to 0 at the opposite side.
    beside = shape + after if len(corners) == 4 else np.ones_like(shape)
    bulge = 0.5 * shape * after / np.where(beside > 0.0, beside, 1.0)
    edge = bulge[..., None] * (np.roll(corners, -1, axis=0) - corners)
    arms = np.cross(edge - np.roll(edge, 1, axis=1), normals)
    return unit(shape @ normals)[:, :, None, None] * arms[:, None]


def strain_rows(
    corners: FloatArray,
    layers: Layers,
    normals: FloatArray | None = None,
    ends: FloatArray | None = None,
    *,
    constant: bool = False,
) -> Strains:
    """Return the strain matrices of elements; for the parameters see `element_stiffness`."""
    corners = corners if ends is None else corners + ends
    frames, local = element_frames(corners, layers)
    stiffness = _stiffness(layers)
    if normals is not None:
        normals = np.einsum("nij,naj->nai", frames, normals)
    if corners.shape[1] == 3:
        flatness = np.zeros(len(local)) if constant else _flatness(local, normals, stiffness)
        rows, inner, weights = _triangle(local, stiffness, flatness)
        shape = _AREAS
    else:
        rows, inner, weights = _quadrilateral(local)
        shape = _bilinear(_GAUSS * _CORNERS)[0]
    rows = _condensed(rows, inner, stiffness, weights)
    rows = rows.reshape(*rows.shape[:3], -1, 2, 3)
    # Rigid links from the nodes to the mean plane: u + θ × d with d along the normal.
    height = local[:, None, None, :, 2]
    rows[..., 1, 0] += height * rows[..., 0, 1]
    rows[..., 1, 1] -= height * rows[..., 0, 0]
    if normals is not None and np.abs(normals[..., :2]).max(initial=0.0) > PRINTED:
        _turn_to_surface(rows, local, normals)
    rows = rows @ frames[:, None, None, None]
    if ends is not None and ends.any():
        rows[..., 1, :] += np.cross(ends[:, None, None], rows[..., 0, :])
    return Strains(rows.reshape(*rows.shape[:3], -1), weights, shape, frames)


def _flatness(local: FloatArray, normals: FloatArray | None, stiffness: FloatArray) -> FloatArray:
    """Return the factor 1/(1 + (h δ/t)²) that reduces strains due to drilling rotations.

    δ is the largest angle between the normals of a triangle and of the surface at its nodes, h the
    longest edge, t the thickness. On curved surfaces drilling rotations take part in bending, and
    their strains would lock thin elements.
    """
    if normals is None:
        return np.ones(len(local))
    angle2 = (normals[..., :2] ** 2).sum(axis=2).max(axis=1)
    edge2 = ((local - np.roll(local, 1, axis=1)) ** 2).sum(axis=2).max(axis=1)
    thickness2 = 12.0 * stiffness[3, 3] / stiffness[0, 0]
    flat: FloatArray = 1.0 / (1.0 + edge2 * angle2 / thickness2)
    return flat


def _turn_to_surface(rows: FloatArray, local: FloatArray, normals: FloatArray) -> None:
    """Replace rotations θ in `rows`, in local axes and in place, by ω + R(θ - ω).

    ω is the rotation of the element's plane, and R turns the surface's normal at the node to the
    element's normal. Bending and twisting rotations then agree between elements at a node although
    their planes differ, and do not mix with drilling. The drilling component is taken about the
    mean of both normals: as the rotation of a bent surface changes tangentially between the
    element's centre and the node, its component along this mean is of third order.
    """
    n, nodes = local.shape[:2]
    x, y, z = np.moveaxis(normals, 2, 0)
    cross = np.zeros((n, nodes, 3, 3))  # matrices of the cross product with normal × e3
    cross[..., 0, 2], cross[..., 2, 0] = -x, x
    cross[..., 1, 2], cross[..., 2, 1] = -y, y
    turn = np.eye(3) + cross + cross @ cross / (1.0 + z)[..., None, None]
    turn[..., 2, :] = unit(normals + np.array([0.0, 0.0, 1.0]))
    if nodes == 3:
        slopes = np.linalg.inv(local[:, 1:, :2] - local[:, :1, :2]) @ _LINEAR
    else:
        along = _bilinear(np.zeros((1, 2)))[1][0]
        slopes = np.linalg.inv(along @ local[..., :2]) @ along
    plane = np.zeros((n, 3, nodes, 3))  # ω due to unit nodal displacements
    plane[:, 0, :, 2], plane[:, 1, :, 2] = slopes[:, 1], -slopes[:, 0]
    plane[:, 2, :, 0], plane[:, 2, :, 1] = -0.5 * slopes[:, 1], 0.5 * slopes[:, 0]
    by_rotation = rows[..., 1, :].reshape(n, -1, 3 * nodes)
    left = by_rotation @ (np.eye(3) - turn).reshape(n, 3 * nodes, 3)
    rows[..., 0, :] += (left @ plane.reshape(n, 3, -1)).reshape(rows[..., 0, :].shape)
    rows[..., 1, :] = np.einsum("nqsai,naij->nqsaj", rows[..., 1, :], turn)


def _stiffness(layers: Layers) -> FloatArray:
    """Return the stiffness matrix C of the nine strains, shape (9, 9)."""
    matrix = np.zeros((9, 9))
    matrix[:8, :8] = layers.stiffness
    matrix[8, 8] = _DRILLING * _mean_membrane(matrix)[1]
    return matrix


def _mean_membrane(stiffness: FloatArray) -> tuple[float, float]:
    """Return the membrane's Poisson ratio and shear stiffness, N/m, averaged over directions."""
    direct = float(stiffness[0, 0] + stiffness[1, 1])
    across, shear = float(stiffness[0, 1]), float(stiffness[2, 2])
    ratio = (direct + 6.0 * across - 4.0 * shear) / (3.0 * direct + 2.0 * across + 4.0 * shear)
    return ratio, (direct - 2.0 * across + 4.0 * shear) / 8.0


def _condensed(
    rows: FloatArray, inner: FloatArray, stiffness: FloatArray, weights: FloatArray
) -> FloatArray:
    """Return strain matrices of nodal dofs alone; inner dofs, free of forces, are condensed."""
    force = weights[..., None, None] * (stiffness @ inner)
    n, dofs = len(rows), inner.shape[-1]
    force = force.reshape(n, -1, dofs).swapaxes(1, 2)
    own = force @ inner.reshape(n, -1, dofs)
    moved = np.linalg.solve(own, force @ rows.reshape(n, -1, rows.shape[-1]))
    condensed: FloatArray = rows - inner @ moved[:, None]
    return condensed


def _bilinear(places: FloatArray) -> ArrayPair:
    """Return shape functions at (r, s), (points, 4), and r and s derivatives, (points, 2, 4)."""
    r, s = places[:, :1], places[:, 1:]
    a, b = 1.0 + r * _CORNERS[:, 0], 1.0 + s * _CORNERS[:, 1]
    return 0.25 * a * b, 0.25 * np.stack([_CORNERS[:, 0] * b, _CORNERS[:, 1] * a], axis=1)


def _areas(corners: FloatArray, normal: FloatArray) -> ArrayPair:
    """Return shape functions at quadrature points, and the points' areas in the mean plane, m²."""
    if corners.shape[1] == 3:
        edges = corners[:, 1:] - corners[:, :1]
        area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        return _AREAS, area[:, None] * _SHARES
    shape, slopes = _bilinear(_GAUSS * _CORNERS)
    along = np.einsum("qda,nai->nqdi", slopes, corners)
    return shape, np.einsum("nqi,ni->nq", np.cross(along[:, :, 0], along[:, :, 1]), normal)


def _plane_rows(slope: FloatArray, shape: FloatArray) -> FloatArray:
    """Return strain rows from slopes ∂N/∂x, ∂N/∂y, shape (n, points, 2, nodes), without shear.

    The result, shape (n, points, 9, nodes, 6), contains membrane, bending and drilling strains; the
    rows of transverse shear are zero.
    """
    rows = np.zeros((*slope.shape[:2], 9, slope.shape[-1], 6))
    x, y = slope[:, :, 0], slope[:, :, 1]
    rows[:, :, 0, :, 0] = rows[:, :, 2, :, 1] = x
    rows[:, :, 1, :, 1] = rows[:, :, 2, :, 0] = y
    rows[:, :, 3, :, 4], rows[:, :, 4, :, 3] = x, -y
    rows[:, :, 5, :, 4], rows[:, :, 5, :, 3] = y, -x
    rows[:, :, 8, :, 5] = shape
    rows[:, :, 8, :, 0], rows[:, :, 8, :, 1] = 0.5 * y, -0.5 * x
    return rows


def _quadrilateral(local: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return strain matrices of the nodal dofs and of the incompatible modes, and point areas."""
    plane = local[..., :2]
    shape, slopes = _bilinear(_GAUSS * _CORNERS)
    jacobian = np.einsum("qda,nai->nqdi", slopes, plane)  # rows are along r and s
    area = np.linalg.det(jacobian)
    inverse = np.linalg.inv(jacobian)
    rows = _plane_rows(inverse @ slopes, shape)
    # MITC4: shear along r is interpolated from s = ±1, shear along s from r = ±1.
    across = _covariant(plane, np.array([(0.0, 1.0), (0.0, -1.0)]), 0)
    along = _covariant(plane, np.array([(1.0, 0.0), (-1.0, 0.0)]), 1)
    r, s = _GAUSS * _CORNERS.T
    share = np.stack([[1.0 + s, 1.0 - s], [1.0 + r, 1.0 - r]]) / 2.0  # (direction, tied, point)
    tied = np.einsum("dtq,ndtx->nqdx", share, np.stack([across, along], axis=1))
    rows[:, :, 6:8] = (inverse @ tied).reshape(len(local), 4, 2, 4, 6)
    # Incompatible modes 1 - r² and 1 - s² of u and v, with the Jacobian at the centre.
    middle = np.linalg.inv(np.einsum("da,nai->ndi", _bilinear(np.zeros((1, 2)))[1][0], plane))
    centre = 1.0 / np.linalg.det(middle)
    modes = -2.0 * np.stack([np.stack([r, 0 * s]), np.stack([0 * r, s])])  # (mode, direction, q)
    slope = np.einsum("nij,mjq->nqim", middle, modes) * (centre[:, None] / area)[..., None, None]
    inner = np.zeros((len(local), 4, 9, 4))
    inner[:, :, 0, :2] = inner[:, :, 2, 2:] = slope[:, :, 0]
    inner[:, :, 1, 2:] = inner[:, :, 2, :2] = slope[:, :, 1]
    return rows.reshape(len(local), 4, 9, 24), inner, area


def _covariant(plane: FloatArray, places: FloatArray, direction: int) -> FloatArray:
    """Return rows of the covariant shear ∂w/∂d + ∂x/∂d·(θy, -θx), d = r or s: (n, places, 24)."""
    shape, slopes = _bilinear(places)
    slope = slopes[:, direction]
    edge = np.einsum("qa,nai->nqi", slope, plane)
    rows = np.zeros((len(plane), len(places), 4, 6))
    rows[..., 2] = slope
    rows[..., 3] = -edge[..., 1:] * shape
    rows[..., 4] = edge[..., :1] * shape
    return rows.reshape(len(plane), len(places), 24)


def _triangle(
    local: FloatArray, stiffness: FloatArray, flatness: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return strain matrices of the nodal dofs and of the bubble rotations, and point areas."""
    plane, n = local[..., :2], len(local)
    jacobian = plane[:, 1:] - plane[:, :1]  # rows are along r and s
    inverse = np.linalg.inv(jacobian)
    area = 0.5 * np.linalg.det(jacobian)
    # Shape functions of rotations: h_i - f/3 for the nodes, and the bubble f = 27 h1 h2 h3.
    bubble = 27.0 * np.stack(
        [_AREAS[:, (i + 1) % 3] * _AREAS[:, (i + 2) % 3] for i in range(3)], axis=1
    )
    bent = bubble @ _LINEAR.T  # slopes of the bubble along r and s
    along = np.concatenate([_LINEAR - bent[..., None] / 3.0, bent[..., None]], axis=2)
    every = _plane_rows(inverse[:, None] @ along, np.column_stack([_AREAS, np.zeros(6)]))
    rows, inner = every[:, :, :, :3], every[:, :, :, 3, 3:5]
    slope = inverse @ _LINEAR
    rows[:, :, 8, :, 0], rows[:, :, 8, :, 1] = 0.5 * slope[:, None, 1], -0.5 * slope[:, None, 0]
    basic, higher = _optimal_membrane(plane, area, stiffness)
    basic[..., 2] *= flatness[:, None, None]
    higher *= flatness[:, None, None, None, None]
    rows[:, :, :3, :, [0, 1, 5]] = basic[:, None] + higher
    shear = _tied_shear(jacobian)  # (element, point, direction, node or bubble, dof)
    shear = np.einsum("nij,nqjak->nqiak", inverse, shear)
    rows[:, :, 6:8], inner[:, :, 6:8] = shear[..., :3, :], shear[..., 3, 3:5]
    return rows.reshape(n, len(_AREAS), 9, 18), inner, area[:, None] * _SHARES


def _tied_shear(jacobian: FloatArray) -> FloatArray:
    """Return rows of MITC3+'s covariant shear strains at q points: (n, q, 2, nodes + bubble, 6)."""
    d = 1e-4
    third, sixth = 1.0 / 3.0, 1.0 / 6.0
    places = np.array(
        [
            *((sixth, 4.0 * sixth), (4.0 * sixth, sixth), (sixth, sixth)),
            *((third + d, third - 2.0 * d), (third - 2.0 * d, third + d), (third + d, third + d)),
        ]
    )
    h = np.column_stack([1.0 - places.sum(axis=1), places])
    bubble = 27.0 * h.prod(axis=1, keepdims=True)
    shape = np.column_stack([h - bubble / 3.0, bubble])
    at = np.zeros((len(jacobian), len(places), 2, 4, 6))
    at[..., :3, 2] = _LINEAR
    at[..., 3] = -jacobian[:, None, :, 1:] * shape[:, None]
    at[..., 4] = jacobian[:, None, :, :1] * shape[:, None]
    (ra, rb, rc, rd, _, rf), (sa, sb, sc, _, se, sf) = at.transpose(2, 1, 0, 3, 4)
    twist = third * (rf - rd - sf + se)
    along_r = 2.0 * third * (rb - 0.5 * sb) + third * (rc + sc)
    along_s = 2.0 * third * (sa - 0.5 * ra) + third * (rc + sc)
    r, s = _AREAS[:, 1, None, None, None], _AREAS[:, 2, None, None, None]
    tied = [along_r + (3.0 * s - 1.0) * twist, along_s + (1.0 - 3.0 * r) * twist]
    return np.stack(tied, axis=1).transpose(2, 0, 1, 3, 4)


def _optimal_membrane(plane: FloatArray, area: FloatArray, stiffness: FloatArray) -> ArrayPair:
    """Return matrices from nodal (u, v, θz) to basic (constant) and higher-order membrane strains.

    Shapes (n, 3, 3 nodes, 3) and (n, points, 3, 3 nodes, 3). The higher-order strains are linear
    with zero mean.
    """
    beta = max(0.5 - 2.0 * _mean_membrane(stiffness)[0] ** 2, 0.01)
    # x[:, i, j] = x_i - x_j; (i, j, k) are cyclic permutations, and edge i goes from i to j.
    x, y = (plane[:, :, None, d] - plane[:, None, :, d] for d in (0, 1))
    i, j, k = np.arange(3), np.array([1, 2, 0]), np.array([2, 0, 1])
    basic = np.zeros((len(plane), 3, 3, 3))  # (element, strain, node, dof)
    basic[:, 0, :, 0] = basic[:, 2, :, 1] = 0.5 * y[:, j, k]
    basic[:, 1, :, 1] = basic[:, 2, :, 0] = 0.5 * x[:, k, j]
    basic[:, 0, :, 2] = 0.125 * y[:, j, k] * (y[:, i, k] - y[:, j, i])
    basic[:, 1, :, 2] = 0.125 * x[:, k, j] * (x[:, k, i] - x[:, i, j])
    basic[:, 2, :, 2] = 0.25 * (x[:, k, i] * y[:, i, k] - x[:, i, j] * y[:, j, i])
    basic /= area[:, None, None, None]
    # Corner rotations minus the mean rotation, and the natural strains that they cause along edges.
    beyond = np.zeros((len(plane), 3, 3, 3))  # (element, corner, node, dof)
    beyond[..., 0], beyond[..., 1] = x[:, None, k, j], y[:, None, k, j]
    beyond[..., :2] /= 4.0 * area[:, None, None, None]
    beyond[:, i, i, 2] = 1.0
    cartesian = np.stack(
        [
            y[:, j, k] * y[:, i, k],
            x[:, j, k] * x[:, i, k],
            y[:, j, k] * x[:, k, i] + x[:, k, j] * y[:, i, k],
        ],
        axis=1,
    )
    natural = np.einsum("qp,pec->qec", _AREAS, _NATURAL)
    higher = np.einsum("nse,qec,ncaf->nqsaf", cartesian, natural, beyond)
    higher *= (0.25 * np.sqrt(beta) / area)[:, None, None, None, None]
    return basic, higher
