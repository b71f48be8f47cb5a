"""The package's exceptions and its one warning.

Each exception is also the built-in kind that a caller expects, so that ``except ValueError``
works for whoever has never heard of `AOImpactError`.
"""

from __future__ import annotations

import sys
import warnings

__all__ = [
    "AOImpactError",
    "AOImpactWarning",
    "ConvergenceError",
    "InputError",
    "InputTypeError",
    "MeshError",
    "MissingFileError",
    "SingularError",
    "core_error",
    "warn",
]


class AOImpactError(Exception):
    """Base of every error that this package raises on purpose."""


class InputError(AOImpactError, ValueError):
    """An argument has a value that cannot be used."""


class InputTypeError(AOImpactError, TypeError):
    """An argument is of a type that cannot be used."""


class MeshError(InputError):
    """A mesh cannot be read or cannot be computed with."""


class MissingFileError(MeshError, FileNotFoundError):
    """A mesh file is not there."""


class SingularError(AOImpactError, RuntimeError):
    """A matrix that has to be inverted is singular: a mechanism, or a body that is not held."""


class ConvergenceError(AOImpactError, RuntimeError):
    """An iteration did not reach its tolerance."""


class AOImpactWarning(UserWarning):
    """Something looks wrong, but may be meant."""


def warn(message: str) -> None:
    """Issue an `AOImpactWarning` that points at the line outside this package that led to it."""
    package = __name__.partition(".")[0]
    level = 2
    frame = sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == package:
        frame = frame.f_back
        level += 1
    warnings.warn(message, AOImpactWarning, stacklevel=level)


# The codes of the C core (enum aoi_status): one table, code -> exception class and what it means.
_CORE: dict[int, tuple[type[AOImpactError], str]] = {
    1: (InputError, "an argument is out of its range"),
    2: (
        ConvergenceError,
        "infinity or NaN came up; the step may be too large or the values too extreme",
    ),
    3: (SingularError, "a mass, stiffness or pivot that must be positive is not"),
    4: (ConvergenceError, "an iteration did not converge"),
    5: (InputError, "the contact functional does not move the body (it is zero on all free dofs)"),
    6: (ConvergenceError, "the linear solver failed"),
    7: (ConvergenceError, "even the shortest step does not meet the tolerance; take a larger rtol"),
    8: (
        ConvergenceError,
        "the run fills a GiB of steps; take a shorter duration, a larger rtol, fewer stiff "
        "oscillators, or Newmark(dt=...)",
    ),
}


def core_error(code: int, what: str, time: float) -> AOImpactError:
    """Return the exception for a status of the C core (``aoi_status``).

    Parameters
    ----------
    code : int
        The status, not 0.
    what : str
        What the core was doing.
    time : float
        Simulated time of the failing step, s; negative where time has no meaning.
    """
    kind, text = _CORE.get(code, (AOImpactError, f"unknown status {code} of the core"))
    when = f" at t = {time:.6g} s" if time >= 0.0 else ""
    return kind(f"{what}{when}: {text}")
