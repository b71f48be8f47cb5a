"""What is said of runs that are not what was meant: with closed forms for where it begins."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.results import limits

R = 0.01
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800, yield_strength=1.5e9)
ALU = ao.Material(E=70e9, nu=0.3, rho=2700)
SOFT = ao.Material(E=70e9, nu=0.3, rho=2700, yield_strength=100e6)
PAIR = ao.Hertz.between(STEEL, R, STEEL, R)
# Said elsewhere.
OTHERS = "ends in contact", "was fitted to", "the patch has a radius", "and take ao.Shell"

HEAVY = ao.rigid(mass=0.0327)


def plate(material: ao.Material, thickness: float, fixed: Any, point: Any = (0.05, 0.04)) -> Any:
    mesh = ao.box_mesh((0.1, 0.08, thickness), (4, 4, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, material, fixed=fixed)
    return body.contact(point=(*point, thickness), direction=(0, 0, -1))


def star(tip: ao.ContactPoint) -> ao.AOModel:
    return ao.antioscillators(tip, 8, method="krylov", contact_time=2e-4, duration=1e-3)


def strike(target: Any, velocity: float, law: Any = PAIR, **options: Any) -> ao.Result:
    return ao.simulate(
        **{
            "projectile": HEAVY,
            "target": target,
            "law": law,
            "velocity": velocity,
            "duration": 2e-3,
        }
        | options
    )


def said(target: Any, velocity: float, **options: Any) -> list[str]:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always", ao.AOImpactWarning)
        strike(target, velocity, **options)
    texts = [str(one.message) for one in found]
    return [text for text in texts if not any(other in text for other in OTHERS)]


# Largest pressure at which a body yields first, in yield stresses, for ν = 0.3: on the axis at the
# depth z a the principal stresses differ by (1 + ν)(z atan(1/z) - 1) + 1.5/(1 + z²), times p₀
# (K. L. Johnson, Contact Mechanics, eq. 3.45).
ONSET = 1.0 / max(
    1.3 * (z * math.atan(1.0 / z) - 1.0) + 1.5 / (1.0 + z * z) for z in np.linspace(0.4, 0.6, 2001)
)

BOTH_ENDS = [("xmin", "xyz"), ("xmax", "xyz")]


# ------------------------------------------------------------------- pressure


def test_yield_is_said_from_the_pressure_on_at_which_it_begins() -> None:
    """p₀ = 3F/(2πa²), a = √(Rδ), F = kδ^1.5."""
    floor = ao.antioscillators(plate(SOFT, 0.04, [("zmin", "xyz")]), 2)
    law = ao.Hertz.between(STEEL, R, SOFT, math.inf)
    quiet = strike(floor, 1e-4, law)
    wide = math.sqrt(R * (quiet.peak_force / law.k) ** (2 / 3))
    share = 1.5 * quiet.peak_force / (math.pi * wide**2) / (ONSET * SOFT.yield_strength)
    assert share < 1.0
    joint = quiet.plan.contacts[0]
    force = limits(quiet.plan, joint)["yield"].most
    assert quiet.peak_force / force == pytest.approx(share**3, rel=1e-6)
    assert force == pytest.approx(
        ao.Thornton.between(
            STEEL, R, SOFT, math.inf, yield_pressure=ONSET * SOFT.yield_strength
        ).yield_force
    )


def test_a_plastic_law_is_named_with_its_parameters_and_says_no_more() -> None:
    floor = ao.antioscillators(plate(SOFT, 0.04, [("zmin", "xyz")]), 2)
    law = ao.Hertz.between(STEEL, R, SOFT, math.inf)
    (text,) = said(floor, 0.5, law=law)
    assert text.startswith("projectile on target: a force of ")
    assert "1.61 times yield_strength=100 MPa" in text
    plastic = eval(text.partition("Use ")[2].rstrip("."), {"ElasticPlastic": ao.ElasticPlastic})
    expected = ao.ElasticPlastic.between(STEEL, R, SOFT, math.inf)
    assert plastic.k == pytest.approx(expected.k, rel=1e-5)
    assert plastic.yield_force == pytest.approx(expected.yield_force, rel=1e-3)
    assert plastic.hardness == pytest.approx(280e6)
    assert said(floor, 0.5, law=plastic) == []


# ------------------------------------------------------------------- widths and speeds


def test_a_contact_as_wide_as_its_curvature_is_said() -> None:
    """A rigid pair of mass m goes to δ with m v²/2 = 2/5 k δ^2.5; the limit is a = .3 R."""
    relative, mass = R / 2, 0.0327 / 2
    limit = math.sqrt(0.8 * PAIR.k / mass * (0.09 * relative) ** 2.5)
    assert said(HEAVY, 0.99 * limit) == []
    (text,) = said(HEAVY, 1.01 * limit)
    assert "a radius of 0.3 times the radius of curvature R=5 mm, with strains of about 6" in text


def test_speeds_beside_that_of_waves_are_said() -> None:
    floor = ao.antioscillators(plate(ALU, 0.04, [("zmin", "xyz")]), 2)
    soft = ao.Hertz(k=1e9)  # shallow, so that only speed counts
    limit = 0.01 * math.sqrt(ALU.E / ALU.rho)
    light = ao.rigid(mass=1e-9)
    assert said(floor, 0.99 * limit, law=soft, projectile=light, duration=1e-5) == []
    (text,) = said(floor, 1.01 * limit, law=soft, projectile=light, duration=1e-5)
    assert "1.0% of the speed of waves, 5092 m/s" in text


def test_the_speed_of_a_contact_is_that_at_which_its_own_bodies_meet() -> None:
    """A heavy body sends a ball on at twice its speed (Huygens)."""
    ball, soft = ao.ball(1e-4, ALU), ao.Hertz(k=1e9)
    scene = ao.Scene()
    heavy = scene.add(ao.rigid(mass=1.0), velocity=0.0055 * math.sqrt(ALU.E / ALU.rho))
    first, second = scene.add(ball), scene.add(ball)
    scene.connect(heavy, first, soft)
    scene.connect(first, second, soft, gap=1e-3)
    with pytest.warns(ao.AOImpactWarning, match="of the speed of waves"):
        scene.simulate(duration=1e-4)


# ------------------------------------------------------------------- deflection


def test_a_thin_plate_held_on_both_sides_stretches_a_cantilever_does_not() -> None:
    thin = 1e-3
    held = star(plate(ALU, thin, BOTH_ENDS))
    law = ao.Hertz.between(STEEL, R, ALU, math.inf)
    (text,) = said(held, 2.0, law=law)
    assert "target deflects by " in text
    assert "is 1 mm thick: constrained on both sides it stretches" in text
    deflection = np.abs(strike_quietly(held, 2.0, law).target.displacement).max()
    assert deflection > 0.5 * thin
    cantilever = star(plate(ALU, thin, BOTH_ENDS[:1]))
    moved = np.abs(strike_quietly(cantilever, 2.0, law).target.displacement).max()
    assert moved > 0.5 * thin
    assert said(cantilever, 2.0, law=law) == []


def test_supports_that_let_a_body_draw_in_do_not_stretch_it() -> None:
    rollers = star(plate(ALU, 1e-3, [("xmin", "xyz"), ("xmax", "z")]))
    assert said(rollers, 2.0, law=ao.Hertz.between(STEEL, R, ALU, math.inf)) == []


def strike_quietly(target: Any, velocity: float, law: Any) -> ao.Result:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ao.AOImpactWarning)
        return strike(target, velocity, law)


# ------------------------------------------------------------------- no contact


def test_the_duration_that_a_miss_asks_for_is_enough() -> None:
    (text,) = said(HEAVY, 2.0, gap=1e-2)
    assert "no closer than 6 mm, at t = 2 ms; take a duration beyond 5 ms" in text
    assert said(HEAVY, 2.0, gap=1e-2, duration=5.1e-3) == []


def swinging() -> ao.AOModel:
    """A pendulum of 1 kg with 100 rad/s."""
    return ao.AOModel(m0=1.0, k0=1e4)


def test_a_swing_that_does_not_reach_says_how_far_it_came() -> None:
    """x = v/ω sin ωt: 10 mm of 11 at T/4 = 15.708 ms."""
    (text,) = said(HEAVY, 1.0, projectile=swinging(), gap=0.011, duration=0.04)
    assert "they come no closer than 1 mm, at t = 15.7" in text
    assert "a smaller gap, or a larger velocity" in text


def test_how_near_a_vibration_comes_does_not_depend_on_when_it_is_looked_at() -> None:
    """A load at once swings a spring by 2 F/k: 120 periods, of which even times see only F/k."""
    omega, force = 2.0 * np.pi * 120.0 / 20e-3, 100.0
    scene = ao.Scene()
    mass = scene.add(ao.AOModel(m0=1.0, k0=omega**2), name="mass")
    scene.connect(
        mass, scene.add(ao.rigid(np.inf)), ao.Linear(1e9), gap=2 * force / omega**2 + 1e-9
    )
    scene.apply(mass, force=force)
    with pytest.warns(ao.AOImpactWarning, match=r"^mass"):
        scene.simulate(duration=20e-3)


def scene_of(first_speed: float, second_speed: float, *, swapped: bool) -> Any:
    scene = ao.Scene()
    first, second = scene.add(HEAVY, velocity=first_speed), scene.add(HEAVY, velocity=second_speed)
    pair = (second, first) if swapped else (first, second)
    scene.connect(*pair, PAIR)
    return scene


def test_bodies_that_move_apart_are_said_with_the_order_of_a_contact() -> None:
    with pytest.warns(ao.AOImpactWarning, match=r"^body"):
        scene_of(1.0, 0.0, swapped=True).simulate(duration=1e-3)
    assert scene_of(1.0, 0.0, swapped=False).simulate(duration=1e-3).contacts[0].intervals


def test_of_several_contacts_the_worst_is_said_and_only_that() -> None:
    scene = ao.Scene()
    bodies = [scene.add(HEAVY, velocity=v, name=f"ball {v}") for v in (60.0, 0.0, 0.0)]
    scene.connect(bodies[0], bodies[1], PAIR)
    scene.connect(bodies[1], bodies[2], PAIR, gap=1e-5)
    with pytest.warns(ao.AOImpactWarning) as found:
        scene.simulate(duration=1e-4)
    assert len(found) == 1


# ------------------------------------------------------------------- the table of the summary


def advised(hit: ao.Result) -> dict[str, Any]:
    return {of.name: of for of in hit.advice}


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
def test_the_summary_has_how_far_the_limits_are() -> None:
    target = star(plate(SOFT, 0.005, BOTH_ENDS))
    hit = strike(target, 0.5)
    table = advised(hit)
    assert list(table) == ["yield", "deflection", "mass ratio", "speed"]
    deepest = np.abs(hit.target.port_displacements[0]).max()
    assert table["deflection"].value == pytest.approx(deepest / 0.005)
    assert table["mass ratio"].value == pytest.approx(0.0327 / hit.target.mass)
    assert table["speed"].value == pytest.approx(0.5 / math.sqrt(SOFT.E / SOFT.rho))
    for name in table:
        assert f"\n  {name} " in repr(hit)


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
def test_plates_respond_in_three_ways_by_the_ratio_of_masses() -> None:
    """R. Olsson, Composites A 31, 879 (2000): by waves below 0.2, quasi-statically above 2."""
    target = star(plate(SOFT, 0.005, BOTH_ENDS))
    ratios = [0.1, 0.19, 0.21, 1.9, 2.1, 10.0]
    balls = [ao.rigid(mass=ratio * target.mass) for ratio in ratios]
    meant = [advised(strike(target, 0.1, projectile=ball))["mass ratio"].meaning for ball in balls]
    assert meant[0] == meant[1] != meant[2] == meant[3] != meant[4] == meant[5] != meant[0]


@pytest.mark.parametrize(("velocity", "within"), [(1e-4, True), (1.0, False)])
def test_yield_of_a_law_that_yields(velocity: float, within: bool) -> None:
    law = ao.ElasticPlastic.between(STEEL, R, SOFT, math.inf)
    hit = ao.simulate(HEAVY, ao.rigid(mass=math.inf), velocity, law=law)
    found = advised(hit)["yield"]
    assert found.within == within
    assert found.value == pytest.approx(hit.peak_force / law.yield_force)
    assert ("\n  residual dent" in repr(hit)) == (not within)
