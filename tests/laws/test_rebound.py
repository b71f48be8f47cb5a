"""Restitution: closed forms against integration in plain time, and their inverses."""

import math

import pytest
import scipy.special
from hypothesis import given
from hypothesis import strategies as st
from rigid_pair import rebound

import aoimpact as ao

K, MASS, SPEED = 1.3e10, 0.016, 0.7
WANTED = [0.01, 0.03, 0.1, 0.3, 0.5, 0.8, 0.95, 0.999, 1.0]


def oscillator(ratio, end="force"):
    """The restitution of 1 kg on a spring of 1 N/m with that damping ratio."""
    return ao.restitution(ao.KelvinVoigt(1.0, 2.0 * ratio, end), 1.0, 1.0)


def hunt_crossley(damping):
    return ao.restitution(ao.HuntCrossley(1.0, damping), 1.0, 1.0)


@pytest.mark.parametrize("ratio", [1e-6, 0.01, 0.3, 0.7, 0.9, 1.0, 1.1, 2.0, 6.0])
def test_an_oscillator_that_is_let_go_where_its_force_ends(ratio):
    found = rebound(lambda x, v: x + 2 * ratio * v, 1.0, 1.0)
    assert oscillator(ratio) == pytest.approx(found, rel=1e-10)


@pytest.mark.parametrize("ratio", [1e-6, 0.01, 0.3, 0.9])
def test_an_oscillator_that_swings_back_to_zero(ratio):
    found = rebound(lambda x, v: x + 2 * ratio * v, 1.0, 1.0, pulls=True)
    assert oscillator(ratio, "indentation") == pytest.approx(found, rel=1e-10)


@given(st.floats(1e-3, 300.0))
def test_hunt_crossley_is_lamberts_w(damping):
    start = -(1.0 + damping)
    e = (1.0 + float(scipy.special.lambertw(start * math.exp(start)).real)) / damping
    # For little damping that formula itself loses digits: the argument of W nears -1/e.
    assert hunt_crossley(damping) == pytest.approx(e, rel=1e-13 / min(damping, 1.0) ** 2)


@pytest.mark.parametrize("damping", [1e-12, 1e-9, 1e-6, 1e-4, 1e-2])
def test_hunt_crossley_of_little_damping_is_its_series(damping):
    """e = 1 - 2/3 u + 4/9 u² + O(u³), from the same relation."""
    lost = 1.0 - hunt_crossley(damping)
    assert lost == pytest.approx(2 / 3 * damping - 4 / 9 * damping**2, abs=0.4 * damping**3 + 4e-16)


@pytest.mark.parametrize("e", WANTED)
@pytest.mark.parametrize("n", [1.0, 1.2, 1.5, 2.0, 2.5])
def test_hunt_crossley_delivers_what_was_asked(e, n):
    law = ao.HuntCrossley.from_restitution(K, e, SPEED, n)
    # Its force ends where the indentation does.
    push = lambda d, v: K * d**n * (1 + law.damping * v)  # noqa: E731
    found = rebound(push, MASS, SPEED, pulls=True)
    assert found == pytest.approx(e, rel=1e-9)


@pytest.mark.parametrize("e", WANTED)
def test_tsuji_delivers_what_was_asked_at_any_velocity(e):
    law = ao.Tsuji.from_restitution(K, e, MASS)
    damping = law.alpha * math.sqrt(MASS * K)
    found = rebound(lambda d, v: K * d**1.5 + damping * d**0.25 * v, MASS, SPEED)
    assert found == pytest.approx(e, rel=1e-9)
    assert ao.restitution(law, MASS, 1e3) == pytest.approx(e, rel=1e-12)


@pytest.mark.parametrize("e", WANTED)
def test_kuwabara_kono_delivers_what_was_asked(e):
    law = ao.KuwabaraKono.from_restitution(K, e, SPEED, MASS)
    found = rebound(lambda d, v: K * (d**1.5 + 1.5 * law.A * math.sqrt(d) * v), MASS, SPEED)
    assert found == pytest.approx(e, rel=1e-9)


@pytest.mark.parametrize("e", WANTED)
@pytest.mark.parametrize("end", ["force", "indentation"])
def test_kelvin_voigt_delivers_what_was_asked(e, end):
    law = ao.KelvinVoigt.from_restitution(1e7, e, MASS, end)
    found = rebound(lambda d, v: 1e7 * d + law.c * v, MASS, SPEED, pulls=end == "indentation")
    assert found == pytest.approx(e, rel=1e-9)


def test_kuwabara_kono_depends_on_one_number():
    """1 - e = 1.15344 (k/m)^(2/5) 3/2 A V^(1/5) for little A: Brilliantov and Poeschel (2004)."""
    for m, k, v in ((1.0, 1.0, 1.0), (0.02, 3e9, 2.5)):
        lag = 1e-7 / ((k / m) ** 0.4 * v**0.2)
        lost = 1.0 - ao.restitution(ao.KuwabaraKono(k, lag), m, v)
        assert lost == pytest.approx(1.15344 * 1.5e-7, rel=1e-5)


@pytest.mark.parametrize(
    "force",
    [
        lambda d, v: 1e10 * d**1.5,
        lambda d, v: max(0.0, 1e10 * d**1.5 * (1 + 0.8 * v)),
        lambda d, v: max(0.0, 1e7 * d + 300.0 * v),
        lambda d, v: max(0.0, 1e10 * (d**1.5 + 2e-5 * math.sqrt(d) * v)),
    ],
)
def test_integration_of_any_force(force):
    found = ao.restitution(ao.UserLaw(force), 0.02, 1.5)
    assert found == pytest.approx(rebound(force, 0.02, 1.5), rel=1e-9)


@pytest.mark.parametrize(
    ("formula", "share"),
    [
        ("lankarani-nikravesh", 1),
        ("herbert-mcwhannell", 1),
        ("lee-wang", 1 / 2),
        ("flores", 16 / 15),
        ("gonthier", 4 / 3),
    ],
)
def test_published_formulas_where_little_is_lost(formula, share):
    """1 - e = 2/3 chi V to first order, and each formula's chi V is its own multiple of 1 - e."""

    def delivered(e):
        law = ao.HuntCrossley.from_restitution(K, e, SPEED, formula=formula)
        return ao.restitution(law, MASS, SPEED)

    assert 1.0 - delivered(1.0 - 1e-6) == pytest.approx(share * 1e-6, rel=1e-5)
    assert delivered(1.0) == 1.0
