"""A run whose steps do not fit into memory says so."""

import subprocess
import sys

import pytest

resource = pytest.importorskip("resource")  # of Unix

ENDLESS = """
import re, resource
import aoimpact as ao
from aoimpact.base import MemoryLimitError

scene = ao.Scene(gravity=9.81)
ball = scene.add(ao.rigid(mass=0.03))
star = scene.add(ao.AOModel(m0=0.045, k0=26880.0, m=[0.25], k=[6e6]))
scene.connect(ball, star, ao.Hertz(1e9))
scene.simulate(duration=1e-3, solver=ao.Adaptive(rtol=1e-6))
used = int(re.search(r"VmSize:\\s+(\\d+)", open("/proc/self/status").read())[1]) << 10
resource.setrlimit(resource.RLIMIT_AS, (used + (64 << 20), -1))
try:
    scene.simulate(duration=1e5, solver=ao.Adaptive(rtol=1e-6))
except MemoryLimitError as error:
    print(error)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_a_record_that_does_not_fit_into_memory_is_named() -> None:
    child = subprocess.run([sys.executable, "-c", ENDLESS], capture_output=True, text=True)
    assert child.returncode == 0, child.stderr
    assert child.stdout.startswith("the steps of a run of 100000 s to rtol=1e-06 do not fit into")
