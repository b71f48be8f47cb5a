"""Shares of a tolerance: more costs more than it must, less breaks the tolerance."""

from __future__ import annotations

import itertools
import math
import warnings
from typing import Any

import numpy as np
import pytest
from test_comparison import bounce, swinging_table, with_touches
from test_comparison import bouncing as bounces

import aoimpact as ao
from aoimpact.integrate import comparison, to_tolerance, tolerances
from aoimpact.integrate.dense import DenseRecorder, adaptive_run
from aoimpact.results import Run

MASS = 0.0327

Runs = list[tuple[float, int]]


def chain(wider: float) -> ao.Scene:
    """Four balls before a body that rings: every touch passes the errors before on."""
    scene = ao.Scene()
    masses = (0.043798397509269636, 0.013447582716396483, 0.012992958465073874, 0.04501378386566669)
    balls = [scene.add(ao.rigid(mass=m), velocity=float(i == 0)) for i, m in enumerate(masses)]
    ringing = ao.AOModel(
        m0=0.006767743045921313,
        k0=15543.94530511359,
        m=[0.00319483, 0.0035079],
        k=[2348477.37070769, 267821.39966979],
    )
    gaps = (8.115818608370813e-06, 4.007804782682372e-06, 6.000031170602173e-06, 1e-05)
    bodies = [*balls, scene.add(ringing)]
    for (one, other), gap in zip(itertools.pairwise(bodies), gaps, strict=True):
        scene.connect(one, other, ao.Hertz(k=2442677664.5938854), gap=(1.0 + wider) * gap)
    return scene


def bouncing() -> ao.Scene:
    scene = ao.Scene(gravity=9.81)
    ball, floor = scene.add(ao.rigid(mass=MASS), velocity=1.0), scene.add(ao.rigid(mass=math.inf))
    scene.connect(ball, floor, ao.Hertz(k=1e10))
    return scene


def row_of_balls(mass: float) -> ao.Scene:
    """Four balls in a row, the first of which strikes the next one."""
    scene = ao.Scene()
    balls = [scene.add(ao.rigid(mass=mass), velocity=float(i == 0)) for i in range(4)]
    for one, other in itertools.pairwise(balls):
        scene.connect(one, other, ao.Hertz(k=1e10), gap=1e-4)
    return scene


def run(scene: ao.Scene, duration: float, rtol: float) -> DenseRecorder:
    done = scene.simulate(duration=duration, solver=ao.Adaptive(rtol=rtol), energies=False)
    assert isinstance(done.recorder, DenseRecorder)
    return done.recorder


def test_a_second_run_less_tight_may_be_wrong_and_one_more_tight_costs_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # A loose tolerance, at which a scene is short, stands for all.
    monkeypatch.setattr(to_tolerance, "OTHER_STEPS", 1.0)
    monkeypatch.setattr(to_tolerance, "SEVERAL", 1.0)
    gaps = (0.0, 0.01, 0.02)  # one scene alone may be right by chance
    exact = [run(chain(wider), 3.47e-3, 1e-7) for wider in gaps]
    errors, costs = [], []
    for scatter in np.array([1.0 / 3.0, 1.0, 3.0]) * to_tolerance.SPREAD:
        monkeypatch.setattr(to_tolerance, "SPREAD", scatter)
        found = [run(chain(wider), 3.47e-3, 1e-3) for wider in gaps]
        errors.append(max(map(comparison.difference, found, exact, (1.0, 1.0, 1.0))) / 1e-3)
        costs.append(run(bouncing(), 2.0, 1e-8).steps)
    assert errors[0] > 1.0 > errors[1]
    assert costs[2] > 1.05 * costs[1]


def test_a_smaller_share_for_scenes_of_several_contacts_costs_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """That a larger one may be wrong is shown by tests/tools/test_campaign.py."""
    costs = []
    for share in np.array([1.0 / 3.0, 1.0]) * to_tolerance.SEVERAL:
        monkeypatch.setattr(to_tolerance, "SEVERAL", share)
        rows = [row_of_balls(mass) for mass in np.linspace(0.02, 0.05, 16)]
        costs.append(sum(run(row, 1e-3, 1e-8).steps for row in rows))
    assert costs[0] > 1.1 * costs[1]


