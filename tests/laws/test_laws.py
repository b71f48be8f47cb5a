"""Statements that hold for every contact law, and the laws' own formulas."""

import copy
import math
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from every_law import LAWS, law_of
from hypothesis import given, settings
from hypothesis import strategies as st
from rows import each

import aoimpact as ao
from aoimpact.laws import LAWS as REGISTERED

NAMES = sorted(LAWS)
PULLING = "pulling KelvinVoigt"

# Stiffness, restitution, exponent.
parameters = st.tuples(
    st.floats(1e8, 1e12), st.floats(0.1, 1.0), st.sampled_from([1.0, 1.2, 1.5, 2.0, 2.5])
)
depths = st.floats(1e-9, 2e-5)
rates = st.floats(-3.0, 3.0)
over_laws = each("name", NAMES)


def test_every_law_has_an_example_and_a_public_name():
    laws = set(REGISTERED.values())
    assert laws <= {type(law_of(name)) for name in NAMES}  # tests/every_law.py
    assert laws == {getattr(ao, name) for name in REGISTERED}  # aoimpact/__init__.pyi


@each("name", sorted(set(REGISTERED) - {"UserLaw"}))
def test_every_law_is_documented_for_scene_files(name):
    page = Path(__file__).parents[2] / "docs" / "scene-files.md"
    text = page.read_text(encoding="utf-8")
    assert f"`{name}`" in text
    without = re.search(r"All but ([^.]*) take a `relative_radius`", text)
    assert without is not None
    takes_none = "relative_radius" not in REGISTERED[name].__dataclass_fields__
    assert takes_none == (f"`{name}`" in without[1]), "the sentence on `relative_radius`"


@each("name", sorted(set(REGISTERED) - {"Tabulated", "UserLaw"}))
def test_a_summary_writes_every_parameter_with_its_unit(name):
    assert str(law_of(name)).startswith(f"{name}, "), "name the units in the fields of the class"


@over_laws
def test_what_a_law_says_of_its_rate_is_what_its_formula_does(name):
    law = law_of(name)
    moving = law.force(1e-5, np.array([-0.2, 0.0, 0.2]))
    assert law.depends_on_rate == (len(set(moving.tolist())) > 1)


@over_laws
@given(parameters=parameters, rate=rates)
@settings(max_examples=10)
def test_no_force_without_contact(name, parameters, rate):
    law = law_of(name, *parameters)
    apart = np.array([-1e300, -1e-3, -5e-324, -0.0, 0.0])
    assert law.force(apart, rate).tolist() == [0.0] * 5
    assert law.potential(apart).tolist() == [0.0] * 5


@over_laws
@given(parameters=parameters, depth=depths, rate=rates)
@settings(max_examples=10)
def test_only_the_law_that_means_to_pulls(name, parameters, depth, rate):
    force = law_of(name, *parameters).force(depth, rate)
    assert math.isfinite(force)
    assert force >= 0.0 or name == PULLING


@over_laws
@given(parameters=parameters, depth=depths, rate=rates)
@settings(max_examples=10)
def test_derivatives_are_those_of_the_force(name, parameters, depth, rate):
    """They show nowhere in public: solvers have them from the core."""
    law = law_of(name, *parameters)
    _, stiffness, damping = law._evaluate(np.array(depth), np.array(rate))
    h, g = 1e-5 * depth, 1e-4 * max(abs(rate), 1.0)
    around = law.force(depth + np.array([-h, h]), rate)
    along = law.force(depth, rate + np.array([-g, g]))
    scale = np.abs(law.force(depth, np.array([-rate, 0.0, rate]))).max()
    if (around > 0.0).all() or name == PULLING:
        slope = np.diff(around)[0] / (2.0 * h)
        assert stiffness == pytest.approx(slope, rel=1e-4, abs=1e-4 * scale / depth)
    if (along > 0.0).all() or name == PULLING:
        slope = np.diff(along)[0] / (2.0 * g)
        assert damping == pytest.approx(slope, rel=1e-6, abs=1e-8 * scale)
    if (around == 0.0).all() and (along == 0.0).all():  # cut
        assert stiffness == damping == 0.0


