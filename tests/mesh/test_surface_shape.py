"""Curvatures from the nodes of a mesh against those of the surface that was meshed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rows import each

import aoimpact as ao
from aoimpact.mesh import KINDS, Mesh, SurfaceShape, boundary, box_mesh, surface_shape

FloatArray = npt.NDArray[np.float64]
Surface = Callable[[FloatArray, FloatArray], FloatArray]
ORIGIN = np.zeros(2)


def sphere(u: FloatArray, v: FloatArray) -> FloatArray:
    x = np.stack([u, v, np.ones_like(u)], axis=-1)
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def cylinder(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.stack([np.sin(u), v, np.cos(u)], axis=-1)


def bore(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.stack([-np.sin(u), v, np.cos(u)], axis=-1)


def torus(around: float) -> Surface:
    """Tube of radius 1 about a circle of radius 2.5, at an angle from the outermost circle."""

    def at(u: FloatArray, v: FloatArray) -> FloatArray:
        ring = 2.5 + np.cos(u + around)
        x = [ring * np.cos(v / 2.5), -ring * np.sin(v / 2.5), np.sin(u + around)]
        return np.stack(x, axis=-1)

    return at


def ellipsoid(u: FloatArray, v: FloatArray) -> FloatArray:
    return sphere(u - 0.4, v + 0.3) * np.array([2.0, 1.4, 1.0])


def of_ellipsoid(point: FloatArray) -> FloatArray:
    """Σ (x/a)² = 1: the Hessian across the gradient, over the gradient's length."""
    squares = np.array([2.0, 1.4, 1.0]) ** -2.0
    gradient = squares * point
    across = np.linalg.svd(gradient[None])[2][1:]
    bend = across @ np.diag(squares) @ across.T / np.linalg.norm(gradient)
    return np.linalg.eigvalsh(bend)[::-1]


def ring_curvatures(around: float) -> FloatArray:
    return np.array([1.0, np.cos(around) / (2.5 + np.cos(around))])


SHAPES: dict[str, tuple[Surface, FloatArray]] = {
    "sphere": (sphere, np.ones(2)),
    "cylinder": (cylinder, np.array([1.0, 0.0])),
    "bore": (bore, np.array([0.0, -1.0])),
    "torus outside": (torus(0.0), ring_curvatures(0.0)),
    "torus top": (torus(np.pi / 2), ring_curvatures(np.pi / 2)),
    "torus oblique": (torus(2.4), ring_curvatures(2.4)),
    "torus saddle": (torus(np.pi), ring_curvatures(np.pi)),
    "ellipsoid": (ellipsoid, of_ellipsoid(ellipsoid(*ORIGIN))),
}


def shell(kind: str, surface: Surface, size: float, n: int, seed: int = 1) -> Mesh:
    """Elements of uneven sides, all nodes on the surface, about the point (0, 0) of it."""
    box = box_mesh((1.0, 1.0, 1.0), (n, n, 1), kind=kind)
    u, v, w = box.nodes.T
    rng = np.random.default_rng(seed)
    a, b, c, d = rng.uniform(0.0, 2 * np.pi, 4)
    u, v = size * n * (u - 0.5), size * n * (v - 0.5)
    u, v = (
        u + 0.1 * size * np.sin(1.7 * v / size + a) + 0.1 * size * np.sin(0.9 * u / size + b),
        v + 0.1 * size * np.sin(1.3 * u / size + c) + 0.1 * size * np.sin(1.1 * v / size + d),
    )
    e = 1e-6
    outward = np.cross(surface(u + e, v) - surface(u - e, v), surface(u, v + e) - surface(u, v - e))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    nodes = surface(u, v) - 0.3 * (1.0 - w)[:, None] * outward
    return Mesh(nodes, box.cells, kind)


def found(kind: str, surface: Surface, size: float, n: int = 10, seed: int = 1) -> SurfaceShape:
    return surface_shape(boundary(shell(kind, surface, size, n, seed)), surface(*ORIGIN))


