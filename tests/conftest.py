"""What every test relies on: the right package, no display, warnings that count."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent

# In a clone the folder aoimpact/ has no compiled core unless it was built in place. Then it is the
# installed package that is tested, here and in the interpreters that tests start.
if not any((ROOT / "aoimpact").glob("_core.*[od]")):  # .so, .pyd
    sys.path[:] = [entry for entry in sys.path if Path(entry or ".").resolve() != ROOT]
    os.environ["PYTHONSAFEPATH"] = "1"

os.environ.setdefault("MPLBACKEND", "Agg")

# Tests run side by side: threads of linear algebra that share their cores with others wait for each
# other, and took six times as long. Set before NumPy is loaded.
for library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# A busy machine is no failure, and a test fails for everyone or for no one.
settings.register_profile("aoimpact", deadline=None, derandomize=True)
settings.load_profile("aoimpact")


class Own:
    """A linear solver of a user's.

    `calls` has the sizes of what it factorised, `solutions` counts what it solved for.
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
    # Here and not in pyproject.toml, where pytest would import the package before the lines above.
    config.addinivalue_line("filterwarnings", "error::aoimpact.AOImpactWarning")
    # Single nodes are what the paper takes, and what is quickest to compare methods by.
    config.addinivalue_line(
        "filterwarnings", "ignore:.*touched at a single:aoimpact.AOImpactWarning"
    )
