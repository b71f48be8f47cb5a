"""The star (Fig. 2): a chain of springs and masses like any other, whose matrices we can write."""

import math
import pickle

import numpy as np
import pytest
import scipy.linalg as la
from hypothesis import given
from hypothesis import strategies as st

import aoimpact as ao


def matrices(star):
    """Mass and stiffness matrix of the star, contact mass first."""
    K = np.diag(np.concatenate([[star.k0 + star.k.sum()], star.k]))
    K[0, 1:] = K[1:, 0] = -star.k
    return np.diag(np.concatenate([[star.m0], star.m])), K


EXAMPLE = {"m0": 0.2, "k0": 3e4, "m": [0.5, 0.1, 0.02], "k": [2e4, 5e5, 1e3]}

stars = st.integers(1, 6).flatmap(
    lambda n: st.builds(
        lambda m0, k0, m, k: ao.AOModel(m0=m0, k0=k0, m=m, k=k),
        st.floats(1e-4, 1e2),
        st.one_of(st.just(0.0), st.floats(1e-2, 1e8)),
        st.lists(st.floats(1e-6, 1e2), min_size=n, max_size=n),
        st.lists(st.floats(1e0, 1e9), min_size=n, max_size=n),
    )
)


def test_receptance_is_the_inverse_dynamic_stiffness():
    star = ao.AOModel(**EXAMPLE)
    M, K = matrices(star)
    omega = np.array([[0.0, 50.0], [400.0, 9e3]])
    expected = [[la.inv(K - w**2 * M)[0, 0] for w in row] for row in omega]
    np.testing.assert_allclose(star.receptance(omega), expected, rtol=1e-11)
    assert isinstance(star.receptance(10.0), float)


def test_receptance_vanishes_at_the_antioscillators_frequencies():
    star = ao.AOModel(m0=1.0, k0=2.0, m=[1.0], k=[4.0])
    assert star.frequencies == pytest.approx([2.0 / (2.0 * np.pi)])
    assert star.receptance(2.0) == pytest.approx(0.0, abs=1e-15)


def test_static_receptance_is_the_ground_spring_and_infinite_without_one():
    assert ao.AOModel(**EXAMPLE).receptance(0.0) == pytest.approx(1.0 / 3e4, rel=1e-15)
    assert ao.AOModel(m0=1.0, m=[1.0], k=[1.0]).receptance(0.0) == math.inf
    assert ao.rigid(mass=math.inf).receptance([0.0, 10.0]).tolist() == [0.0, 0.0]


@given(stars)
def test_natural_modes_solve_the_stars_eigenproblem(star):
    """And their frequencies interlace with those at which the contact stands still."""
    M, K = matrices(star)
    omega2, participation = star.to_modal()
    expected = la.eigh(K, M, eigvals_only=True)
    scale = expected[-1]
    if len(omega2) == len(expected):  # oscillators of equal frequency share a mode
        np.testing.assert_allclose(omega2, expected, rtol=1e-9, atol=1e-12 * scale)
        # Participations of close modes mix under rounding; their sum over all is 1/m0 exactly.
    assert np.sum(participation**2) == pytest.approx(1.0 / star.m0, rel=1e-9)
    if star.k0 == 0.0:
        assert omega2[0] == 0.0
        assert participation[0] ** 2 == pytest.approx(1.0 / star.static_mass, rel=1e-12)
    else:
        assert np.sum(participation**2 / omega2) == pytest.approx(1.0 / star.k0, rel=1e-8)
    natural, anti = star.natural_frequencies, np.unique(star.frequencies)
    if len(natural) == len(anti) + 1:
        assert (natural[:-1] <= anti * (1 + 1e-14)).all()
        assert (anti <= natural[1:] * (1 + 1e-14)).all()


def test_a_tiny_ground_spring_gives_the_rigid_mode_its_small_frequency():
    star = ao.AOModel(m0=1e-3, k0=1e-9, m=[0.999], k=[2.757e8])
    omega2, _ = star.to_modal()
    assert omega2[0] == pytest.approx(1e-9 / 1.0, rel=1e-12)


def test_a_massless_contact_has_one_mode_less():
    star = ao.AOModel(m0=0.0, k0=0.0, m=[1.0, 2.0], k=[3.0, 5.0])
    omega2, participation = star.to_modal()
    # Two masses joined by the two springs in series, free in space.
    spring = 1.0 / (1.0 / 3.0 + 1.0 / 5.0)
    np.testing.assert_allclose(omega2, [0.0, spring * (1.0 + 0.5)], rtol=1e-13)
    # What the modes leave out of the receptance is that of the springs alone.
    w = 0.7
    modal = np.sum(participation**2 / (omega2 - w**2))
    assert star.receptance(w) - modal == pytest.approx(1.0 / 8.0, rel=1e-12)


def test_oscillators_of_one_frequency_act_as_one():
    twins = ao.AOModel(m0=0.1, k0=2.0, m=[1.0, 3.0], k=[5.0, 15.0])
    one = ao.AOModel(m0=0.1, k0=2.0, m=[4.0], k=[20.0])
    np.testing.assert_allclose(twins.to_modal(), one.to_modal(), rtol=1e-14)


def test_truncation_keeps_the_static_mass():
    star = ao.AOModel(**EXAMPLE)
    for n in range(4):
        short = star.truncated(n)
        assert short.n == n
        assert short.static_mass == pytest.approx(star.static_mass, rel=1e-15)
        assert short.k0 == star.k0
    assert star.truncated(1).m0 == pytest.approx(0.2 + 0.1 + 0.02)
    assert star.mass_fractions == pytest.approx(star.m / 0.82)


def test_models_are_immutable_and_pickle():
    star = ao.AOModel(**EXAMPLE)
    with pytest.raises(ValueError, match="read-only"):
        star.m[0] = 1.0
    with pytest.raises(AttributeError):
        star.m0 = 1.0
    copy = pickle.loads(pickle.dumps(star))
    assert copy.m.tolist() == star.m.tolist()
    assert copy.static_mass == star.static_mass


def test_modes_of_stars_over_two_hundred_decades():
    """Σ r_j² = 1/m0 of mass-normalised modes, and Σ 1/ω_j² r_j² = 1/k0 of a held star."""
    random = np.random.default_rng(4)
    for _ in range(300):
        n = int(random.integers(1, 5))
        m, k = 10.0 ** random.uniform(-99, 99, (2, n))
        m0, k0 = 10.0 ** random.uniform(-99, 99, 2)
        omega2, shares = ao.AOModel(m0=m0, k0=k0, m=m, k=k).to_modal()
        assert (np.diff(omega2) >= 0.0).all()
        assert math.fsum(m0 * shares**2) == pytest.approx(1.0, rel=1e-9)
        assert math.fsum(k0 / omega2 * shares**2) == pytest.approx(1.0, rel=1e-9)


def test_a_star_of_numbers_has_no_body_to_expand_to():
    with pytest.raises(ao.InputError):
        ao.AOModel(**EXAMPLE).expand([0.0] * 4)
