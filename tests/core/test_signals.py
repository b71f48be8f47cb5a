"""Ctrl-C takes effect within a tenth of a second, whatever the core is doing."""

import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress

import numpy as np
import numpy.typing as npt
import pytest

from aoimpact import _core

Array = npt.NDArray[np.float64]
Call = Callable[[], object]

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a timer that interrupts")


def numbers(*values: float) -> Array:
    return np.array(values, dtype=np.float64)


def hertz(k: float) -> tuple[object, ...]:
    return "hertz", (k,), 0.0, np.inf, np.full(3, np.nan), None


def in_modes(**parts: object) -> tuple[object, ...]:
    return tuple(parts.get(name) for name in _core.MODES.split())


def body(omega: Array) -> tuple[object, ...]:
    """A free body in those modes, all of which a force moves alike."""
    ones = np.ones(len(omega))
    ports = {"shape": ones[None], "push": 1e-3 * ones[None]}
    return in_modes(omega=omega, inertia=ones, centre=ones, **ports)


def law() -> Call:
    n = 20_000_000
    depth, rate = np.linspace(1e-6, 1e-3, n), np.zeros(n)
    power = "power", (1e9, 1.37), 0.0, np.inf, np.full(3, np.nan), None
    answers = [np.empty(n) for _ in range(3)]
    return lambda: _core.law_force(power, depth, rate, *answers, False)


def to_modal() -> Call:
    k = np.arange(1.0, 10_001.0)
    room = np.empty(len(k) + 1), np.empty(len(k) + 1), np.empty(len(k))
    return lambda: _core.star_to_modal(1.0, 1.0, k / k, k, *room)


def from_modal() -> Call:
    omega2 = np.arange(1.0, 10_001.0)
    room = np.empty(len(omega2) - 1), np.empty(len(omega2) - 1)
    return lambda: _core.star_from_modal(omega2, omega2 / omega2, *room)


def track(count: int) -> tuple[object, Array]:
    """A track of free motion in so many modes, and sample times."""
    bodies = body(np.linspace(0.0, 1e4, count)), body(np.zeros(1))
    contacts = ((0, 0, 1, 0, 1.0, hertz(1e6)),)
    moving = np.zeros(count), np.zeros(1)
    made, *_ = _core.adaptive(bodies, contacts, 1e-6, 1.0, None, moving, (0.0, 0.0), sys.maxsize)
    return made, np.linspace(0.0, 1.0, 20_000_000 // count)


def sample() -> Call:
    made, _ = track(2000)
    times = np.linspace(0.0, 1.0, 20_000) ** 1.5
    record = np.zeros((20, len(times)))
    return lambda: _core.track_read(made, times, 1, 0, record)


def sample_evenly() -> Call:
    """Even times take a fraction of the work."""
    made, _ = track(2000)
    times = np.linspace(0.0, 1.0, 150_000)
    record = np.zeros((20, len(times)))
    return lambda: _core.track_read(made, times, 1, 0, record)


def states() -> Call:
    made, _ = track(2000)
    times = np.linspace(0.0, 1.0, 40_000)  # a quarter as many are over in 0.1 s
    found = np.empty((len(times), 4000))
    return lambda: _core.track_read(made, times, 3, 0, found)


def forces() -> Call:
    made, times = track(1)
    found = np.empty((1, len(times)))
    return lambda: _core.track_read(made, times, 2, 0, found)


def touch() -> Call:
    """Two modes that beat, seldom so far that they touch the wall."""
    bodies = body(1e6 * numbers(1.0, 1.0 + 1e-9)), body(np.zeros(1))
    contacts = ((0, 0, 1, 0, 1.0, hertz(1e6)),)
    moving = np.zeros(2), np.zeros(1)
    return lambda: _core.adaptive(
        bodies, contacts, 1e-6, 1e3, numbers(0.6, -0.6, 0.0), moving, (0.0, 0.0), sys.maxsize
    )


def briefs() -> Call:
    cases = 500
    standing = body(np.zeros(1)), body(np.linspace(0.0, 1e6, 300))
    which, answers = np.tile(np.array([0, 1, 0], np.int32), (cases, 1)), np.zeros((cases, 10))
    each = np.tile(numbers(1.0, 0.0, 1e-2, 1e-8), (cases, 1))
    moving = np.ones(1), np.zeros(300)
    return lambda: _core.briefs(standing, moving, (hertz(1e9),), which, each, answers)


def masses() -> Call:
    """Accelerations of a finite-element body."""
    n, mass = 400_000, np.logspace(0.0, 8.0, 400_000)
    start, indices = np.arange(n + 1, dtype=np.int32), np.arange(n, dtype=np.int32)
    # A mass matrix that is not diagonal, so that accelerations take iterations.
    pairs = np.stack([mass, np.full(n, 0.7 * mass.min())], axis=1).ravel()
    beside = np.stack([indices, indices ^ 1], axis=1).ravel().astype(np.int32)
    b = np.zeros(n)
    b[0] = 1.0
    matrices = (start, indices, np.ones(n)), (2 * start, beside, pairs), 0.0, 0.0, bytearray
    pulled = {"centre": np.zeros(n), "gravity": np.linspace(1.0, 2.0, n), "full": matrices}
    one, none = np.ones(1), np.zeros(1)
    wall = {"omega": none, "shape": one, "push": none, "inertia": none, "centre": one}
    scene = in_modes(shape=b, push=b, **pulled), in_modes(**wall)
    record = np.zeros((20, 100))
    contacts, start_at = ((0, 0, 1, 0, 1e9, hertz(1e3)),), np.zeros((2, n + 1))
    rest = *start_at, None, None, record, False
    return lambda: _core.newmark(scene, contacts, 1e-3, 0.25, 0.5, *rest)


LONG = [law, to_modal, from_modal]
LONG += [sample, sample_evenly, states, forces, touch, briefs, masses]


def seconds_deaf(call: Call, after: float) -> float:
    """For how long after that time it goes on; NaN where it was over before.

    In seconds of the processor, so that it does not matter what else the machine does.
    """
    before = signal.signal(signal.SIGPROF, signal.default_int_handler)
    start = time.process_time()
    try:
        with suppress(KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_PROF, after)
            call()
            return np.nan
        return time.process_time() - start - after
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


@pytest.mark.parametrize("make", LONG, ids=lambda make: make.__name__)
def test_no_call_is_deaf(make: Callable[[], Call]) -> None:
    call = make()
    for after in (0.01, 0.1):
        # What is deaf is so each time; a page that the machine has to find first is not.
        tries = (seconds_deaf(call, after) for _ in range(3))
        assert any(seconds < 0.1 for seconds in tries)
