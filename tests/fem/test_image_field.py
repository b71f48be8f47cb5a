"""The deflection of a half-space around a patch, and what a body adds to it."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.integrate
import scipy.special

from aoimpact.fem import image_field
from aoimpact.fem.material import Material
from aoimpact.fem.model import FEModel
from aoimpact.fem.patch import circle_means, half_space_deflection
from aoimpact.mesh.generate import box_mesh, sphere_mesh

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)


@pytest.mark.parametrize("k", [0.3, 0.85, 1.25, 3.0])
def test_the_deflection_is_that_of_boussinesq_s_point_loads(k: float) -> None:
    """By rings of the pressure: ∮ dθ/|x - y| = 4 K(m)/(ρ + t), m = 4ρt/(ρ + t)²."""

    def ring(t: float) -> float:
        m = 4.0 * k * t / (k + t) ** 2
        pressure = 1.5 / np.pi * np.sqrt(1.0 - t * t)
        return pressure * t * 4.0 * scipy.special.ellipk(m) / (k + t) / np.pi

    points = [k] if k < 1.0 else None
    direct = scipy.integrate.quad(ring, 0.0, 1.0, points=points, limit=200)[0]
    assert 0.6 * half_space_deflection(np.array([k]), 1.0)[0] == pytest.approx(direct, rel=1e-6)


def test_far_from_a_patch_it_is_a_point() -> None:
    far = np.array([50.0])
    of_patch = half_space_deflection(far, 1.0)
    assert half_space_deflection(far, 0.0) == pytest.approx(of_patch, rel=1e-3)


def test_means_over_circles_are_exact_for_what_elements_can_have() -> None:
    body = FEModel.from_mesh(box_mesh((0.04, 0.04, 0.01), (7, 6, 2), kind="hexahedron20"), STEEL)
    assert body.surface is not None
    assert body.nodes is not None
    point, radii = np.array([0.019, 0.022, 0.01]), np.array([0.004, 0.009, 0.03])
    means = circle_means(body.surface, point, np.array([0.0, 0.0, 1.0]), radii)
    assert len(means) == 2  # the third leaves the surface
    offset = body.nodes - point
    assert means @ (offset[:, :2] ** 2).sum(axis=1) == pytest.approx(radii[:2] ** 2)
    assert means @ offset[:, 0] == pytest.approx(0.0, abs=1e-12)


def test_of_a_ball_the_field_is_flat_and_the_remaining_compliance() -> None:
    """−2.04e-10 m/N, by an independent prototype, less its rigid motion at the frequency i s."""
    body = FEModel.from_mesh(sphere_mesh(0.01, 0.003), STEEL)
    tip = body.contact(point=(0.01, 0.0, 0.0), radius=0.002)
    s2 = (10.0 / 60e-6) ** 2
    x = body.inverse(s2).solve(tip.b)
    x -= body.rigid_modes @ (body.rigid_modes.T @ tip.b) / s2
    rho, field = image_field(tip, x, np.array([0.003, 0.004]))
    assert len(rho) == 2
    assert field == pytest.approx(-2.04e-10, rel=0.1)
