"""Contact laws given by the caller: as measured points, or as functions."""

from __future__ import annotations

import ctypes
import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy
from scipy import LowLevelCallable

from ..base import FloatArray, InputError, InputTypeError, boolean, finite_array
from .law import ContactLaw, CoreLaw


@dataclass(frozen=True, repr=False)
class Tabulated(ContactLaw, kind="table"):
    """A law through points, by monotone cubic interpolation (PCHIP).

    F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17 (1980) 238-246, with the slopes of
    F. N. Fritsch, J. Butland (SciPy's PCHIP). An impact deeper than the last point raises an error.

    Parameters
    ----------
    indentation : array_like, shape (n,)
        Indentations, m, increasing, not negative; (0, 0) is prepended if the table begins later.
    force : array_like, shape (n,)
        Forces, N, never falling, positive from the first indentation above 0 on.

    Attributes
    ----------
    indentation, force_values : tuple of float
        Points of the table, m and N.

    Examples
    --------
    >>> law = ao.Tabulated(indentation=[0.0, 1e-4, 2e-4], force=[0.0, 100.0, 300.0])
    >>> round(float(law.force(1.5e-4)), 6)
    185.416667
    """

    indentation: tuple[float, ...]
    force_values: tuple[float, ...]

    def __init__(self, indentation: npt.ArrayLike, force: npt.ArrayLike) -> None:
        depth = finite_array("indentation", indentation, shape=(None,), unit="m")
        push = finite_array("force", force, shape=(len(depth),), unit="N")
        if len(depth) == 0 or (len(depth) == 1 and depth[0] == 0.0):
            raise InputError("indentation and force must have a point besides (0, 0)")
        if depth[0] != 0.0:
            depth, push = np.insert(depth, 0, 0.0), np.insert(push, 0, 0.0)
        for name, unit, values in (("indentation", "m", depth), ("force", "N", push)):
            steps, least = np.diff(values), math.ulp(0.0) if values is depth else 0.0
            if (steps < least).any():
                i = int(np.argmax(steps < least))
                raise InputError(
                    f"{name} must {'increase' if least else 'never fall'} from point to point: "
                    f"after {values[i]:g} {unit} comes {values[i + 1]:g} {unit}"
                )
        if push[0] != 0.0 or push[1] == 0.0:
            raise InputError(
                f"force must be 0 N at indentation 0 and positive at {depth[1]:g} m, got "
                f"{push[0]:g} N and {push[1]:g} N; put what comes before the force into the gap"
            )
        object.__setattr__(self, "indentation", tuple(depth.tolist()))
        object.__setattr__(self, "force_values", tuple(push.tolist()))
        if not np.isfinite(self._table).all():
            raise InputError(
                f"indentation up to {depth[-1]:g} m and force up to {push[-1]:g} N have slopes or "
                "energies that are no numbers; leave points out that are far from any motion"
            )

    def __repr__(self) -> str:
        return (
            f"Tabulated({len(self.indentation)} points up to {self.indentation[-1]:g} m, "
            f"{self.force_values[-1]:g} N)"
        )

    @property
    def limit(self) -> float:
        return self.indentation[-1]

    def for_core(self) -> CoreLaw:
        return super().for_core()._replace(limit=self.limit, data=self._table)

    @functools.cached_property
    def _table(self) -> FloatArray:
        """The core's table, shape (4, n): indentations, forces, slopes, energies."""
        depth, push = np.array(self.indentation), np.array(self.force_values)
        with np.errstate(all="ignore"):  # extreme slopes overflow, and are refused below
            try:
                through = scipy.interpolate.PchipInterpolator(depth, push)
            except ValueError:  # slopes overflow
                return np.full((4, len(depth)), np.nan)
            slope, energy = through.derivative()(depth), through.antiderivative()(depth)
        return np.stack([depth, push, np.maximum(slope, 0.0), energy])


# Base class of all ctypes functions.
_CTYPES_FUNCTION: Any = ctypes.CFUNCTYPE(None).__mro__[1]

_SIGNATURE = "double (double, double)"


@dataclass(frozen=True)
class UserLaw(ContactLaw, kind="user", by_caller=True):
    """A law F = f(δ, δ̇) given by functions of the user.

    All functions take indentation, m, which is positive, and rate, m/s, and return a number. The
    functions are either all Python functions, called one state at a time; or all C functions,
    ``double f(double indentation, double rate)``, called at full speed without Python. A C function
    is a ``scipy.LowLevelCallable``. This object is made of a ctypes function with its ``argtypes``
    and ``restype``, of a cffi function pointer, or of ``cfunc.ctypes`` of numba.

    Parameters
    ----------
    function : callable or scipy.LowLevelCallable
        Force, N. The force should be continuous, free of noise above the tolerance of the run, and
        0 at indentation 0 unless a jump is meant. Negative values are cut to 0, unless `pulls`.
    stiffness, damping : callable or scipy.LowLevelCallable, optional
        Derivatives of the force with respect to indentation, N/m, and rate, N s/m. If not given,
        they are computed by differences, to some eight digits.
    energy : callable or scipy.LowLevelCallable, optional
        Elastic energy at an indentation, J, called with rate 0. If not given, it is integrated from
        the force at rate 0 by Gauss's rule of 16 points.
    depends_on_rate : bool, optional
        False promises that the force does not depend on the rate, which saves calls.
    pulls : bool, optional
        True to allow negative forces; the contact then ends where the indentation reaches 0.

    Notes
    -----
    An error raised by a Python function is raised by `simulate` unchanged; a return value that is
    no number, or NaN, raises an error that names it. The run releases the GIL between calls: the
    functions must not change state that other threads use.

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
        """Return Python functions as they are, and C functions as their addresses."""
        found: list[Any] = []
        for name in ("function", "stiffness", "damping", "energy"):
            entry = getattr(self, name)
            if isinstance(entry, LowLevelCallable):
                given = entry.signature
                if given.replace(" ", "") != _SIGNATURE.replace(" ", ""):
                    raise InputTypeError(f"{name} must be a C function {_SIGNATURE}, got {given}")
                of = ctypes.pythonapi.PyCapsule_GetPointer
                of.argtypes, of.restype = [ctypes.py_object, ctypes.c_char_p], ctypes.c_void_p
                entry = int(of(tuple.__getitem__(entry, 0), given.encode()))
            elif entry is not None and (isinstance(entry, _CTYPES_FUNCTION) or not callable(entry)):
                raise InputTypeError(
                    f"{name} must be a Python function, or a C function {_SIGNATURE} in a "
                    f"scipy.LowLevelCallable, got {entry!r}"
                )
            found.append(entry)
        return tuple(found)

    def for_core(self) -> CoreLaw:
        # The functions are passed too, which keeps them alive during the call.
        functions = (self.function, self.stiffness, self.damping, self.energy)
        data = self._entries(), self.depends_on_rate, self.pulls, functions
        return super().for_core()._replace(data=data)
