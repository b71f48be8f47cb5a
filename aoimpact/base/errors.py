"""The package's exceptions and its one warning.

Each exception also derives from the built-in one that a caller expects, so that ``except
ValueError`` works for callers who do not know `AOImpactError`.
"""

from __future__ import annotations

import importlib
import math
import reprlib
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any


class AOImpactError(Exception):
    """Base class of all errors that this package raises on purpose."""


class InputError(AOImpactError, ValueError):
    """An argument has a value that cannot be used."""


class InputTypeError(AOImpactError, TypeError):
    """An argument is of a type that cannot be used."""


class MemoryLimitError(AOImpactError, MemoryError):
    """A computation would need more memory than there is."""


class MeshError(InputError):
    """A mesh cannot be read, or is not fit for computation."""


class LawLimitError(InputError):
    """An indentation is beyond the range of the contact law, set by its patch or its table.

    Attributes
    ----------
    contact : int or None
        Number of the contact in the scene; None if the error is not from a run.
    """

    def __init__(self, message: str, contact: int | None = None) -> None:
        super().__init__(message)
        self.contact = contact

    def __str__(self) -> str:
        message = super().__str__()
        return message if self.contact is None else f"contact {self.contact}: {message}"


class RoomError(InputError):
    """A patch does not fit on a body.

    Attributes
    ----------
    room : float
        Approximate radius of the largest patch that fits, m.
    reason : str
        Limit of the radius, and its place.
    cure : str
        Advice for a place where no patch fits.
    """

    def __init__(
        self,
        message: str,
        room: float,
        reason: str,
        cure: str = "choose a point farther from there, refine the mesh about it, or take "
        "radius=0, a single node",
    ) -> None:
        super().__init__(message)
        self.room, self.reason, self.cure = room, reason, cure


class MissingFileError(MeshError, FileNotFoundError):
    """A mesh or matrix file does not exist."""


class SceneFileError(InputError):
    """A scene file is wrong; the message gives the line of each problem."""


class SingularError(AOImpactError, RuntimeError):
    """A matrix that has to be inverted is singular: a mechanism, or a body without supports."""


class ConvergenceError(AOImpactError, RuntimeError):
    """An iteration did not reach its tolerance."""


class NotFiniteError(ConvergenceError):
    """Infinity or NaN occurred in a run."""


class IterationError(ConvergenceError):
    """An iteration did not converge, for example because a step is far too long."""


class WorkerError(AOImpactError, RuntimeError):
    """A worker of a sweep was lost, or cases could not be sent to it."""


class MissingPackageError(AOImpactError, ImportError):
    """An optional package that a function needs is not installed."""


class AOImpactWarning(UserWarning):
    """Warning of input or results that are probably a mistake, but may be intended."""


def optional_package(name: str, what: str, otherwise: str = "") -> Any:
    """Import a package that `what` needs.

    Parameters
    ----------
    name : str
        Name of the module, which is also that of the package for pip and of aoimpact's extra.
    what : str
        The function that needs it, such as "to_dataframe".
    otherwise : str, optional
        The alternative, such as "take .to_csv(path)".

    Raises
    ------
    MissingPackageError
        If the package is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        more = f", or {otherwise}" if otherwise else ""
        raise MissingPackageError(
            f"{what} needs {name}, which is not installed: pip install {name}{more}"
        ) from None


# Modules whose stack frames `warn` skips: this package, and libraries through which it is called,
# such as functools.cached_property.
_PASSED = {__name__.partition(".")[0], "numpy", "scipy", *sys.stdlib_module_names} - {"__main__"}

_held: ContextVar[list[str] | None] = ContextVar("aoimpact_held_warnings", default=None)


@contextmanager
def held_warnings() -> Iterator[list[str]]:
    """Collect this thread's warnings in the yielded list instead of issuing them."""
    messages: list[str] = []
    token = _held.set(messages)
    try:
        yield messages
    finally:
        _held.reset(token)


def warn(message: str) -> None:
    """Issue an `AOImpactWarning` that shows the line of the user's code that caused it."""
    held = _held.get()
    if held is not None:
        held.append(message)
        return
    level = 2
    frame = sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] in _PASSED:
        frame = frame.f_back
        level += 1
    warnings.warn(message, AOImpactWarning, stacklevel=level)


# Exception class and message for each status of the C core (enum aoi_status).
_CORE: dict[int, tuple[type[AOImpactError], str]] = {
    1: (InputError, "an argument is out of its range"),
    2: (
        NotFiniteError,
        "infinity or NaN came up: values lie too far apart, or fixed steps gain energy at every "
        "touch; take Adaptive(), far smaller steps, or a softer law",
    ),
    3: (SingularError, "a mass, stiffness or pivot that must be positive is not"),
    4: (IterationError, "an iteration did not converge"),
    5: (ConvergenceError, "the linear solver failed"),
    6: (
        ConvergenceError,
        "even the shortest step does not meet the tolerance; take another rtol, a smoother law, a "
        "small m0 where it is 0, or Newmark(dt=...)",
    ),
    7: (
        ConvergenceError,
        "the run takes too many steps; take a shorter duration, a larger rtol, fewer stiff "
        "oscillators, a smoother law, or Newmark(dt=...)",
    ),
    8: (
        LawLimitError,
        "the indentation is beyond the range of the contact law; with a patch, take a larger "
        "radius, with a table, give deeper values",
    ),
    9: (ConvergenceError, "the contact law gave no finite number"),
    10: (
        ConvergenceError,
        "no force satisfies the contact law less its patches' compliance: the law jumps down; make "
        "it continuous, or the contact points without a radius",
    ),
    11: (ConvergenceError, "it was stopped"),
    12: (
        InputError,
        "friction needs a contact law without memory and adhesion, and with damping fixed steps: "
        "give law=ao.Hertz(...), or solver=Newmark(dt=...)",
    ),
    13: (
        ConvergenceError,
        "the slip of a contact with friction reverses so often that its history exceeds the memory "
        "reserved for it; take a larger dt, with which the history is coarser",
    ),
}


def core_error(
    code: int,
    what: str,
    time: float,
    indentation: float = math.nan,
    rate: float = math.nan,
    contact: int = -1,
) -> AOImpactError:
    """Return the exception for a status of the C core (``aoi_status``).

    Parameters
    ----------
    code : int
        The status, not 0.
    what : str
        The operation of the core.
    time : float
        Simulated time of the failed step, s; negative if the operation has no time.
    indentation, rate : float, optional
        Indentation, m, and rate, m/s, at which a contact law gave no force; NaN: not known.
    contact : int, optional
        Number of the contact whose indentation is beyond its law's range; negative: not known.
    """
    kind, text = _CORE.get(code, (AOImpactError, f"unknown status {code} of the core"))
    when = f" at t = {time:.6g} s" if time >= 0.0 else ""
    if not math.isnan(indentation):
        text += f", at indentation = {indentation:.6g} m and rate = {rate:.6g} m/s"
    error = kind(f"{what}{when}: {text}")
    if isinstance(error, LawLimitError) and contact >= 0:
        error.contact = contact
    return error


def law_result_error(returned: object, indentation: float, rate: float) -> InputTypeError:
    """Return the exception for a user's law in Python that does not return a number."""
    return InputTypeError(
        f"the contact law must return a real number, but returned {reprlib.repr(returned)} of type "
        f"{type(returned).__name__} at indentation = {indentation:.6g} m and rate = {rate:.6g} m/s"
    )
