"""Setup of all tests: the package under test, no display, warnings as errors."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent

# If aoimpact/ has no compiled core, as in a clone without a build in place, the tests and the
# interpreters that they start use the installed package.
if not any((ROOT / "aoimpact").glob("_core.*[od]")):  # .so, .pyd
    sys.path[:] = [entry for entry in sys.path if Path(entry or ".").resolve() != ROOT]
    os.environ["PYTHONSAFEPATH"] = "1"

os.environ.setdefault("MPLBACKEND", "Agg")

# Tests run in parallel; threads of linear algebra that compete for cores took six times as long.
# The limit must be set before NumPy is loaded.
for library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# No deadline, as machines may be busy; no random seeds, so that failures are reproducible.
settings.register_profile("aoimpact", deadline=None, derandomize=True)
settings.load_profile("aoimpact")


class Own:
    """A user's linear solver.

    `calls` lists the sizes of the factorised matrices; `solutions` counts the right-hand sides.
    """

    def __init__(self) -> None:
        self.calls: list[int] = []
        self.solutions = 0

    def __call__(self, matrix: Any) -> Callable[..., Any]:
        from scipy.sparse.linalg import factorized

        self.calls.append(matrix.shape[0])
        solve = factorized(matrix)

        def counted(rhs: Any) -> Any:
            self.solutions += 1
            return solve(rhs)

        return counted


@pytest.fixture
def own_solver() -> Own:
    return Own()


def pytest_configure(config: pytest.Config) -> None:
    # Not in pyproject.toml, since pytest would then import the package before the lines above.
    config.addinivalue_line("filterwarnings", "error::aoimpact.AOImpactWarning")
    # The paper uses contacts at single nodes, which are also fastest for comparing methods.
    config.addinivalue_line(
        "filterwarnings", "ignore:.*touched at a single:aoimpact.AOImpactWarning"
    )
