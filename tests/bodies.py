"""Materials, meshes and motions that several tests share."""

from __future__ import annotations

import warnings
from itertools import permutations, product

import numpy as np
import numpy.typing as npt

from aoimpact import AOImpactWarning, Material, Mesh, box_mesh
from aoimpact.mesh import reference_element

FloatArray = npt.NDArray[np.float64]


def no_solid(E: float = 1.0, rho: float = 1.0, nu: float = 0.3) -> Material:
    """Return a material outside the range of solids without the warning, by default E = ρ = 1."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AOImpactWarning)
        return Material(E=E, nu=nu, rho=rho)


_ORDERS = [tuple(1 + axis for axis in order) for order in permutations(range(3))]
_OCTANTS = np.array(list(product((1.0, -1.0), repeat=3)))


def distorted_box(kind: str, lengths: tuple[float, float, float] = (2.0, 1.5, 1.0)) -> Mesh:
    """A box of elements of `kind` with randomly displaced nodes, including midside nodes.

    Nodes on a face move within the face, so that the box keeps its shape. Second-order elements
    become curved.
    """
    mesh = box_mesh(lengths, (2, 2, 2), kind=kind)
    rng = np.random.default_rng(7)
    spacing = np.array(lengths) / 2
    reach = 0.05 if kind.startswith("pyramid") else 0.09  # pyramids are half as high as a brick
    push = reach * spacing * rng.uniform(-1.0, 1.0, mesh.nodes.shape)
    for axis, length in enumerate(lengths):
        on_face = (mesh.nodes[:, axis] == 0.0) | (np.abs(mesh.nodes[:, axis] - length) < 1e-12)
        push[on_face, axis] = 0.0
    return Mesh(mesh.nodes + push, mesh.cells, mesh.kind, mesh.node_sets)


def mixed_box(
    lengths: tuple[float, float, float], counts: tuple[int, int, int], *, order: int = 1
) -> Mesh:
    """A box with bricks and wedges below, and tetrahedra above.

    In the layer between, pyramids and tetrahedra meet at the centre of each brick. The groups are
    "low" (bricks), "wedges", "middle" and "high".
    """
    found: dict[str, list[FloatArray]] = {}
    groups: dict[str, list[tuple[str, int]]] = {}
    for brick in product(*map(range, counts)):
        for kind, group, piece in _pieces_of(brick, counts):
            name = kind + _SECOND[kind] if order == 2 else kind
            cells = found.setdefault(name, [])
            groups.setdefault(group, []).append((name, len(cells)))
            element = reference_element(name)
            cells.append(8.0 * (element.linear.shape(element.nodes) @ (piece + brick)))
    places = np.rint(np.concatenate([np.concatenate(cells) for cells in found.values()]))
    grid, number = np.unique(places, axis=0, return_inverse=True)
    blocks, first, done = [], {}, 0
    for name, cells in found.items():
        shape = len(cells), reference_element(name).n_nodes
        first[name] = sum(len(block) for _, block in blocks)
        blocks.append((name, number.ravel()[done : done + shape[0] * shape[1]].reshape(shape)))
        done += shape[0] * shape[1]
    cell_sets = {group: [first[name] + i for name, i in of] for group, of in groups.items()}
    nodes = grid * (np.array(lengths) / (8.0 * np.array(counts)))
    sides = {
        f"{axis}{side}": np.flatnonzero(nodes[:, i] == value)
        for i, axis in enumerate("xyz")
        for side, value in (("min", 0.0), ("max", nodes[:, i].max()))
    }
    return Mesh(nodes, blocks, "mixed", sides, cell_sets)


_SECOND = {"tetra": "10", "hexahedron": "20", "wedge": "15", "pyramid": "13"}


def _pieces_of(
    brick: tuple[int, ...], counts: tuple[int, ...]
) -> list[tuple[str, str, FloatArray]]:
    """The elements that fill a brick: kind, group and corners, with coordinates from 0 to 1."""
    middle = counts[2] // 2
    wedges = brick[0] >= counts[0] // 2
    if brick[2] > middle:
        return [("tetra", "high", piece) for piece in _of_brick("tetra")]
    if brick[2] < middle:
        kind, group = ("wedge", "wedges") if wedges else ("hexahedron", "low")
        return [(kind, group, piece) for piece in _of_brick(kind)]
    found = []
    for piece in _of_brick("pyramid"):
        below, above = (piece[:4, 2] == 0.0).all(), (piece[:4, 2] == 1.0).all()
        if (below and wedges and middle > 0) or (above and brick[2] < counts[2] - 1):
            # Faces of tetrahedra above have the diagonal from (0, 0), those of wedges the other.
            start = int(np.flatnonzero(piece[:4, :2].sum(axis=1) == (1.0 if below else 0.0))[0])
            base = np.roll(piece[:4], -start, axis=0)
            apex = piece[4:]
            found += [
                ("tetra", "middle", np.vstack([base[[0, 1, 2]], apex])),
                ("tetra", "middle", np.vstack([base[[0, 2, 3]], apex])),
            ]
        else:
            found.append(("pyramid", "middle", piece))
    return found


def _of_brick(kind: str) -> FloatArray:
    return reference_element(kind).cell.of_brick


def interior(mesh: Mesh) -> npt.NDArray[np.bool_]:
    """Mask of the nodes of a box that lie on no face."""
    inside = np.ones(mesh.n_nodes, dtype=bool)
    for members in mesh.node_sets.values():
        inside[members] = False
    return inside


def rigid_motions(nodes: FloatArray) -> FloatArray:
    """Unit translations, and small rotations about axes through the origin, (3 n_nodes, 6)."""
    columns = [np.tile(axis, (len(nodes), 1)) for axis in np.eye(3)]
    columns += [np.cross(axis, nodes) for axis in np.eye(3)]
    return np.stack([column.reshape(-1) for column in columns], axis=1)


def ball_of_octants(radius: float, n: int) -> Mesh:
    """A ball of 8 n³ tetra10 elements: an octahedron of n layers, mapped to the ball.

    Each octant is a tetrahedron divided by Kuhn's scheme. The numbers of nodes lie between those of
    `sphere_mesh`.
    """
    grid = np.array(np.meshgrid(*[np.arange(n)] * 3, indexing="ij")).reshape(3, -1).T
    paths = np.stack([np.cumsum(np.eye(4, 3, -1)[[0, *order]], axis=0) for order in _ORDERS])
    kuhn = (grid[:, None, None] + paths).reshape(-1, 4, 3)
    x, y, z = np.moveaxis(kuhn[(kuhn[..., :2] >= kuhn[..., 1:]).all(axis=(1, 2))], 2, 0)
    octant = np.stack([x - y, y - z, z], axis=-1)
    corners = np.concatenate([octant * signs for signs in _OCTANTS])
    flipped = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    corners[flipped] = corners[flipped][:, [0, 2, 1, 3]]
    edges = corners[:, [0, 1, 0, 0, 1, 2]] + corners[:, [1, 2, 2, 3, 3, 3]]
    lattice = np.concatenate([2.0 * corners, edges], axis=1)
    nodes, cells = np.unique(lattice.reshape(-1, 3), axis=0, return_inverse=True)
    layer = np.abs(nodes).sum(axis=1, keepdims=True)
    bent = np.sin(0.5 * np.pi * nodes / np.maximum(layer, 1.0))
    bent *= layer / (2 * n) / np.maximum(np.linalg.norm(bent, axis=1, keepdims=True), 1e-9)
    return Mesh(radius * bent, cells.reshape(-1, 10), "tetra10")
