"""A law through points."""

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


def test_what_lies_beyond_the_table_is_not_made_up():
    assert LAW.force(1e-4) == pytest.approx(1e10 * 1e-6)
    with pytest.raises(ao.InputError, match=r"^contact"):
        LAW.force(1.001e-4)
    with pytest.raises(ao.InputError, match=r"^contact"):
        on_a_wall(LAW, 1.0, 3.0, ao.Newmark(dt=1e-6), duration=1e-3)