@each("shape", SHAPES)
@each("kind", KINDS[:5])  # of whose sides those of the others are made
def test_eight_elements_a_radius(kind: str, shape: str) -> None:
    surface, expected = SHAPES[shape]
    at = found(kind, surface, 0.125)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(at.curvatures, expected, atol=0.02 * scale)
    assert np.abs(at.curvatures - expected).max() < at.error < 0.02 * scale
    frame = np.vstack([at.directions, at.normal])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)


def test_directions_and_normal() -> None:
    along, around = found("tetra10", cylinder, 0.125).directions[::-1]
    assert abs(along[1]) == pytest.approx(1.0, abs=1e-6)
    assert abs(around[0]) == pytest.approx(1.0, abs=1e-4)
    np.testing.assert_allclose(found("tetra10", cylinder, 0.125).normal, [0, 0, 1], atol=1e-4)


@pytest.mark.slow
@each("kind", ["tetra", "tetra10", "hexahedron", "hexahedron20"])
def test_the_error_is_honest_on_coarse_meshes(kind: str) -> None:
    """From one element a radius on; of few elements, shells end near the place, too."""
    ratio = []
    for surface, expected in SHAPES.values():
        for size in (1 / 4, 1 / 3, 1 / 2, 1 / 1.4):
            for n in (3, 4, 7):
                if n * size < 2.0:
                    at = found(kind, surface, size, n, seed=n)
                    ratio.append(np.abs(at.curvatures - expected).max() / at.error)
    assert len(ratio) >= 40
    assert np.mean(np.array(ratio) < 1.0) >= 0.95
    assert max(ratio) < 2.0


@pytest.mark.slow
@each("kind", ["tetra", "tetra10"])
def test_the_error_is_honest_on_cylinders_of_nodes_in_rows(kind: str) -> None:
    """As mesh generators put them, on facets of straight edges anywhere between these nodes."""
    ratio = []
    rng = np.random.default_rng(5)
    for across in (2.0, 2.5, 3.0, 3.5, 4.0) if kind == "tetra" else (1.5, 2.0, 2.5):
        box = box_mesh((1.0, 1.0, 0.3), (round(2 * across), round(2 * across), 1), kind=kind)
        u, v, depth = (box.nodes - [0.5, 0.5, 0.3]).T * np.array([[2.0], [2.0], [1.0]])
        nodes = cylinder(u, v) * np.stack([1.0 + depth, np.ones_like(u), 1.0 + depth], axis=1)
        surface = boundary(Mesh(nodes, box.cells, kind))
        for place in rng.uniform(-0.4, 0.4, (20, 2)):
            at = surface_shape(surface, cylinder(*place))
            ratio.append(np.abs(at.curvatures - [1.0, 0.0]).max() / at.error)
    assert np.mean(np.array(ratio) < 1.0) >= 0.95
    assert max(ratio) < 2.0


@each("noise", [1e-4, 1e-3, 1e-2])
@each("kind", ["tetra", "hexahedron20"])
def test_noise_in_the_nodes_is_seen(kind: str, noise: float) -> None:
    ratio, error = [], []
    for seed in range(6):
        mesh = shell(kind, sphere, 0.125, 10, seed)
        shift = noise * 0.125 * np.random.default_rng(seed).normal(size=mesh.nodes.shape)
        at = surface_shape(boundary(Mesh(mesh.nodes + shift, mesh.cells, kind)), sphere(*ORIGIN))
        ratio.append(np.abs(at.curvatures - 1.0).max() / at.error)
        error.append(at.error)
    assert max(ratio) < 1.0
    # The noise alone of a single node would be 8 noise/size.
    assert np.median(error) < 0.002 + 64 * noise


@settings(max_examples=8)
@given(
    st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(
        lambda q: np.linalg.norm(q) > 0.1
    ),
    st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3),
    st.floats(1e-3, 1e3),
)
def test_turned_moved_and_scaled(q: list[float], by: list[float], scale: float) -> None:
    w, x, y, z = np.array(q) / np.linalg.norm(q)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    mesh = shell("tetra10", ellipsoid, 0.125, 8)
    here = surface_shape(boundary(mesh), ellipsoid(*ORIGIN))
    nodes = scale * (mesh.nodes @ turn.T + by)
    there = surface_shape(
        boundary(Mesh(nodes, mesh.cells, mesh.kind)), scale * (turn @ ellipsoid(*ORIGIN) + by)
    )
    np.testing.assert_allclose(scale * there.curvatures, here.curvatures, atol=0.1 * here.error)
    assert scale * there.error == pytest.approx(here.error, rel=0.1)
    np.testing.assert_allclose(there.normal, turn @ here.normal, atol=1e-5)
    across = there.directions @ turn @ here.directions.T
    np.testing.assert_allclose(np.abs(across), np.eye(2), atol=1e-3)


