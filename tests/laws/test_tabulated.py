"""A law through points."""

import itertools
import math

import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate
import scipy.optimize
from hypothesis import given
from hypothesis import strategies as st
from rigid_pair import on_a_wall

import aoimpact as ao

DEPTH = np.linspace(0.0, 1e-4, 25)
LAW = ao.Tabulated(DEPTH, 1e10 * DEPTH**1.5)

steps = st.lists(
    st.tuples(st.floats(1e-7, 1e-3), st.just(0.0) | st.floats(1e-3, 1e5)), min_size=1, max_size=12
).filter(lambda s: s[0][1] > 0.0)


def points(parts):
    return tuple(np.concatenate([[0.0], np.cumsum(column)]) for column in zip(*parts, strict=True))


@given(steps)
def test_it_is_scipys_pchip_and_its_integral(parts):
    depth, force = points(parts)
    law, spline = ao.Tabulated(depth, force), scipy.interpolate.PchipInterpolator(depth, force)
    between = np.linspace(0.0, depth[-1], 101)
    np.testing.assert_allclose(
        law.force(between), spline(between), rtol=1e-12, atol=1e-12 * force[-1]
    )
    energy = spline.antiderivative()(between)
    np.testing.assert_allclose(law.potential(between), energy, rtol=1e-12, atol=1e-12 * energy[-1])


@given(steps)
def test_it_goes_through_its_points_and_nowhere_falls(parts):
    depth, force = points(parts)
    law = ao.Tabulated(depth[1:], force[1:])  # the origin is understood
    np.testing.assert_allclose(law.force(depth), force, rtol=1e-14)
    fine = law.force(np.linspace(0.0, depth[-1], 500))
    assert np.diff(fine).min() >= -1e-12 * force[-1]


@pytest.mark.parametrize("solver", [ao.Newmark(dt=1e-7), ao.Adaptive(rtol=1e-7)])
def test_a_fine_table_of_hertz_is_hertz(solver):
    scene = {
        "projectile": ao.rigid(mass=0.016),
        "target": ao.rigid(mass=math.inf),
        "velocity": 1.0,
        "duration": 1e-4,
        "solver": solver,
    }
    fine = np.linspace(0.0, 1.0, 300) ** 2 * 1e-4
    table = ao.simulate(law=ao.Tabulated(fine, 1e10 * fine**1.5), **scene)
    hertz = ao.simulate(law=ao.Hertz(1e10), **scene)
    assert table.peak_force == pytest.approx(hertz.peak_force, rel=1e-5)
    assert table.contact_duration == pytest.approx(hertz.contact_duration, rel=1e-5)


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-8])
@pytest.mark.parametrize("seed", range(6))
def test_a_table_in_series_with_a_spring_takes_the_blow(seed, rtol):
    """A mass behind a spring that touches without mass: the peak is where their energy is its own.

    Both loading and unloading last as long as the sum of the ways takes at the rate that is left.
    """
    rng = np.random.default_rng(seed)
    depth, force = (np.append(0.0, np.cumsum(rng.uniform(low, 1.0, 8))) for low in (0.1, 0.01))
    law, spline = ao.Tabulated(depth, force), scipy.interpolate.PchipInterpolator(depth, force)
    mass, k, velocity = 1.0, 1.0, 1.0
    energy = spline.antiderivative()

    def left(d):
        return 0.5 * mass * velocity**2 - energy(d) - 0.5 * spline(d) ** 2 / k

    deepest = scipy.optimize.brentq(left, 0.0, depth[-1], xtol=1e-15)
    result = ao.simulate(
        projectile=ao.AOModel(m0=0.0, k0=0.0, m=[mass], k=[k]),
        target=ao.rigid(mass=math.inf),
        law=law,
        velocity=velocity,
        duration=20.0,
        solver=ao.Adaptive(rtol=rtol),
    )
    assert result.peak_force == pytest.approx(spline(deepest), rel=rtol)
    assert result.restitution == pytest.approx(1.0, abs=rtol)
    impulse = 2.0 * mass * velocity
    assert result.impulse == pytest.approx(impulse, rel=rtol)
    slope = spline.derivative()
    knots = [0.0, *depth[(depth > 0.0) & (depth < deepest)], deepest]

    def slowness(u, low, high):
        """In d = high - (high - low) u^2: the rate ends like a root."""
        d = high - (high - low) * u * u
        rate = math.sqrt(max(2.0 * left(d) / mass, 1e-300))
        return 2.0 * (high - low) * u * (1.0 + slope(d) / k) / rate

    ways = itertools.pairwise(knots)
    time = 2.0 * sum(scipy.integrate.quad(slowness, 0.0, 1.0, args=way)[0] for way in ways)
    assert result.contact_duration == pytest.approx(time, rel=max(rtol, 1e-7))


def test_what_lies_beyond_the_table_is_not_made_up():
    assert LAW.force(1e-4) == pytest.approx(1e10 * 1e-6)
    with pytest.raises(ao.InputError, match=r"^contact"):
        LAW.force(1.001e-4)
    with pytest.raises(ao.InputError, match=r"^contact"):
        on_a_wall(LAW, 1.0, 3.0, ao.Newmark(dt=1e-6), duration=1e-3)


def test_it_is_a_value_that_owns_its_points():
    depth = DEPTH.copy()
    law = ao.Tabulated(depth, 1e10 * depth**1.5)
    depth[:] = 0.0
    assert law == LAW
    assert law.indentation == tuple(DEPTH.tolist())
    assert repr(law) == "Tabulated(25 points up to 0.0001 m, 10000 N)"


@pytest.mark.parametrize(
    ("indentation", "force", "message"),
    [
        ([0, 1e-5, 1e-5], [0, 1, 2], r"^indentation"),
        ([0, 2e-5, 1e-5], [0, 1, 2], r"^indentation"),
        ([0, 1e-4, 1e308], [0, 1, 2], r"^indentation"),
        ([0, 1e200, 2e200], [0, 1e150, 2e150], r"^indentation"),
        ([0, 1e-5, 2e-5], [0, 2, 1], r"^force"),
        ([0, 1e-5], [1, 2], r"^force"),
        ([-1e-5, 1e-5], [0, 2], r"^indentation"),
        ([0, 1e-5, 2e-5], [0, 0, 1], r"^force"),
        ([0], [0], r"^indentation"),
    ],
)
def test_bad_tables_are_named(indentation, force, message):
    with pytest.raises(ao.AOImpactError, match=message):
        ao.Tabulated(indentation, force)
