"""What shares out a tolerance: more costs more than it must, less breaks the tolerance."""

from __future__ import annotations

import itertools
import math
import warnings

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.integrate import comparison, to_tolerance
from aoimpact.integrate.dense import DenseRecorder

MASS = 0.0327


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
    exact = [run(chain(wider), 3.47e-3, 1e-8) for wider in gaps]
    errors, costs = [], []
    for scatter in np.array([1.0 / 3.0, 1.0, 3.0]) * to_tolerance.SCATTER:
        monkeypatch.setattr(to_tolerance, "SCATTER", scatter)
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
    """Of a ball of 1 m/s after four touches of two walls; 0 where that is refused."""
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