@each("divisions", [(1, 1, 1), (2, 3, 1), (50, 2, 2)])
@each("kind", KINDS)
def test_flat_is_flat(kind: str, divisions: tuple[int, int, int]) -> None:
    surface = boundary(box_mesh((1.0, 0.3, 0.2), divisions, kind=kind))
    for point in ([0.5, 0.15, 0.2], [0.31, 0.02, 0.2]):
        at = surface_shape(surface, np.array(point))
        np.testing.assert_array_equal(at.curvatures, 0.0)
        assert at.error < 1e-10


def test_flat_to_the_digits_of_a_file() -> None:
    mesh = box_mesh((0.1, 0.08, 0.01), (12, 10, 2), kind="tetra10")
    nodes = mesh.nodes + np.random.default_rng(3).normal(scale=1e-7, size=mesh.nodes.shape)
    at = surface_shape(boundary(Mesh(nodes, mesh.cells, mesh.kind)), np.array([0.05, 0.04, 0.01]))
    assert np.abs(at.curvatures).max() < at.error < 0.5  # a ball of 10 mm has 100


@each("kind", ["tetra", "hexahedron20"])
def test_what_is_at_the_point_and_not_what_is_near(kind: str) -> None:
    """A flat one and a half elements from where a rounding of radius 1 begins."""

    def rounded(u: FloatArray, v: FloatArray) -> FloatArray:
        angle = np.maximum(u - 0.3, 0.0)
        return np.stack([np.minimum(u, 0.3) + np.sin(angle), v, np.cos(angle) - 1.0], axis=-1)

    at = found(kind, rounded, 0.2)
    assert np.abs(at.curvatures).max() <= at.error < 0.05


def test_dimple() -> None:
    """z = -0.1 exp(-r²/0.25): hollow with 0.8 in the middle."""

    def dimple(u: FloatArray, v: FloatArray) -> FloatArray:
        return np.stack([u, v, -0.1 * np.exp(-(u**2 + v**2) / 0.25)], axis=-1)

    at = found("hexahedron20", dimple, 0.125, 16)
    assert np.abs(at.curvatures + 0.8).max() < at.error < 0.03


def test_straight_edges_of_second_order_lie_on_chords() -> None:
    """Nodes between the corners, where a mesher left them, say nothing of the curvature."""
    linear = boundary(shell("tetra", sphere, 0.2, 8))
    mesh = shell("tetra10", sphere, 0.2, 8)
    nodes = mesh.nodes.copy()
    for middle, ends in enumerate([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)], start=4):
        nodes[mesh.cells[:, middle]] = nodes[mesh.cells[:, ends]].mean(axis=1)
    straight = boundary(Mesh(nodes, mesh.cells, "tetra10"))
    point = linear.mesh.nodes[np.linalg.norm(linear.mesh.nodes - [0, 0, 1], axis=1).argmin()]
    one, two = surface_shape(linear, point), surface_shape(straight, point)
    assert np.abs(two.curvatures - 1.0).max() < two.error
    assert two.error < 2.0 * one.error


def test_nodes_beyond_a_sharp_edge_do_not_count() -> None:
    """The end of a cylinder, a quarter of an element from its rim."""
    surface = boundary(shell("hexahedron20", cylinder, 0.125, 8))
    rim = float(surface.mesh.nodes[:, 1].max())
    at = surface_shape(surface, np.array([0.0, rim - 0.05, 1.0]))
    assert np.abs(at.curvatures - [1.0, 0.0]).max() < at.error < 0.02
    with pytest.raises(ao.InputError, match=r"^point"):
        surface_shape(boundary(box_mesh((1, 1, 1), (4, 4, 4))), np.array([1.0, 0.5, 1.0]))
