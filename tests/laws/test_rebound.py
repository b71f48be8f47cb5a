"""Restitution: closed forms against integration in plain time, and their inverses."""

import math

import pytest
import scipy.special
from hypothesis import example, given
from hypothesis import strategies as st
from rigid_pair import rebound
from rows import each

import aoimpact as ao

K, MASS, SPEED = 1.3e10, 0.016, 0.7


def hunt_crossley(damping):
    return ao.restitution(ao.HuntCrossley(1.0, damping), 1.0, 1.0)


@example(40.0)  # where 1 - e damping is half a rounding
@given(st.floats(1e-3, 300.0))
def test_hunt_crossley_is_lamberts_w(damping):
    start = -(1.0 + damping)
    e = (1.0 + float(scipy.special.lambertw(start * math.exp(start)).real)) / damping
    # For little damping that formula itself loses digits: the argument of W nears -1/e.
    assert hunt_crossley(damping) == pytest.approx(e, rel=1e-13 / min(damping, 1.0) ** 2)


@each("damping", [1e-12, 1e-9, 1e-6, 1e-4, 1e-2])
def test_hunt_crossley_of_little_damping_is_its_series(damping):
    """e = 1 - 2/3 u + 4/9 u² + O(u³), from the same relation."""
    lost = 1.0 - hunt_crossley(damping)
    assert lost == pytest.approx(2 / 3 * damping - 4 / 9 * damping**2, abs=0.4 * damping**3 + 4e-16)


# Laws made for a restitution, their forces, and whether these last until the indentation ends.
MADE = {
    **{
        f"HuntCrossley, n={n}": (
            lambda e, n=n: ao.HuntCrossley.from_restitution(K, e, SPEED, n),
            lambda law, d, v: K * d**law.n * (1 + law.damping * v),
            True,
        )
        for n in (1.0, 1.2, 1.5, 2.0, 2.5)
    },
    "Tsuji": (
        lambda e: ao.Tsuji.from_restitution(K, e, MASS),
        lambda law, d, v: K * d**1.5 + law.alpha * math.sqrt(MASS * K) * d**0.25 * v,
        False,
    ),
    "KuwabaraKono": (
        lambda e: ao.KuwabaraKono.from_restitution(K, e, SPEED, MASS),
        lambda law, d, v: K * (d**1.5 + 1.5 * law.A * math.sqrt(d) * v),
        False,
    ),
    **{
        f"KelvinVoigt, {end}": (
            lambda e, end=end: ao.KelvinVoigt.from_restitution(1e7, e, MASS, end),
            lambda law, d, v: 1e7 * d + law.c * v,
            end == "indentation",
        )
        for end in ("force", "indentation")
    },
}


@each("e", [0.01, 0.1, 0.5, 0.8, 0.999, 1.0])
@each("name", MADE)
def test_a_law_delivers_what_was_asked(name, e):
    make, force, pulls = MADE[name]
    law = make(e)
    found = rebound(lambda d, v: force(law, d, v), MASS, SPEED, pulls=pulls)
    assert found == pytest.approx(e, rel=1e-9)
    assert ao.restitution(law, MASS, SPEED) == pytest.approx(e, rel=1e-9)


def test_kuwabara_kono_depends_on_one_number():
    """1 - e = 1.15344 (k/m)^(2/5) 3/2 A V^(1/5) for little A: Brilliantov and Poeschel (2004)."""
    for m, k, v in ((1.0, 1.0, 1.0), (0.02, 3e9, 2.5)):
        lag = 1e-7 / ((k / m) ** 0.4 * v**0.2)
        lost = 1.0 - ao.restitution(ao.KuwabaraKono(k, lag), m, v)
        assert lost == pytest.approx(1.15344 * 1.5e-7, rel=1e-5)
