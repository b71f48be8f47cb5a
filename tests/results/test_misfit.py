"""Models fitted to one impact and met by another: warned of where it matters, and only there."""

import warnings

import numpy as np
import pytest
import scipy.sparse as sp
from paperbodies import BALL_MASS, LAW, LENGTH, WIDTH, beam_model

import aoimpact as ao
from aoimpact.batch import plain_numbers
from aoimpact.reduction import unbalanced

from twelve import ALUMINIUM, FLOOR, IMPACTS, STEEL, block, cube, law

# Two impacts: on the paper's beam, which has modes of all periods, for 90 µs; and of two compact
# blocks, whose slowest modes are faster than the impact of 130 µs.
BALL = ao.rigid(mass=BALL_MASS)


@pytest.fixture(scope="module")
def tip():
    return beam_model().contact(
        point=(LENGTH / 2, WIDTH / 2, WIDTH), direction=(0, 0, -1), radius=0
    )


def fitted(tip, contact_time, n=6):
    return ao.antioscillators(tip, n, method="krylov", contact_time=contact_time)


def strike(target, **options):
    return ao.simulate(BALL, target, 1.0, law=LAW, duration=250e-6, **options)


@pytest.mark.parametrize("contact_time", [45e-6, 180e-6, 250e-6])
def test_within_a_factor_of_three_nothing_is_said(tip, contact_time):
    """And the force is right: six oscillators, half a percent at best."""
    force = strike(fitted(tip, contact_time)).peak_force
    assert force == pytest.approx(strike(fitted(tip, 90e-6, 28)).peak_force, rel=0.03)


@pytest.mark.parametrize("contact_time", [10e-6, 2e-3])
def test_far_off_both_times_and_the_cure_are_named(tip, contact_time):
    star = fitted(tip, contact_time)
    assert star.origin.contact_time == pytest.approx(contact_time)
    with pytest.warns(ao.AOImpactWarning, match=r"^target") as said:
        wrong = strike(star)
    assert "contact_time=" in str(said[0].message)
    right = strike(fitted(tip, 90e-6, 28))
    times = np.linspace(0, 250e-6, 251)
    off = np.abs(wrong.at(times).force - right.at(times).force).max()
    assert off > 0.05 * right.peak_force  # it does matter


def test_what_does_not_matter_is_not_said():
    """A compact body responds to a slow impact by its static mode: far off, the force is right."""
    hits = [
        ao.simulate(
            projectile=fitted(cube(STEEL, 0.02), contact_time, 4),
            target=fitted(block(ALUMINIUM, 0.04, FLOOR), contact_time, 4),
            law=law(STEEL, 0.01, ALUMINIUM),
            velocity=1.0,
            duration=2e-4,
        )
        for contact_time in (1.3e-5, 1.3e-4, 1.0)
    ]
    assert hits[1].contact_duration > 9 * 1.3e-5
    for hit in hits:
        assert hit.peak_force == pytest.approx(hits[1].peak_force, rel=2e-3)


def test_many_impacts_at_once_are_looked_at_too(tip):
    case = {"projectile": BALL, "law": LAW, "velocity": 1.0, "duration": 250e-6}
    near, far = (
        plain_numbers([case | {"target": fitted(tip, T)}], ["peak_force"]) for T in (90e-6, 10e-6)
    )
    assert near[0] is not None
    assert far == [None]  # left to `simulate`
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        ao.simulate_many([case | {"target": fitted(tip, 10e-6)}], keep="peak_force")
    assert any("fitted to a contact" in str(one.message) for one in said)


# ----------------------------------------------------------------------- what lasts, or comes again


def cantilever(n, **fit):
    """A ball on the tip of a cantilever: 82 µs of contact, and another impact after 340 µs."""
    ball, tip, between, velocity, _ = IMPACTS["tip of a cantilever, for long"]()
    star = (
        ao.antioscillators(tip) if n is None else ao.antioscillators(tip, n, method="krylov", **fit)
    )
    return {"projectile": ball, "target": star, "law": between, "velocity": velocity}


def test_a_contact_somewhat_longer_than_fitted_is_told_where_few_oscillators_miss_it():
    right = ao.simulate(**cantilever(None), duration=9e-5)
    with pytest.warns(ao.AOImpactWarning, match=r"^target"):
        short = ao.simulate(**cantilever(3, contact_time=33e-6), duration=2e-4)
    assert abs(short.impulse / right.impulse - 1.0) > 0.15
    for cured in (cantilever(3, contact_time=82e-6), cantilever(8, contact_time=33e-6)):
        assert ao.simulate(**cured, duration=9e-5).impulse == pytest.approx(right.impulse, rel=0.01)


@pytest.mark.parametrize("n", [3, 8])
def test_later_contacts_are_told_where_what_is_between_is_not_known(n):
    right = ao.simulate(**cantilever(None), duration=2e-3)
    assert len(right.contacts) == 2
    with pytest.warns(ao.AOImpactWarning, match=r"^target"):
        wrong = ao.simulate(**cantilever(n, contact_time=82e-6), duration=2e-3)
    assert abs(wrong.impulse / right.impulse - 1.0) > 0.1
    cured = ao.simulate(**cantilever(12, contact_time=82e-6, duration=4.9e-4), duration=2e-3)
    assert cured.impulse == pytest.approx(right.impulse, rel=1e-3)


# ------------------------------------------------------------------------------ what is unbalanced


def test_its_square_is_the_error_of_the_receptance():
    """Where K and M are diagonal: of dofs that only the functional holds together."""
    k, m = np.geomspace(1.0, 1e3, 8), np.linspace(1.0, 2.0, 8)
    body = ao.FEModel(K=sp.diags_array(k).tocsr(), M=sp.diags_array(m).tocsr())
    tip = ao.ContactPoint(body, np.ones(8), None, None, None)
    star = ao.antioscillators(tip, 2, method="krylov", contact_time=1.0)
    s = 3.0
    exact = np.sum(1 / (k + s**2 * m))
    inertia = star.m0 + np.sum(star.k / (star.k / star.m + s**2))
    found = 1 / (star.k0 + s**2 * inertia)
    assert unbalanced(star.modal, s) ** 2 == pytest.approx((exact - found) / found, rel=1e-6)


@pytest.mark.parametrize("beta", [0.0, 1e-9, 1e-4])
def test_dashpots_at_a_massless_contact(beta):
    """The limit of light contact masses is another body where dashpots hold the contact back."""

    def hit(m0):
        star = ao.AOModel(m0=m0, m=[1.0], k=[1e6], damping=ao.Rayleigh(beta=beta))
        solver = ao.Adaptive(rtol=1e-7)
        return ao.simulate(
            ao.rigid(0.5), star, 1.0, law=ao.Hertz(k=1e8), duration=4e-3, solver=solver
        )

    if beta < 1e-6:
        assert hit(0.0).rebound_velocity == pytest.approx(hit(1e-6).rebound_velocity, rel=1e-4)
        return
    with pytest.warns(ao.AOImpactWarning, match=r"^target"):
        massless = hit(0.0)
    assert abs(massless.rebound_velocity / hit(1e-6).rebound_velocity - 1.0) > 0.1
    assert hit(1e-6).rebound_velocity == pytest.approx(hit(1e-8).rebound_velocity, rel=1e-5)