@pytest.mark.parametrize(("share", "quiet"), [(0.001, True), (0.1, True), (0.0, False)])
def test_starts_of_touches_from_rest_are_not_compared(
    share: float, quiet: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Balls in a row before a wall: the wave presses them on each other from rest."""
    monkeypatch.setattr(comparison, "SUDDEN", share)
    scene = ao.Scene()
    balls = [scene.add(ao.rigid(mass=0.03), velocity=float(i == 0)) for i in range(6)]
    for one, other in itertools.pairwise(balls):
        scene.connect(one, other, ao.Hertz(k=1e9))
    scene.connect(balls[-1], scene.add(ao.rigid(mass=math.inf)), ao.Hertz(k=1e9), gap=1e-4)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        scene.simulate(duration=2e-3, solver=ao.Adaptive(rtol=1e-8), energies=False)
    assert (not said) == quiet


def end_speed(stiffness: float) -> float:
    """Speed of a ball of 1 m/s after four touches of two walls; 0 where that is refused."""
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=MASS), velocity=1.0)
    left, right = (scene.add(ao.rigid(mass=math.inf)) for _ in range(2))
    scene.connect(ball, right, ao.Linear(stiffness), gap=0.1)
    scene.connect(left, ball, ao.Linear(stiffness), gap=0.1)
    try:
        return abs(scene.simulate(duration=0.75, energies=False)[ball].velocity[-1])
    except ao.ConvergenceError:
        return 0.0


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:rtol=1e-08 cannot be met")
def test_energy_that_nothing_gave_is_refused_and_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some walls are so stiff that a contact is over within the last digits of its time."""
    found = []
    for gain in np.array([1.0 / 3.0, 1.0, 3.0]) * to_tolerance.GAIN:
        monkeypatch.setattr(to_tolerance, "GAIN", gain)
        fastest = max(map(end_speed, np.geomspace(1e31, 4e32, 12)))
        found.append((end_speed(1e10), fastest))
    (refused, _), (sound, little), (_, much) = found
    assert refused == 0.0
    assert sound == pytest.approx(1.0, rel=1e-7)
    assert little < 1.25 < 1.5 < much  # the root of the energy


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> Runs:
    """Tolerance and steps of each run that the core makes."""
    made: Runs = []

    def counted(plan: Any, **options: Any) -> DenseRecorder:
        run = adaptive_run(plan, **options)
        made.append((options["rtol"], run.steps))
        return run

    monkeypatch.setattr(to_tolerance, "adaptive_run", counted)
    return made


def chaotic(rtol: float) -> Run:
    scene, _ = swinging_table()
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        return scene.simulate(duration=8.0, solver=ao.Adaptive(rtol=rtol), energies=False)


def column(count: int) -> Run:
    """Bodies at rest on the floor under their weight, held by a law that pulls as well."""
    scene, law = ao.Scene(gravity=9.81), ao.KelvinVoigt(k=1e7, c=10.0, end="indentation")
    below = scene.add(ao.rigid(mass=math.inf))
    for number in range(count):
        body = scene.add(ao.rigid(mass=0.1 + 0.03 * number))
        scene.connect(body, below, law)
        below = body
    return scene.simulate(duration=1e-2, preload=True, energies=False)


def worst_of_ten_bounces(rtol: float) -> float:
    """The largest error of peaks, starts and ends that single runs make, over springs."""
    errors = []
    for stiffness in np.geomspace(1e9, 1e11, 12):
        plan = bounces(10, 1e-9, stiffness)[0].recorder.plan
        of = adaptive_run(plan, rtol=rtol).events[0]
        peak, touch, free = bounce(stiffness)
        starts, spans = (touch + free) * np.arange(10), np.array(of.contacts)
        errors += [abs(of.peak_force / peak - 1.0), abs(spans[:, 1] / (starts + touch) - 1.0).max()]
    return max(errors)


def test_below_the_floor_no_digit_is_won_and_above_it_one_is() -> None:
    floor = worst_of_ten_bounces(tolerances.FLOOR)
    assert worst_of_ten_bounces(0.01 * tolerances.FLOOR) > 0.5 * floor
    assert worst_of_ten_bounces(tolerances.TIGHTEST) > 3.0 * floor


def test_a_touch_counts_from_a_hundredth_of_the_largest_on() -> None:
    run = bounces(2, 1e-3)[0].recorder
    first = (0.0, 1e-4, 1.0, 2.0)

    def apart(share: float) -> float:
        ones = with_touches(run, [first, (2e-4, 3e-4, share, 2.0)])
        others = with_touches(run, [first, (2.1e-4, 3.1e-4, share, 2.0)])
        return comparison.difference(ones, others, 1.0)

    assert apart(2.0 * tolerances.LESSER) == pytest.approx(1.0 / 31.0)
    assert apart(0.5 * tolerances.LESSER) == 0.0


def test_a_touch_begins_at_a_certain_time_from_a_hundredth_of_its_mean_rate_on() -> None:
    run = bounces(2, 1e-3)[0].recorder
    first = (0.0, 1e-4, 1.0, 2.0)

    def apart(pace: float) -> float:
        ones = with_touches(run, [first, (2e-4, 3e-4, 1.0, pace)])
        others = with_touches(run, [first, (2.1e-4, 3e-4, 1.0, pace)])
        return comparison.difference(ones, others, 1.0)

    assert apart(3.0 * tolerances.SUDDEN) == pytest.approx(1.0 / 30.0)
    assert apart(0.3 * tolerances.SUDDEN) == 0.0


def test_an_error_of_more_than_a_fifth_is_no_digit() -> None:
    """A half sine in 3.5 and in 2.5 steps has impulses that are 4 % and 6 % off."""
    spring, mass = 1e7, 0.1
    length = math.pi * math.sqrt(mass / spring)
    claimed = []
    for steps in (3.5, 2.5):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            hit = ao.simulate(
                projectile=ao.rigid(mass=mass),
                target=ao.rigid(mass=math.inf),
                law=ao.Linear(k=spring),
                velocity=1.0,
                duration=4.0 * length,
                solver=ao.Newmark(dt=length / steps),
            )
        claimed.append((hit.error.time, any("far too large" in str(one.message) for one in said)))
    assert 0.5 * tolerances.NO_DIGIT < claimed[0][0] < tolerances.NO_DIGIT
    assert not claimed[0][1]
    assert claimed[1] == (1.0, True)


def test_runs_that_differ_by_more_than_a_little_show_that_errors_multiply(
    monkeypatch: pytest.MonkeyPatch, runs: Runs
) -> None:
    bounces(10, 1e-3)
    assert len(runs) == 2
    assert chaotic(1e-7).error.time == 1.0
    with monkeypatch.context() as patch:
        patch.setattr(to_tolerance, "LINEAR", 1e-3 * tolerances.LINEAR)
        runs.clear()
        bounces(10, 1e-3)
        assert len(runs) == 3
    monkeypatch.setattr(to_tolerance, "LINEAR", 1.0)
    tight = chaotic(1e-7)
    bold = [chaotic(rtol) for rtol in (1e-4, 3e-5, 1e-5)]  # one alone may be right by chance
    apart = [comparison.difference(run.recorder, tight.recorder, 1.0) for run in bold]
    assert min(run.error.time / of for run, of in zip(bold, apart, strict=True)) < 0.5


def test_a_tighter_first_comparison_takes_more_steps(
    monkeypatch: pytest.MonkeyPatch, runs: Runs
) -> None:
    """A frame that rattles shows the errors that a looser one lets pass (tests/tools)."""
    bounces(10, 1e-3)
    usual = sum(steps for _, steps in runs)
    runs.clear()
    monkeypatch.setattr(to_tolerance, "OTHER_STEPS", 1e-3 * tolerances.OTHER_STEPS)
    bounces(10, 1e-3)
    assert sum(steps for _, steps in runs) > 1.5 * usual


def test_less_patience_loses_a_result_and_more_waits_for_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = 0

    def rippled(depth: float, rate: float) -> float:
        nonlocal asked
        asked += 1
        return 1e9 * depth**1.5 * (1.0 + 1e-9 * math.sin(1e12 * depth + 7e8 * rate))

    def bounce_on_ripples(patience: int) -> int:
        nonlocal asked
        asked = 0
        monkeypatch.setattr(to_tolerance, "PATIENCE", patience)
        scene = ao.Scene(gravity=9.81)
        ball, floor = scene.add(ao.rigid(mass=0.03), velocity=1.0), scene.add(ao.rigid(math.inf))
        scene.connect(ball, floor, ao.UserLaw(rippled))
        with pytest.warns(ao.AOImpactWarning, match=r"^rtol"):
            run = scene.simulate(duration=0.7, solver=ao.Adaptive(rtol=1e-8), energies=False)
        assert run.error.time is None
        return asked

    assert bounce_on_ripples(5 * tolerances.PATIENCE) > 3 * bounce_on_ripples(tolerances.PATIENCE)
    monkeypatch.setattr(to_tolerance, "PATIENCE", tolerances.PATIENCE)
    assert bounces(10, 1e-3)[0].error.time == 1e-3
    monkeypatch.setattr(to_tolerance, "PATIENCE", tolerances.PATIENCE // 12)
    with pytest.warns(ao.AOImpactWarning, match=r"^rtol"):
        assert bounces(10, 1e-3)[0].error.time is None


def test_bodies_at_rest_are_measured_by_their_impulses(monkeypatch: pytest.MonkeyPatch) -> None:
    assert column(2).error.time == 1e-8
    with monkeypatch.context() as patch:
        patch.setattr(comparison, "AT_REST", 0.0)
        with pytest.warns(ao.AOImpactWarning, match=r"^rtol"):
            assert column(2).error.time == 1.0
