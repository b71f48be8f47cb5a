"""Contact laws that the user writes: as Python functions, or as C functions at full speed."""

from __future__ import annotations

import ctypes
import importlib
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

from ..base import InputError, InputTypeError, boolean
from .law import ContactLaw

# The class of all functions of C libraries.
_CTYPES_FUNCTION: Any = ctypes.CFUNCTYPE(None).__mro__[1]

# No function lies below, on any system that a process can run on (Linux: vm.mmap_min_addr): such a
# number is a stiffness that was meant for another law.
_LOWEST = 65_536

_SIGNATURE = "double f(double indentation, double rate)"


@dataclass(frozen=True)
class UserLaw(ContactLaw):
    """A law of the user's own, F = f(δ, δ̇).

    All functions take indentation, m, which is positive, and rate, m/s, and return a number. They
    are either all Python functions, called one state at a time; or all C functions,
    ``double f(double indentation, double rate)``, called at full speed without Python: a ctypes
    function with its ``argtypes`` and ``restype``, a cffi function pointer, a numba ``cfunc``, or
    the address as an int. The law holds on to the object; an address must stay valid.

    Parameters
    ----------
    function : callable, C function or int
        Force, N. It should be continuous, smoother than the tolerance of the run, and 0 at
        indentation 0 unless a jump is meant. Where it is negative it is cut to 0, unless `pulls`.
    stiffness, damping : callable, C function or int, optional
        Its derivatives, N/m and N s/m; by differences if not given, to some eight digits.
    energy : callable, C function or int, optional
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
    _name = "user"
    _by_caller = True

    def __post_init__(self) -> None:
        boolean("depends_on_rate", self.depends_on_rate)
        boolean("pulls", self.pulls)
        if self.function is None:
            raise InputTypeError("function must be a Python or C function, got None")
        if len({type(entry) is int for entry in self._entries() if entry is not None}) > 1:
            raise InputTypeError(
                "function, stiffness, damping and energy must be all Python functions or all C ones"
            )

    def __getstate__(self) -> dict[str, Any]:
        state = {field.name: getattr(self, field.name) for field in fields(self)}
        if any(type(value) is int for value in state.values()):
            raise TypeError("a UserLaw by an address cannot be pickled: it is of this process only")
        return state

    def _entries(self) -> tuple[Any, ...]:
        names = ("function", "stiffness", "damping", "energy")
        return tuple(_entry(name, getattr(self, name)) for name in names)

    def _parameters(self) -> tuple[float, ...]:
        return ()

    def _data(self) -> Any:
        # The objects themselves go along: they must outlive the call.
        functions = (self.function, self.stiffness, self.damping, self.energy)
        return self._entries(), self.depends_on_rate, self.pulls, functions


def _entry(name: str, function: Any) -> Callable[..., Any] | int | None:
    """Return a Python function as it is, and a C function as its address."""
    if function is None:
        return None
    address = _address(name, function)
    if address == 0:
        raise InputError(f"{name} must not be a null pointer")
    if address is not None:
        return address
    if not callable(function):
        raise InputTypeError(
            f"{name} must be a Python function or a C function, {_SIGNATURE} (ctypes, cffi, numba "
            f"cfunc, or its address), got {function!r}"
        )
    python: Callable[..., Any] = function
    return python


def _address(name: str, function: Any) -> int | None:
    """Return the address of a C function of the right signature, None for anything else."""
    if isinstance(function, bool):
        return None
    if isinstance(function, int):
        if function and not _LOWEST <= function < 1 << 8 * ctypes.sizeof(ctypes.c_void_p):
            raise InputError(f"{name} must be a function or its address, got {function}")
        return function
    if isinstance(function, _CTYPES_FUNCTION):
        if list(function.argtypes or ()) != [ctypes.c_double] * 2 or (
            function.restype is not ctypes.c_double
        ):
            raise InputTypeError(
                f"{name} is a ctypes function that is not declared as {_SIGNATURE}: set its "
                "argtypes = [c_double, c_double] and restype = c_double"
            )
        return ctypes.cast(function, ctypes.c_void_p).value or 0
    if type(function).__module__ == "_cffi_backend":
        return _cffi_address(name, function)
    address = getattr(function, "address", None)  # numba's cfunc
    if isinstance(address, int) and hasattr(function, "native_name"):
        return address
    return None


def _cffi_address(name: str, function: Any) -> int:
    # It is there, since the function comes from it.
    ffi = importlib.import_module("_cffi_backend").FFI()
    kind = ffi.typeof(function)
    double = ffi.typeof("double")
    if kind.kind != "function" or kind.result is not double or kind.args != (double, double):
        raise InputTypeError(f"{name} is a cffi object that is no {_SIGNATURE}, but {kind.cname}")
    return int(ffi.cast("uintptr_t", function))
