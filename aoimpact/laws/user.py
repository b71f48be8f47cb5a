"""Contact laws that the user writes: as Python functions, or as C functions at full speed."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from scipy import LowLevelCallable

from ..base import InputTypeError, boolean
from .law import ContactLaw

# The class of all functions of C libraries.
_CTYPES_FUNCTION: Any = ctypes.CFUNCTYPE(None).__mro__[1]

_SIGNATURE = "double (double, double)"


@dataclass(frozen=True)
class UserLaw(ContactLaw, kind="user", by_caller=True):
    """A law of the user's own, F = f(δ, δ̇).

    All functions take indentation, m, which is positive, and rate, m/s, and return a number. They
    are either all Python functions, called one state at a time; or all C functions,
    ``double f(double indentation, double rate)``, called at full speed without Python. A C function
    is a ``scipy.LowLevelCallable``. It is made of a ctypes function with its ``argtypes`` and
    ``restype``, of a cffi function pointer, or of ``cfunc.ctypes`` of numba.

    Parameters
    ----------
    function : callable or scipy.LowLevelCallable
        Force, N. It should be continuous, smoother than the tolerance of the run, and 0 at
        indentation 0 unless a jump is meant. Where it is negative it is cut to 0, unless `pulls`.
    stiffness, damping : callable or scipy.LowLevelCallable, optional
        Its derivatives, N/m and N s/m; by differences if not given, to some eight digits.
    energy : callable or scipy.LowLevelCallable, optional
        Elastic energy at an indentation (called with rate 0), J; by Gauss's rule of 16 points over
        the force at no rate if not given.
    depends_on_rate : bool, optional
        False promises that the rate plays no part, and spares work.
    pulls : bool, optional
        Whether negative forces are meant; the contact then ends where the indentation does.

    Notes
    -----
    An error raised by a Python function is raised by `simulate` unchanged; a value that is no
    number, or NaN, raises an error that names it. The run releases the GIL between calls: laws must
    not share state that they change with other threads.

    Examples
    --------
    >>> law = ao.UserLaw(lambda depth, rate: 1e9 * depth**1.5)
    >>> round(float(law.force(1e-4)), 1) == round(float(ao.Hertz(k=1e9).force(1e-4)), 1)
    True
    """

    function: Any
    stiffness: Any = None
    damping: Any = None
    energy: Any = None
    depends_on_rate: bool = True
    pulls: bool = False

    def __post_init__(self) -> None:
        boolean("depends_on_rate", self.depends_on_rate)
        boolean("pulls", self.pulls)
        if self.function is None:
            raise InputTypeError("function must be a Python or C function, got None")
        if len({type(entry) is int for entry in self._entries() if entry is not None}) > 1:
            raise InputTypeError(
                "function, stiffness, damping and energy must be all Python functions or all C ones"
            )

    def _entries(self) -> tuple[Any, ...]:
        names = ("function", "stiffness", "damping", "energy")
        return tuple(_entry(name, getattr(self, name)) for name in names)

    def _data(self) -> Any:
        # The objects themselves go along: they must outlive the call.
        functions = (self.function, self.stiffness, self.damping, self.energy)
        return self._entries(), self.depends_on_rate, self.pulls, functions


def _entry(name: str, function: Any) -> Callable[..., Any] | int | None:
    """Return a Python function as it is, and a C function as its address."""
    if function is None:
        return None
    if isinstance(function, LowLevelCallable):
        signature = function.signature
        if signature.replace(" ", "") != _SIGNATURE.replace(" ", ""):
            raise InputTypeError(f"{name} must be a C function {_SIGNATURE}, got {signature}")
        capsule = tuple.__getitem__(function, 0)
        pointer = ctypes.pythonapi.PyCapsule_GetPointer
        pointer.argtypes, pointer.restype = [ctypes.py_object, ctypes.c_char_p], ctypes.c_void_p
        return int(pointer(capsule, signature.encode()))
    if isinstance(function, _CTYPES_FUNCTION) or not callable(function):
        raise InputTypeError(
            f"{name} must be a Python function, or a C function {_SIGNATURE} in a "
            f"scipy.LowLevelCallable, got {function!r}"
        )
    python: Callable[..., Any] = function
    return python
