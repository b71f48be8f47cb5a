"""A patch carries Hertz's pressure: its moments, its mean displacement, on any mesh."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.integrate
from bodies import distorted_box

from aoimpact import InputError, box_mesh, sphere_mesh
from aoimpact.contact import spread
from aoimpact.mesh import KINDS, boundary

UP = np.array([0.0, 0.0, 1.0])


def pressed_mean(f: object, r: float) -> float:
    """Mean of f(ρ) under the pressure √(1 - ρ²/r²), by SciPy."""
    weight = lambda s: s * math.sqrt(1.0 - s * s)  # noqa: E731
    above, _ = scipy.integrate.quad(lambda s: f(r * s) * weight(s), 0.0, 1.0)  # type: ignore[operator]
    return float(above / scipy.integrate.quad(weight, 0.0, 1.0)[0])


@pytest.mark.parametrize("kind", KINDS)
def test_weights_sum_to_one_with_their_centre_at_the_point(kind: str) -> None:
    mesh = distorted_box(kind)
    for point, radius in (([1.1, 0.7, 1.0], 0.6), ([0.4, 1.1, 1.0], 0.25)):
        weights = spread(boundary(mesh), np.array(point), UP, radius).weights
        assert weights.sum() == pytest.approx(1.0, rel=1e-14)
        np.testing.assert_allclose(weights @ mesh.nodes, point, atol=1e-14)


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20", "hexahedron27"])
def test_second_moments_are_those_of_hertz_s_pressure(kind: str) -> None:
    # Quadratic elements hold x² exactly, and the mean of ρ² is 2r²/5.
    mesh = box_mesh((2.0, 1.5, 1.0), (5, 4, 2), kind=kind)
    point, radius = np.array([0.93, 0.71, 1.0]), 0.57
    weights = spread(boundary(mesh), point, UP, radius).weights
    x, y, _ = (mesh.nodes - point).T
    fifth = 0.2 * radius**2
    np.testing.assert_allclose(weights @ np.stack([x * x, y * y, x * y], axis=1),
                               [fifth, fifth, 0.0], rtol=1e-13, atol=1e-15)  # fmt: skip


def test_each_node_s_share_is_the_integral_of_its_shape_function() -> None:
    # Bilinear hats on squares of side h, integrated in polar coordinates without regard to faces.
    mesh, h = box_mesh((1.0, 1.0, 0.2), (5, 5, 1)), 0.2
    point, radius = np.array([0.53, 0.46, 0.2]), 0.31
    found = spread(boundary(mesh), point, UP, radius).weights
    x, w = np.polynomial.legendre.leggauss(600)
    sink = 0.5 * (1.0 + x)  # √(1 - ρ²/r²)
    rho, share = radius * np.sqrt(1.0 - sink**2), 1.5 * w * sink**2
    angle = 2.0 * math.pi * np.arange(600) / 600
    places = point[:2] + (rho[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    for node in np.flatnonzero((mesh.nodes[:, 2] == 0.2) & (found > 0.0)):
        hat = np.clip(1.0 - np.abs(places - mesh.nodes[node, :2]) / h, 0.0, None).prod(axis=-1)
        assert found[node] == pytest.approx(share @ hat.mean(axis=1), abs=2e-4)


@pytest.mark.parametrize("size", [0.5, 0.22])
def test_on_a_ball_the_centre_lies_on_the_normal_by_the_mean_sagitta(size: float) -> None:
    mesh = sphere_mesh(1.0, size)
    surface, radius = boundary(mesh), 0.4
    for toward in ([1.0, 0.0, 0.0], [0.48, -0.6, 0.64]):
        point = surface.nearest(np.array(toward)).x[0]
        found = spread(surface, point, np.array(toward), radius)
        sunk = pressed_mean(lambda rho: 1.0 - math.sqrt(1.0 - rho * rho), radius)
        centre = found.weights @ mesh.nodes - point
        np.testing.assert_allclose(np.cross(centre, found.normal), 0.0, atol=1e-14)
        assert -centre @ found.normal == pytest.approx(sunk, rel=0.02)
        assert found.normal @ toward > 1.0 - 1e-5


def test_a_patch_is_refused_where_a_ball_turns_away() -> None:
    surface = boundary(sphere_mesh(1.0, 0.33))
    with pytest.raises(InputError, match=r"^radius"):
        spread(surface, np.array([0.0, 0.0, 1.0]), UP, 0.8)
