"""Hertz's law from the surfaces of two bodies."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import aoimpact as ao
from aoimpact.contact import ContactSurface
from aoimpact.laws import law_between

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.33, rho=2700)


def test_meshed_ball_on_a_plate() -> None:
    ball = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, 0.003), STEEL)
    plate = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.1, 0.01), (8, 8, 2)), ALUMINIUM)
    one = ball.contact(point=(0.0, 0.0, -0.01), direction=(0, 0, -1)).contact_surface
    two = plate.contact(point=(0.05, 0.05, 0.01)).contact_surface
    assert one is not None
    assert two is not None
    found = law_between(one, two)
    expected = ao.Hertz.between(STEEL, 0.01, ALUMINIUM, math.inf)
    assert found.law.k == pytest.approx(expected.k, rel=found.error)
    assert found.error < 0.01


def curved(
    first: float,
    second: float,
    turn: float = 0.0,
    *,
    error: float = 0.0,
    material: ao.Material = STEEL,
    framed: bool = True,
) -> ContactSurface:
    """Radii, and the first direction at an angle to x in the plane z = 0."""
    c, s = math.cos(turn), math.sin(turn)
    directions = ((c, s, 0.0), (-s, c, 0.0)) if framed else None
    return ContactSurface(material, (1.0 / first, 1.0 / second), directions, error)


DOWN = (0.0, 0.0, -1.0)


@given(
    st.floats(0.001, 0.1),
    st.floats(0.001, 0.1),
    st.floats(0.001, 0.1),
    st.floats(0.001, 0.1),
    st.floats(0.0, math.pi),
    st.floats(0.0, math.pi),
)
def test_two_ellipsoids_at_any_angle(
    a: float, b: float, c: float, d: float, turn: float, other: float
) -> None:
    found = law_between(
        curved(a, b, turn),
        curved(c, d, other, material=ALUMINIUM),
        projectile_direction=DOWN,
        target_direction=(0.01, 0.0, -1.0),
    )
    expected = ao.Hertz.between(STEEL, (a, b), ALUMINIUM, (c, d), angle=turn - other)
    assert found.law.k == pytest.approx(expected.k, rel=1e-9)
    assert found.law.relative_radius == pytest.approx(expected.relative_radius, rel=1e-9)


@pytest.mark.parametrize(
    ("one", "two", "directions"),
    [
        (curved(0.01, 0.02), curved(0.01, 0.02), (None, None)),
        (curved(0.01, 0.02), curved(0.01, 0.02), (DOWN, (0.0, 1.0, 0.0))),
        (curved(0.01, 0.02, framed=False), curved(0.01, 0.02), (DOWN, DOWN)),
    ],
)
def test_an_angle_that_is_needed_and_not_known(
    one: ContactSurface, two: ContactSurface, directions: tuple[Any, Any]
) -> None:
    with pytest.raises(ao.InputError, match=r"^surfaces"):
        law_between(one, two, projectile_direction=directions[0], target_direction=directions[1])


def test_nearly_round_surfaces_need_no_angle() -> None:
    one, two = curved(0.01, 0.0104), curved(0.02, 0.0206)
    found = law_between(one, two)
    for angle in (0.0, 0.5, math.pi / 2):
        k = ao.Hertz.between(STEEL, (0.01, 0.0104), STEEL, (0.02, 0.0206), angle=angle).k
        assert found.law.k == pytest.approx(k, rel=found.error)
    assert found.error < 0.01


@pytest.mark.parametrize("error", [0.1, 3.0, 30.0])
def test_the_error_holds_what_the_curvatures_may_be(error: float) -> None:
    """A ball on a shallow barrel whose curvatures are wrong by as much as they may be."""
    found = law_between(curved(0.01, 0.01), curved(0.02, 0.2, error=error))
    for shift in (-error, error):
        radii = (1.0 / (1 / 0.02 + shift), 1.0 / (1 / 0.2 + shift))
        k = ao.Hertz.between(STEEL, 0.01, STEEL, radii).k
        assert abs(k / found.law.k - 1.0) <= found.error + 1e-12
    assert found.error < 0.01 * error


def test_a_curvature_less_than_its_error_is_flat() -> None:
    flat = ContactSurface(STEEL, (0.9, -0.5), None, 1.0)
    found = law_between(curved(0.01, 0.01), flat)
    assert found.law.k == ao.Hertz.between(STEEL, 0.01, STEEL, math.inf).k
    assert found.error == pytest.approx(0.5 / 100, rel=0.02)


def test_curvatures_that_a_mesh_does_not_show_are_the_first_to_mend() -> None:
    """A ball on a torus of few elements: each touches the other in a point, if it is round."""
    ball = ContactSurface(STEEL, (125.0, 125.0))
    with pytest.raises(ao.InputError, match=r"^surfaces") as no:
        law_between(ball, ContactSurface(STEEL, (165.0, 23.0), error=190.0))
    assert "do not touch" not in str(no.value)
    with pytest.raises(ao.InputError, match=r"^surfaces") as no:
        law_between(ball, ContactSurface(STEEL, (-150.0, -150.0)))
    assert "refine" not in str(no.value)


def test_the_ellipse_of_contact_carries_the_pressure_that_closes_the_gap() -> None:
    """Boussinesq's displacement under Hertz's pressure is δ - A x² - B y² (Johnson, eq. 4.21)."""
    law = ao.Hertz.between(STEEL, 0.05, STEEL, (0.003, math.inf))
    hit = ao.simulate(ao.ball(0.05, STEEL), ao.rigid(1e3), 0.1, law=law)
    area, squeeze = hit.contact_radius**2, (1.0 - law.eccentricity**2) ** 0.25
    a, b = hit.contact_radius / squeeze, hit.contact_radius * squeeze
    assert hit.hertz_pressure == pytest.approx(1.5 * hit.peak_force / (math.pi * area))
    modulus = 0.5 * STEEL.plane_strain_modulus
    depth = (hit.peak_force / law.k) ** (2.0 / 3.0)
    angles = (np.arange(400) + 0.5) * math.pi / 200
    along = np.stack([np.cos(angles) / a, np.sin(angles) / b])
    # Half the curvatures of ball and cylinder, across the cylinder (y) and along it (x).
    for x, y, A, B in (
        (0.0, 0.0, 10.0, 0.0),
        (0.6, 0.0, 10.0, 0.0),
        (0.0, 0.6, 0.0, 10.0 + 500.0 / 3.0),
    ):
        # ∫ p dr along each ray from (x a, y b): p² = p₀² (c - 2 d r - e r²), r ≥ 0.
        c, d, e = 1.0 - x * x - y * y, np.array([x, y]) @ along, (along**2).sum(axis=0)
        root = d**2 + e * c
        ray = 0.5 * (root / e**1.5 * np.arccos(d / np.sqrt(root)) - d * np.sqrt(c) / e)
        sunk = hit.hertz_pressure / (math.pi * modulus) * ray.mean() * 2.0 * math.pi
        assert sunk == pytest.approx(depth - A * (x * a) ** 2 - B * (y * b) ** 2, rel=1e-4)
