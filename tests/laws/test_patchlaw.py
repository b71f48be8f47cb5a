"""A law with its patch's compliance taken out: F = law(δ + c F), to rounding."""

import math

import mpmath
import numpy as np
import pytest
from every_law import LAWS, law_of
from hypothesis import given, settings
from hypothesis import strategies as st
from rigid_pair import on_a_wall
from rows import each

import aoimpact as ao
from aoimpact.laws import PatchLaw

K, C = 1.0878566e10, 3e-10  # of steel balls of 10 mm, of a patch of some 4 mm


def exact(k, c, delta, n=1.5, factor=1.0):
    """Force and its slope by mpmath: the smaller root d of d - c k factor dⁿ = δ."""
    with mpmath.workdps(60):
        k, c, delta, n = (mpmath.mpf(x) for x in (k, c, delta, n))
        k = k * mpmath.mpf(factor)
        d = delta
        for _ in range(400):  # Newton from below on a concave function does not overshoot
            step = (delta - d + c * k * d**n) / (1 - c * k * n * d ** (n - 1))
            d += step
            if abs(step) < mpmath.mpf(10) ** -50 * d:
                break
        slope = k * n * d ** (n - 1)
        return float(k * d**n), float(slope / (1 - c * slope))


@given(
    k=st.floats(1e3, 1e14),
    share=st.floats(1e-9, 0.949),
    n=st.sampled_from([1.2, 1.5, 2.0, 2.5]),
    rate=st.floats(-1.0, 1.0),
)
@settings(max_examples=200)
def test_force_and_slope_are_those_of_the_inverted_law(k, share, n, rate):
    """From where c F vanishes beside δ up to nearly where nothing is left of the law.

    Slopes show nowhere in public: solvers have them from the core.
    """
    deep = 1e-5
    factor = 1.0 + 0.3 * rate
    c = share / (k * factor * n * deep ** (n - 1))
    delta = deep - c * k * factor * deep**n
    law = PatchLaw(ao.HuntCrossley(k, 0.3, n), c)
    force, stiffness, damping = (
        float(value) for value in law._evaluate(np.array(delta), np.array(rate))
    )
    wanted, slope = exact(k, c, delta, n, factor)
    # δ itself is only known to rounding, which the slope passes on.
    slack = 4e-15 + 4e-16 * slope * delta / wanted
    assert force == pytest.approx(wanted, rel=slack)
    assert stiffness == pytest.approx(slope, rel=4e-14 / (1.0 - share))
    assert damping == pytest.approx(
        0.3 / factor * wanted * stiffness / (slope * (1 - share)), rel=1e-12
    )


def test_the_law_stands_while_it_is_no_stiffer_than_what_is_removed():
    """With c = 1.2/(r E*) of two like bodies, c dF/dδ = 1.2 a/r: a is 0.95/1.2 r at the limit."""
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    modulus, radius, r = 210e9 / (1 - 0.3**2), 0.005, 2e-4
    law = ao.Hertz.between(steel, 0.01, steel, 0.01).within_patch(1.2 / (r * modulus))
    own = law.limit + law.compliance * law.force(law.limit)
    assert math.sqrt(radius * own) == pytest.approx(0.95 / 1.2 * r, rel=1e-9)


def test_a_plastic_law_stands_while_its_unloading_does():
    """It starts with Hertz's slope at the deepest point, 3/2 k √δ*, steeper than the way in."""
    law = ao.Thornton(K, 10.0).within_patch(2e-8)
    own = law.limit + law.compliance * law.force(law.limit)
    assert 2e-8 * 1.5 * K * math.sqrt(own) == pytest.approx(0.95, rel=1e-12)


@each("name", sorted(LAWS))
@each("energy", [1e-20, 1e-8, 1.0])
def test_the_stroke_of_an_energy_is_where_the_work_is_that(name, energy):
    law = law_of(name)
    depth = law.stroke(energy)
    x, w = np.polynomial.legendre.leggauss(60)
    s = 0.5 + 0.5 * x
    work = float(np.sum(w * s * depth * law.force(depth * s**2)))
    assert work == pytest.approx(energy, rel=2e-3 if name == "Tabulated" else 1e-4)


def test_the_stroke_ends_where_the_law_does():
    law = ao.Hertz(K).within_patch(3e-8)
    assert law.stroke(100.0) == pytest.approx(law.limit, rel=1e-9)


@each("solver", [ao.Newmark(dt=2e-8), ao.Adaptive(rtol=1e-9)])
def test_an_elastic_impact_on_a_patch_keeps_its_energy(solver):
    mass, speed, law = 0.016, 1.0, ao.Hertz(K).within_patch(C)
    hit = on_a_wall(law, mass, speed, solver)
    assert hit.restitution == pytest.approx(1.0, abs=1e-6)
    deepest = hit.indentation.max()
    assert law.potential(deepest - C * hit.peak_force) == pytest.approx(
        mass * speed**2 / 2, rel=1e-3
    )
    assert hit.peak_force == pytest.approx(ao.Hertz(K).force(deepest), rel=1e-3)


@each("solver", [ao.Newmark(dt=2e-8), ao.Adaptive(rtol=1e-9)])
def test_a_spring_in_series_is_a_compliance_below_zero(solver):
    """Linear in series with 1/k is (1/K + 1/k)⁻¹: peak force v √(k m); and F = law(δ - F/k)."""
    law = ao.Linear(1e8).within_patch(-1e-8)
    assert on_a_wall(law, 0.016, 1.0, solver).peak_force == pytest.approx(
        np.sqrt(5e7 * 0.016), rel=1e-6
    )
    law = ao.Hertz(K).within_patch(-5e-9)
    force = law.force(2e-5)
    assert force == pytest.approx(ao.Hertz(K).force(2e-5 - 5e-9 * force), rel=1e-12)
    hit = on_a_wall(law, 0.016, 1.0, solver)
    assert hit.restitution == pytest.approx(1.0, abs=1e-6)
    moved = hit.indentation.max() + 5e-9 * hit.peak_force
    assert law.potential(moved) == pytest.approx(0.008, rel=1e-3)
    assert "compliance of the mesh added: 5 nm/N" in str(law)
