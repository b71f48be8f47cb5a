"""Laws that the user writes: what they may be made of, and what happens when they go wrong."""

import ctypes
import ctypes.util
import math
import shutil
import subprocess
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from every_law import damped_hertz
from scipy import LowLevelCallable

import aoimpact as ao

K, CHI = 1e10, 0.5
BUILT_IN = ao.HuntCrossley(K, CHI)
SOURCE = """
#include <math.h>
double force(double d, double v) { return 1e10 * d * sqrt(d) * (1.0 + 0.5 * v); }
double stiffness(double d, double v) { return 1.5e10 * sqrt(d) * (1.0 + 0.5 * v); }
double damping(double d, double v) { return 0.5e10 * d * sqrt(d) + 0.0 * v; }
double energy(double d, double v) { return 0.4e10 * d * d * sqrt(d) + 0.0 * v; }
double broken(double d, double v) { return d > 1e-6 ? NAN : d + 0.0 * v; }
"""
ONE_OF_ONE = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)
DOUBLE_OF_TWO = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.c_double)


def hit(law, solver=None, **changes):
    scene = {
        "projectile": ao.rigid(mass=0.016),
        "target": ao.AOModel(m0=1.0, k0=1e6, m=[0.2], k=[1e8]),
        "velocity": 1.0,
        "duration": 1e-4,
        "solver": solver or ao.Newmark(dt=2e-7),
    }
    return ao.simulate(law=law, **scene | changes)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The law as C functions of a shared library."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None or sys.platform == "win32":
        pytest.skip("no C compiler at hand")
    folder = tmp_path_factory.mktemp("law")
    (folder / "law.c").write_text(SOURCE)
    command = [compiler, "-O2", "-shared", "-fPIC", "law.c", "-o", "law.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    loaded, made = ctypes.CDLL(str(folder / "law.so")), SimpleNamespace()
    for name in ("force", "stiffness", "damping", "energy", "broken"):
        getattr(loaded, name).argtypes = [ctypes.c_double] * 2
        getattr(loaded, name).restype = ctypes.c_double
        setattr(made, name, LowLevelCallable(getattr(loaded, name)))
    return made


OWN = {
    "stiffness": lambda d, v: 1.5 * K * math.sqrt(d) * (1 + CHI * v),
    "damping": lambda d, v: CHI * K * d**1.5,
    "energy": lambda d, v: 0.4 * K * d**2.5,
}


@pytest.mark.parametrize("own", [(), tuple(OWN)])
@pytest.mark.parametrize("language", ["Python", "C"])
def test_a_function_of_ones_own_is_the_law_that_it_computes(library, language, own):
    functions = {"force": damped_hertz} | OWN if language == "Python" else vars(library)
    law = ao.UserLaw(functions["force"], **{name: functions[name] for name in own})
    depth = np.geomspace(1e-9, 1e-4, 30)
    for rate in (-1.0, 0.0, 2.0):
        np.testing.assert_allclose(law.force(depth, rate), BUILT_IN.force(depth, rate), rtol=1e-14)
    np.testing.assert_allclose(law.potential(depth), BUILT_IN.potential(depth), rtol=1e-13)
    run, reference = hit(law), hit(BUILT_IN)
    np.testing.assert_allclose(run.force, reference.force, rtol=1e-9, atol=1e-6)
    assert run.restitution == pytest.approx(reference.restitution, rel=1e-9)


@pytest.mark.parametrize(
    ("function", "own", "named"),
    [
        (LowLevelCallable(ONE_OF_ONE(math.sqrt)), {}, r"^function"),
        (ctypes.CFUNCTYPE(ctypes.c_int)(int), {}, r"^function"),
        (damped_hertz, {"stiffness": LowLevelCallable(DOUBLE_OF_TWO(damped_hertz))}, "stiffness"),
    ],
)
def test_functions_of_another_signature_are_refused(function, own, named):
    with pytest.raises(ao.AOImpactError, match=named):
        ao.UserLaw(function, **own)


def test_a_law_that_would_pull_is_cut_unless_it_means_to():
    assert ao.UserLaw(lambda d, v: -1.0).force(1e-6) == 0.0
    assert ao.UserLaw(lambda d, v: -1.0, pulls=True).force(1e-6) == -1.0
    assert ao.UserLaw(lambda d, v: -1.0, pulls=True).force(-1e-6) == 0.0


class OwnError(Exception):
    """A user's own exception."""


@pytest.mark.parametrize("solver", [ao.Newmark(dt=2e-7), ao.Adaptive(rtol=1e-8)])
def test_what_a_law_raises_arrives_unchanged(solver):
    fault = OwnError("beyond 10 um")

    def law(d, v):
        if d > 1e-5:
            raise fault
        return K * d**1.5

    with pytest.raises(OwnError) as caught:
        hit(ao.UserLaw(law, depends_on_rate=False), solver)
    assert caught.value is fault


@pytest.mark.parametrize(
    "answer",
    [
        *(None, "12", np.ones(1), np.ones(2), np.array(1.0), [1.0], 1j, {}, b"1"),
        *(10**400, np.datetime64("2020")),
    ],
)
def test_what_is_no_number_is_named_with_its_state(answer):
    with pytest.raises(ao.InputTypeError, match="indentation"):
        hit(ao.UserLaw(lambda d, v: answer))


def broken(d, v):
    return K * d**1.5 if d < 1e-5 else math.nan


def falling(d, v):
    return 1e7 * d * (1.0 if d < 1e-5 else 0.2)


@pytest.mark.parametrize("solver", [ao.Newmark(dt=2e-7), ao.Adaptive(rtol=1e-8)])
def test_nan_stops_with_the_state_that_gave_it(library, solver):
    """A law that falls has none within a patch."""
    law = ao.UserLaw(broken, depends_on_rate=False)
    soft = ao.UserLaw(falling, depends_on_rate=False).within_patch(3e-8)
    for wrong in (law, soft, ao.UserLaw(library.broken)):
        with pytest.raises(ao.ConvergenceError, match="indentation"):
            hit(wrong, solver)
    for wrong, depth in ((law, 0.002), (soft, 8e-6)):
        with pytest.raises(ao.ConvergenceError, match=r"^contact"):
            wrong.force(depth, -3.0)


@pytest.mark.parametrize("more", [{}, {"friction": 0.1}])
@pytest.mark.parametrize("duration", [None, 1e-3])
def test_nan_is_told_before_the_length_of_the_record_is_missed(more, duration):
    law = ao.UserLaw(lambda d, v: math.nan, depends_on_rate=False)
    ball, wall = ao.rigid(0.1, inertia=1e-5, arm=(0, 0, -0.01)), ao.rigid(math.inf)
    velocity = (0.1, 0.0, -1.0) if more else 1.0
    with pytest.raises(ao.ConvergenceError, match=r"gave no (finite )?number"):
        ao.simulate(ball, wall, velocity, law=law, duration=duration, **more)


def test_python_laws_run_in_many_threads():
    law = ao.UserLaw(damped_hertz)
    expected = hit(law).peak_force
    found, faults = [], []

    def work(number):
        try:
            if number % 2:
                hit(ao.UserLaw(lambda d, v: 1 / 0))
            found.append(hit(law).peak_force)
        except ZeroDivisionError as error:
            faults.append(error)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected] * 4
    assert len(faults) == 4


