"""Hertz's contact of curved surfaces, from spheres to ellipsoids."""

import math

import pytest
import scipy.integrate
import scipy.optimize
from hypothesis import given
from hypothesis import strategies as st

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.3, rho=2400)
E_STAR = 210e9 / (2 * (1 - 0.3**2))


def test_hertz_between_two_spheres_is_equation_13():
    k = ao.Hertz.between(STEEL, 0.01, STEEL, 0.01).k
    assert k == pytest.approx(4 / 3 * 210e9 / (2 * (1 - 0.3**2)) * math.sqrt(0.01 / 2), rel=1e-15)
    assert k == pytest.approx(1.0878566e10, rel=1e-7)  # the paper prints 1e10


def test_hertz_between_ball_and_cup():
    k = ao.Hertz.between(STEEL, 0.01, STEEL, -0.012).k
    assert k == pytest.approx(4 / 3 * E_STAR * math.sqrt(1 / (1 / 0.01 - 1 / 0.012)), rel=1e-15)
    assert k == ao.Hertz.between(STEEL, -0.012, STEEL, 0.01).k


@given(st.floats(1e-4, 10.0), st.floats(1e-4, 10.0))
def test_equal_principal_radii_are_a_sphere(first, second):
    sphere = ao.Hertz.between(STEEL, first, ALUMINIUM, second).k
    pair = ao.Hertz.between(STEEL, (first, first), ALUMINIUM, (second, second), angle=0.7).k
    assert pair == pytest.approx(sphere, rel=1e-12)


def test_equal_cylinders_that_cross_at_right_angles_are_a_sphere_on_a_flat():
    crossed = ao.Hertz.between(STEEL, (0.01, math.inf), STEEL, (0.01, math.inf), angle=math.pi / 2)
    assert crossed.k == pytest.approx(ao.Hertz.between(STEEL, 0.01, STEEL, math.inf).k, rel=1e-12)


def by_quadrature(low, high):
    """k/E* of A x² + B y² by Johnson's (4.26) and (4.27), with K and E by quadrature."""

    def quarter(f):
        return scipy.integrate.quad(f, 0, math.pi / 2, epsabs=0, epsrel=1e-13)[0]

    def kinds(m):
        return (
            quarter(lambda t: 1 / math.sqrt(1 - m * math.sin(t) ** 2)),
            quarter(lambda t: math.sqrt(1 - m * math.sin(t) ** 2)),
        )

    def excess(m):
        first, second = kinds(m)
        return (second / (1 - m) - first) / (first - second) - high / low

    m = scipy.optimize.brentq(excess, 1e-4, 1 - 1e-6, xtol=1e-15)
    first, second = kinds(m)
    a, b = 1.0, math.sqrt(1 - m)
    pressure = low * a * a * m / (b * (first - second))
    delta, force = pressure * b * first, 2 / 3 * pressure * math.pi * a * b
    return force / delta**1.5


@pytest.mark.parametrize("ratio", [1.01, 1.5, 3.0, 10.0, 100.0])
def test_ellipses_are_johnsons_equations(ratio):
    """Flat against the principal radii 1 and 1/ratio: A = 1/2, B = ratio/2."""
    k = ao.Hertz.between(STEEL, (1.0, 1.0 / ratio), STEEL, math.inf).k
    assert k / E_STAR == pytest.approx(by_quadrature(0.5, 0.5 * ratio), rel=1e-8)


@pytest.mark.parametrize(
    ("cosine", "factor"),
    [(0.0, 0.750), (0.2, 0.743), (0.5, 0.703), (0.8, 0.594), (0.9, 0.510), (0.98, 0.345)],
)
def test_ellipses_are_the_table_of_the_handbook(cosine, factor):
    """Roark: y = λ (F²/(E*² K_D))^(1/3), K_D = 1.5/(2 (A+B)), λ by cos θ = (B-A)/(A+B)."""
    low, high = 50.0 * (1 - cosine), 50.0 * (1 + cosine)
    k = ao.Hertz.between(STEEL, (1 / (2 * low), 1 / (2 * high)), STEEL, math.inf).k
    found = (E_STAR / k) ** (2 / 3) * (1.5 / (2 * (low + high))) ** (1 / 3)
    assert found == pytest.approx(factor, abs=6e-4)


@given(st.floats(1e-3, 1.0), st.floats(1e-3, 1.0), st.floats(0.0, math.pi))
def test_turning_the_other_body_is_the_same(first, second, angle):
    one = ao.Hertz.between(STEEL, (first, 0.02), ALUMINIUM, (second, 0.05), angle=angle).k
    other = ao.Hertz.between(ALUMINIUM, (second, 0.05), STEEL, (first, 0.02), angle=-angle).k
    swapped = ao.Hertz.between(
        STEEL, (0.02, first), ALUMINIUM, (0.05, second), angle=angle + math.pi
    ).k
    assert one == pytest.approx(other, rel=1e-9)
    assert one == pytest.approx(swapped, rel=1e-9)
