"""A little of the campaign of malformed inputs, by fixed seeds."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import aoimpact as ao

TOOLS = Path(__file__).parents[2] / "tools"
PACKAGE = Path(str(ao.__file__)).parents[1]

LONG = (("mesh", 200), ("matrix", 600), ("matrixfile", 600), ("scenefile", 300))

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits a process's memory")


@pytest.mark.parametrize(
    ("kind", "count"),
    [("mesh", 2), *(pytest.param(*case, marks=pytest.mark.slow) for case in LONG)],
)
def test_malformed_inputs_are_refused_by_name(kind: str, count: int) -> None:
    command = [sys.executable, "-m", "campaign", kind, "--count", str(count)]
    done = subprocess.run(
        [*command, "--seed", "20261122"],
        cwd=TOOLS,
        env=os.environ
        | {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": f"{TOOLS}{os.pathsep}{PACKAGE}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{kind}: {count} of seed 20261122" in done.stdout


SOUND = """
import tempfile, warnings
from pathlib import Path
from campaign import scenefiles
warnings.simplefilter("ignore")
with tempfile.TemporaryDirectory() as place:
    folder = Path(place)
    for data in scenefiles.seeds(folder):
        scenefiles.written(scenefiles.text_of(data).encode(), folder).run()
"""


@pytest.mark.slow
def test_scene_files_are_sound_before_they_are_damaged() -> None:
    """What is refused undamaged hides all that comes after."""
    done = subprocess.run(
        [sys.executable, "-c", SOUND],
        cwd=TOOLS,
        env=os.environ | {"PYTHONPATH": f"{TOOLS}{os.pathsep}{PACKAGE}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