def test_the_restitution_of_a_law_without_loss_is_1_and_of_one_that_gives_energy_none():
    for power in np.linspace(1.0, 4.0, 13):
        law = ao.UserLaw(lambda d, rate, n=power: 1e10 * d**n)
        assert ao.restitution(law, 0.016, 1.0) == pytest.approx(1.0, abs=1e-9)
    gives = ao.UserLaw(lambda d, rate: 1e10 * d**1.5 * (1.0 - 0.2 * rate))
    with pytest.raises(ao.InputError, match=r"^law"):
        ao.restitution(gives, 0.016, 1.0)


@pytest.mark.parametrize("solver", [None, ao.Newmark(dt=1e-6)])
def test_a_force_that_is_infinite_or_always_negative(solver):
    ball = ao.rigid(mass=1.0)
    strike = {
        "projectile": ball,
        "target": ball,
        "velocity": 1.0,
        "duration": 1e-3,
        "solver": solver,
    }
    with pytest.raises(ao.ConvergenceError):
        ao.simulate(**strike, law=ao.UserLaw(lambda d, v: math.inf))
    law = ao.UserLaw(lambda d, v: -1e9 * d)  # cut to 0: the bodies pass through each other
    hit = ao.simulate(**strike, law=law)
    assert hit.peak_force == hit.impulse == law.force(1e-3) == 0.0
    assert hit.projectile.velocity[-1] == 1.0
    assert hit.target.velocity[-1] == 0.0
    assert math.isnan(hit.rebound_velocity)
    assert math.isnan(hit.restitution)
