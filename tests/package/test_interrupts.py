"""No run ignores Ctrl-C for more than a tenth of a second.

Building a model may: a call of LAPACK, SuperLU or PARDISO ends first.
"""

import signal
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a timer that interrupts")


def load() -> Callable[[], Any]:
    times = np.linspace(0.0, 1.0, 1_500_000)
    scene = ao.Scene()
    ball, wall = scene.add(ao.rigid(1.0)), scene.add(ao.rigid(np.inf))
    scene.connect(ball, wall, ao.Hertz(1e8))
    scene.apply(ball, force=(times, 100.0 + np.sin(40.0 * times)))
    return lambda: scene.simulate(duration=1.0, preload=True, solver=ao.Newmark(dt=1e-3))


def flying(scene: ao.Scene, wall: Any) -> Callable[[], Any]:
    """A run of a scene in which another ball flies far off, under a load of a million points."""
    times = np.linspace(0.0, 1.0, 1_000_000)
    ball = scene.add(ao.rigid(1.0))
    scene.connect(ball, wall, ao.Hertz(1e8), gap=1e6)
    scene.apply(ball, force=(times, 5.0 + np.sin(4000.0 * times)))
    return lambda: scene.simulate(duration=0.2)


def load_in_flight() -> Callable[[], Any]:
    scene = ao.Scene()
    return flying(scene, scene.add(ao.rigid(np.inf)))


def load_beside_a_contact() -> Callable[[], Any]:
    scene = ao.Scene()
    wall, pressed = scene.add(ao.rigid(np.inf)), scene.add(ao.rigid(1.0))
    scene.connect(pressed, wall, ao.KelvinVoigt(1e3, 100.0))
    scene.apply(pressed, force=10.0)
    return flying(scene, wall)


MAKERS = [
    load,
    load_in_flight,
    load_beside_a_contact,
]


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
@pytest.mark.parametrize("make", MAKERS)
def test_signals_take_effect(make: Callable[[], Callable[[], Any]]) -> None:
    """By the time that this thread computed meanwhile: others may have the processor."""
    call = make()
    times = [time.thread_time()]
    before = signal.signal(signal.SIGALRM, lambda *_: times.append(time.thread_time()))
    signal.setitimer(signal.ITIMER_REAL, 0.01, 0.01)
    try:
        call()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    times.append(time.thread_time())
    assert np.diff(times).max() < 0.1
