"""Sweeps on clusters: dask's and MPI's executors return the bits of a single thread.

They run where the packages are installed; .ci/full sets AOIMPACT_CLUSTERS, and then they must be.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from impacts import beam_star, pair

import aoimpact as ao

pytestmark = pytest.mark.slow

NAMES = ("peak_force", "contact_duration", "impulse", "rebound_velocity")


def needs(module: str, command: str = "") -> None:
    """Skip the test without a package, but where its absence is an error."""
    there = find_spec(module) is not None and (not command or shutil.which(command))
    if not there and not os.environ.get("AOIMPACT_CLUSTERS"):
        pytest.skip(f"{module} {command} is not installed")
    assert there, f"AOIMPACT_CLUSTERS is set, but {module} {command} is not installed"


def cases() -> list[dict[str, Any]]:
    beam = {"projectile": ao.rigid(mass=0.03), "target": beam_star(8), "duration": 1e-3}
    speeds = np.linspace(0.5, 2.0, 40)
    return [
        *(pair() | {"velocity": v} for v in speeds),
        *(pair() | beam | {"velocity": v, "solver": ao.Newmark(dt=1e-6)} for v in speeds[:5]),
        pair() | {"velocity": 0.0},
    ]


def plain(kept: list[Any]) -> Any:
    """Numbers by all their bits, exceptions by their text; as JSON gives them back."""
    return json.loads(
        json.dumps(
            [
                f"{type(item).__name__}: {item}"
                if isinstance(item, Exception)
                else {name: value.hex() for name, value in item.items()}
                for item in kept
            ]
        )
    )


def test_a_dask_cluster(tmp_path: Path) -> None:
    needs("distributed")
    from distributed import Client, LocalCluster

    alone = plain(ao.simulate_many(cases(), keep=NAMES))
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        path = tmp_path / "sweep"
        assert plain(ao.simulate_many(cases(), client, keep=NAMES, checkpoint=path)) == alone
        assert plain(ao.simulate_many(cases(), client, keep=NAMES)) == alone
        (whole,) = ao.simulate_many(cases()[:1], client)
        assert np.array_equal(whole.force, ao.simulate(**cases()[0]).force)
    assert plain(ao.simulate_many(cases(), keep=NAMES, checkpoint=path)) == alone


MPI = """
import json
import sys
from mpi4py.futures import MPIPoolExecutor
import aoimpact as ao
from test_clusters import NAMES, cases, plain

if __name__ == "__main__":
    with MPIPoolExecutor() as executor:
        assert executor.num_workers == 1, executor.num_workers
        kept = ao.simulate_many(cases(), executor, keep=NAMES)
    with open(sys.argv[1], "w") as file:
        json.dump(plain(kept), file)
"""


def test_two_ranks_of_mpi(tmp_path: Path) -> None:
    """Rank 0 hands out the cases, rank 1 computes them."""
    needs("mpi4py", "mpiexec")
    script, out = tmp_path / "sweep.py", tmp_path / "kept.json"
    script.write_text(MPI)
    here = Path(__file__).parent
    folders = Path(str(ao.__file__)).parent.parent, here, here.parents[1] / "benchmarks"
    # mpi4py puts the script's folder in place of the first one, which must be the current one.
    env = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"} | {
        "PYTHONPATH": os.pathsep.join(map(str, folders)),
        # Open MPI asks for these in containers; others do not look at them.
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    }
    program = [sys.executable, "-m", "mpi4py.futures", str(script), str(out)]
    done = subprocess.run(
        ["mpiexec", "-n", "2", *program],
        cwd=tmp_path,
        env=env,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(out.read_text()) == plain(ao.simulate_many(cases(), keep=NAMES))
