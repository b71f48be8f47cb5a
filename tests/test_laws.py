"""Contact laws: force, its derivative and its potential agree with each other and with Hertz."""

import math

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.3, rho=2400)
LAWS = [ao.Hertz(k=1e10), ao.PowerLaw(k=3e8, n=1.2), ao.PowerLaw(k=1e12, n=2.0), ao.Linear(k=5e6)]
ids = [repr(law) for law in LAWS]


def test_hertz_between_two_spheres_is_equation_13():
    k = ao.Hertz.between(STEEL, 0.01, STEEL, 0.01).k
    assert k == pytest.approx(4 / 3 * 210e9 / (2 * (1 - 0.3**2)) * math.sqrt(0.01 / 2), rel=1e-15)
    assert k == pytest.approx(1.0878566e10, rel=1e-7)  # the paper prints 1e10


def test_hertz_between_sphere_and_flat_is_equations_16_and_17():
    k = ao.Hertz.between(STEEL, 0.01, ALUMINIUM, math.inf).k
    e_star = 1.0 / ((1 - 0.3**2) / 70e9 + (1 - 0.3**2) / 210e9)
    assert k == pytest.approx(4 / 3 * e_star * math.sqrt(0.01), rel=1e-15)
    assert k == ao.Hertz.between(ALUMINIUM, math.inf, STEEL, 0.01).k


@pytest.mark.parametrize("law", LAWS, ids=ids)
def test_no_law_pulls(law):
    assert law.force(np.array([-1e-3, -0.0, 0.0])).tolist() == [0.0, 0.0, 0.0]
    assert law.potential(np.array([-1e-3, 0.0])).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("law", LAWS, ids=ids)
def test_force_is_the_derivative_of_the_potential(law):
    delta = np.geomspace(1e-9, 1e-2, 15)
    step = 1e-4 * delta
    slope = (law.potential(delta + step) - law.potential(delta - step)) / (2 * step)
    np.testing.assert_allclose(law.force(delta), slope, rtol=1e-7)


@pytest.mark.parametrize("law", LAWS, ids=ids)
def test_force_grows_with_indentation_over_ten_decades(law):
    assert (np.diff(law.force(np.geomspace(1e-12, 1e-2, 200))) > 0).all()


def test_formulas():
    assert ao.Hertz(k=2.0).force(4.0) == pytest.approx(16.0)
    assert ao.PowerLaw(k=2.0, n=2.0).force(3.0) == pytest.approx(18.0)
    assert ao.Linear(k=2.0).force(3.0) == 6.0
    assert ao.PowerLaw(k=7.0, n=1.5).force(0.3) == pytest.approx(ao.Hertz(7.0).force(0.3))


def test_force_broadcasts_and_takes_any_array():
    law = ao.Hertz(k=1.0)
    grid = law.force(np.ones((2, 3), dtype=np.float32)[:, ::2], rate=0.0)
    assert grid.shape == (2, 2)
    assert isinstance(law.force(1), float)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ao.Hertz(k=0.0), "k must be positive, got 0 N/m"),
        (lambda: ao.Hertz(k=math.nan), "k must be a number, got nan"),
        (lambda: ao.Hertz(k="1e10"), "k must be a real number"),
        (lambda: ao.Linear(k=-1.0), "k must be positive"),
        (lambda: ao.PowerLaw(k=1.0, n=0.5), "n must be at least 1"),
        (lambda: ao.Hertz.between(STEEL, 0.0, STEEL, 0.01), "radius_1 must be positive"),
        (lambda: ao.Hertz.between(STEEL, math.inf, STEEL, math.inf), "both infinite"),
        (lambda: ao.Hertz.between(210e9, 0.01, STEEL, 0.01), "material_1 must be a Material"),
        (lambda: ao.Hertz(k=1.0).force(math.nan), "indentation"),
        (lambda: ao.Hertz(k=1.0).force(1j), "indentation"),
    ],
)
def test_bad_input_is_named(make, message):
    with pytest.raises(ao.AOImpactError, match=message):
        make()


def test_laws_are_values():
    assert ao.Hertz(k=1e10) == ao.Hertz(1e10)
    with pytest.raises(AttributeError):
        ao.Hertz(k=1e10).k = 2.0