@over_laws
@given(parameters=parameters)
@settings(max_examples=10)
def test_loading_is_monotone(name, parameters):
    law = law_of(name, *parameters)
    depth = np.geomspace(1e-12, min(1e-3, law.limit) * (1 - 1e-9), 300)
    assert (np.diff(law.force(depth)) > 0.0).all()


@over_laws
@given(parameters=parameters, depth=depths, rate=st.floats(0.0, 3.0))
@settings(max_examples=10)
def test_the_way_in_resists_more_than_the_way_out(name, parameters, depth, rate):
    """So that no cycle of loading and unloading gives energy away."""
    law = law_of(name, *parameters)
    inward, still, outward = law.force(depth, np.array([rate, 0.0, -rate]))
    assert inward >= still * (1 - 1e-12) >= outward * (1 - 1e-12) ** 2


@over_laws
@given(parameters=parameters, depth=depths)
@settings(max_examples=10)
def test_what_is_stored_is_at_most_what_was_put_in(name, parameters, depth):
    law = law_of(name, *parameters)
    x, w = np.polynomial.legendre.leggauss(40)
    s = 0.5 + 0.5 * x
    work = float(np.sum(w * s * depth * law.force(depth * s**2)))
    stored = law.potential(depth)
    if law.has_memory:
        assert 0.0 < stored <= work * (1 + 1e-3)
    else:
        assert stored == pytest.approx(work, rel=1e-3 if name == "Tabulated" else 1e-7)


@over_laws
def test_laws_are_values(name):
    law, same = law_of(name), law_of(name)
    assert law == same
    assert hash(law) == hash(same)
    assert law != law_of(name, k=2e10) or name == "UserLaw"
    assert type(law).__name__ in repr(law)
    assert pickle.loads(pickle.dumps(law)) == law
    assert copy.deepcopy(law) == law
    with pytest.raises(AttributeError):
        law.k = 2.0


def test_damped_formulas():
    d, v, m = 0.25, -0.1, 0.04
    assert ao.HuntCrossley(3.0, 2.0).force(d, v) == pytest.approx(3 * d**1.5 * (1 - 0.2))
    assert ao.Tsuji(3.0, 0.4, m).force(d, v) == pytest.approx(
        3 * d**1.5 + 0.4 * math.sqrt(m * 3) * d**0.25 * v
    )
    assert ao.KuwabaraKono(3.0, 0.2).force(d, v) == pytest.approx(
        3 * (d**1.5 + 1.5 * 0.2 * math.sqrt(d) * v)
    )
    assert ao.KelvinVoigt(3.0, 0.5).force(d, v) == pytest.approx(3 * d + 0.5 * v)
    assert ao.KelvinVoigt(3.0, 9.0).force(d, v) == 0.0
    assert ao.KelvinVoigt(3.0, 9.0, end="indentation").force(d, v) == pytest.approx(-0.15)


# χ V / k at e = 0.4, as the papers have it (docs/theory/references.md).
HYSTERESIS = {
    "lankarani-nikravesh": 3 * (1 - 0.4**2) / 4,
    "flores": 8 * (1 - 0.4) / (5 * 0.4),
    "gonthier": (1 - 0.4**2) / 0.4,
    "herbert-mcwhannell": 6 * (1 - 0.4) / ((2 * 0.4 - 1) ** 2 + 3),
    "lee-wang": 3 * (1 - 0.4) / 4,
}


@each("formula, product", HYSTERESIS.items())
def test_published_hysteresis_factors(formula, product):
    made = ao.HuntCrossley.from_restitution(1e9, 0.4, 2.0, 1.3, formula=formula)
    assert made.damping == pytest.approx(product / 2.0)
    assert made.force(1e-3, 0.7) == pytest.approx(1e9 * 1e-3**1.3 * (1 + product / 2.0 * 0.7))
