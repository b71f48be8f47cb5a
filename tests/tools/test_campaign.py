"""The campaign of random scenes: its own parts, and a minute of it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from campaign.case import Body, Case, Contact, Frame, Law, Load
from campaign.generate import case_of
from campaign.judge import judge
from campaign.oracle import Oracle

HERTZ = Law("Hertz", {"k": 1e9})
WALL = Body(math.inf)


def test_a_seed_is_one_scene() -> None:
    for seed in range(30):
        assert case_of(seed) == case_of(seed)


def test_the_oracle_has_the_closed_form_of_a_rigid_pair() -> None:
    case = Case((Body(1.0, velocity=1.0), WALL), (Contact(0, 1, HERTZ),), duration=2e-3)
    outcome = Oracle(case).run()
    deepest = (1.25 / 1e9) ** 0.4
    assert outcome.peaks[0] == pytest.approx(1e9 * deepest**1.5, rel=1e-10)
    length = 2.0 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9) * deepest
    (touch,) = outcome.touches[0]
    assert touch.end - touch.start == pytest.approx(length, rel=1e-9)
    assert outcome.velocities[0] == pytest.approx(-1.0, rel=1e-10)


def test_the_oracle_has_the_closed_form_of_springs_on_a_massless_coordinate() -> None:
    # Two linear contacts press it: three springs in balance, and a mass on what they come to.
    soft = Law("Linear", {"k": 1e6})
    star = Body(0.0, m=(1e9,), k=(3e6,))  # as good as held
    bodies = (star, Body(1.0, velocity=1.0), Body(1.0, velocity=1.0))
    case = Case(bodies, (Contact(1, 0, soft), Contact(2, 0, soft)), duration=1e-3)
    stiffness = 1.0 / (1.0 / 1e6 + 2.0 / 3e6)  # they move alike: each has half of the star
    omega = math.sqrt(stiffness)
    outcome = Oracle(case).run()
    assert outcome.impulses[0] == pytest.approx(1.0 - math.cos(omega * 1e-3), rel=1e-7)


@pytest.mark.slow
def test_dashpots_on_a_massless_coordinate_are_the_limit_of_small_masses() -> None:
    law = Law("HuntCrossley", {"k": 1e9, "damping": 0.5, "n": 1.5})
    bodies = (Body(0.0, m=(1.0,), k=(1e7,)), Body(1.0, velocity=1.0), Body(2.0, velocity=-0.5))
    contacts = (Contact(1, 0, law), Contact(0, 2, HERTZ, 1e-4))
    case = Case(bodies, contacts, duration=1.5e-3)
    limit = Oracle(case, rtol=1e-9).run()
    light = replace(case, bodies=(replace(bodies[0], m0=1e-3), *bodies[1:]))
    apart = Oracle(light, rtol=1e-8).run().impulses / limit.impulses - 1.0
    assert np.abs(apart).max() < 2e-3


@pytest.mark.parametrize("gap", [1e-5, pytest.param(0.0, marks=pytest.mark.slow)])
def test_a_dashpot_takes_a_load_that_sets_in_on_a_massless_coordinate(gap: float) -> None:
    # At once; but for what the spring takes over the gap.
    law = Law("KelvinVoigt", {"k": 1e7, "c": 1e4, "end": "force"})
    bodies = (Body(0.0, m=(1.5,), k=(6e8,)), Body(2.0))
    case = Case(bodies, (Contact(0, 1, law, gap),), (Load(0, (0.0,), (5e4,)),), duration=1e-7)
    outcome = Oracle(case, rtol=1e-6).run()
    assert outcome.peak_times[0] == 0.0
    assert outcome.peaks[0] == pytest.approx(5e4 - 6e8 * gap, rel=1e-12)
    # One that has no force yet at the touch loses it within less time than a run resolves.
    other = Law("HuntCrossley", {"k": 1e11, "damping": 1.0, "n": 1.5})
    unresolved = replace(case, contacts=(Contact(0, 1, other, gap),))
    assert np.isnan(Oracle(unresolved, rtol=1e-6).run().peaks[0])


def test_the_oracle_s_peak_is_the_largest_force_on_its_curve() -> None:
    # The second contact makes a kink in the force of the first, beside its top.
    frame = Frame((2.736, 5.153, 0.2668, 3.794), (1.411e12, 1.265e9, 1.16e8), (1.635e8, 0, 0, 0))
    bodies = (frame, Body(0.55, velocity=10.0), Body(2.1, velocity=8.3))
    contacts = (
        Contact(1, 0, Law("Linear", {"k": 5.4e9}), 0.0, (0, 2)),
        Contact(2, 0, Law("Hertz", {"k": 1.35e13}), 2.84e-4, (0, 2)),
    )
    outcome = Oracle(Case(bodies, contacts, duration=6e-5), rtol=1e-9).run()
    assert outcome.force_at is not None
    for c, (peak, when) in enumerate(zip(outcome.peaks, outcome.peak_times, strict=True)):
        times = np.linspace(max(0.0, when - 1e-6), min(6e-5, when + 1e-6), 400)
        largest = max(outcome.force_at(c, float(t)) for t in times)
        assert largest <= peak * (1.0 + 1e-9)


@pytest.mark.slow
def test_two_loose_runs_that_take_the_same_steps_do_not_confirm_each_other() -> None:
    # The ends of a frame rattle between light balls, each touch multiplying the first one's error.
    frame = Frame((0.0001402, 0.01725, 0.0001402), (574.7, 574.7), (0.0, 0.0, 0.0))
    balls = (Body(8.861e-05, velocity=0.6452), Body(8.861e-05, velocity=-0.6452))
    stiff = Law("Hertz", {"k": 198200.0})
    contacts = (
        Contact(1, 0, Law("Hertz", {"k": 44.51}), 0.0, (0, 1)),
        Contact(2, 0, stiff),
        Contact(0, 3, stiff, 0.0, (2, 0)),
        Contact(0, 4, Law("Hertz", {"k": 2477.0}), 0.01571),
    )
    bodies = (frame, Body(0.1359, velocity=6.031), *balls, WALL)
    case = Case(bodies, contacts, duration=0.2307, rtol=6.241e-5)
    assert judge(case).kind == "ok"


def test_a_wrong_answer_is_seen() -> None:
    # The tolerance is not what the run was made with.
    case = Case((Body(1.0, velocity=1.0), Body(2.0)), (Contact(0, 1, HERTZ),), duration=2e-3)
    assert judge(case).kind == "ok"
    loaded = replace(case, loads=(Load(1, (0.0, 1e-3), (0.0, 500.0)),), preload=False)
    assert judge(loaded).kind == "ok"


def test_damped_frames_and_patches_have_the_package_s_answer() -> None:
    patched = replace(HERTZ, removed=1e-9)
    for damping in (("Rayleigh", 10.0, 1e-6), ("ModalDamping", 0.05)):
        frame = Frame((0.3, 0.5), (1e6,), (0.0, 1e5), damping=damping)
        bodies = (Body(1.0, velocity=1.0), frame)
        case = Case(bodies, (Contact(0, 1, patched, 0.0, (0, 0)),), duration=2e-3, rtol=1e-8)
        verdict = judge(case)
        assert verdict.kind == "ok", verdict


@pytest.mark.parametrize(
    "share",
    [1.0 - 1e-6, 1.0 + 1e-6, *(pytest.param(of, marks=pytest.mark.slow) for of in (0.9, 1.1))],
)
def test_a_contact_stiffer_than_what_is_taken_out_has_to_be_refused(share: float) -> None:
    """The work of a law to where c dF/dδ is 0.95 is (0.4 - 0.95/3) k D^2.5: here all of 1/2 J."""
    k = HERTZ.arguments["k"]
    deepest = (0.5 / ((0.4 - 0.95 / 3.0) * k)) ** 0.4
    just = 0.95 / (1.5 * k * deepest**0.5)
    law = replace(HERTZ, removed=share * just)
    bodies = (Body(1.0, velocity=1.0), WALL)
    verdict = judge(Case(bodies, (Contact(0, 1, law),), duration=2e-3, rtol=1e-8))
    assert verdict.kind == "ok", verdict
    assert ("patch" in verdict.why) == (share > 1.0)


# Kinds of scenes of which all are right today, and how many of each: half a minute.
KINDS = {"pair": 25, "chain": 15}


@pytest.mark.slow
@pytest.mark.parametrize("family", KINDS)
def test_random_scenes(family: str) -> None:
    cases = (case_of(seed) for seed in range(10**6, 10**6 + 1000))
    # A massless coordinate that two contacts press has another answer.
    single = (case for case in cases if not any(body.massless for body in case.bodies[1:-1]))
    chosen = (case for case in single if case.family == family)
    for case in itertools.islice(chosen, KINDS[family]):
        verdict = judge(case)
        assert verdict.kind in ("ok", "warned"), f"{verdict.kind}: {verdict.why}\n{case.script()}"
