"""Eigenpairs of dense symmetric pencils by LAPACK, during which other threads may run.

`scipy.linalg.eigh` calls the same functions, with the same results bit for bit, but lets no other
thread run meanwhile: for a body of some thousand dofs Ctrl-C would have no effect for minutes.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import scipy

from ..base import FloatArray, SingularError, interruptible

__all__ = ["dense_modes"]

# Up to so many dofs LAPACK takes some hundredths of a second.
_SHORT = 150

# A pivot of M over its diagonal, below which K beside M⁻¹ would lose the digits of low ω².
_LIGHT = 1e-6

# s² beside K, of the mean of K_ii over that of M_ii, where (K + s²M)⁻¹ stands for M⁻¹.
_SHIFT = 1e-4

# Of the largest 1/(ω² + s²): the rounding of one that is zero, a motion without mass.
_NO_MASS = 1e-12


def dense_modes(
    stiffness: FloatArray, mass: FloatArray, n: int | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return ω² and M-orthonormal φ of K φ = ω² M φ: the `n` lowest, or all.

    Motions without mass are no modes, so that there may be fewer.

    Parameters
    ----------
    stiffness, mass : ndarrays, shape (dofs, dofs)
        Symmetric, mass positive semidefinite and K + s²M definite; both may be overwritten.
    n : int, optional

    Raises
    ------
    SingularError
        If mass is not positive semidefinite, or LAPACK does not converge.
    """
    try:
        if _has_light_motions(mass):
            return _of_light_motions(stiffness, mass, n)
        return _solved(stiffness, mass, n)
    except scipy.linalg.LinAlgError as error:
        raise SingularError(
            f"K and M have no modes that can be computed ({error}); give both with all their "
            "digits, hold what is too heavy to move, and condense out what has no mass"
        ) from None


def _has_light_motions(mass: FloatArray) -> bool:
    """Whether some motion has next to no mass, as where elements integrate it at few points."""
    factor, failed = interruptible(lambda: scipy.linalg.lapack.dpotrf(mass, lower=1))
    pivots = np.diagonal(factor) ** 2
    return bool(failed or (pivots < _LIGHT * np.diagonal(mass)).any())


def _of_light_motions(
    stiffness: FloatArray, mass: FloatArray, n: int | None
) -> tuple[FloatArray, FloatArray]:
    """The modes by M φ = θ (K + s²M) φ, θ = 1/(ω² + s²): θ = 0 is a motion without mass."""
    whole = float(np.trace(mass))
    if whole <= 0.0:
        raise scipy.linalg.LinAlgError("mass is not positive semidefinite")
    s2 = _SHIFT * float(np.trace(stiffness)) / whole
    inverse, modes = _solved(-mass, stiffness + s2 * mass, n)
    theta = -inverse
    if theta[-1] < -np.sqrt(_NO_MASS) * theta[0]:
        raise scipy.linalg.LinAlgError("mass is not positive semidefinite")
    heavy = theta > _NO_MASS * theta[0]
    return 1.0 / theta[heavy] - s2, modes[:, heavy] / np.sqrt(theta[heavy])


def _solved(
    stiffness: FloatArray, mass: FloatArray, n: int | None
) -> tuple[FloatArray, FloatArray]:
    if len(mass) <= _SHORT:
        some = None if n is None else [0, n - 1]
        found: tuple[FloatArray, FloatArray] = scipy.linalg.eigh(
            stiffness, mass, subset_by_index=some
        )
        return found
    a, b = (np.asarray_chkfinite(matrix, order="F") for matrix in (stiffness, mass))
    return interruptible(lambda: _all(a, b) if n is None else _lowest(a, b, n))


def _all(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """By divide and conquer; as `dsygvd` of SciPy calls it."""
    n = len(a)
    omega2, work, iwork = np.empty(n), np.empty(1 + 6 * n + 2 * n * n), np.empty(3 + 5 * n, np.intc)
    _call("dsygvd", 1, b"V", b"L", n, a, n, b, n, omega2, work, len(work), iwork, len(iwork))
    return omega2, a


def _lowest(a: FloatArray, b: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """By bisection and inverse iteration; as `dsygvx` of SciPy calls it."""
    n = len(a)
    best, _ = scipy.linalg.lapack.dsygvx_lwork(n, uplo="L")
    work, iwork, failed = np.empty(int(best)), np.empty(5 * n, np.intc), np.empty(n, np.intc)
    omega2, modes, found = np.empty(n), np.empty((n, count), order="F"), np.zeros(1, np.intc)
    reach = 0.0, 0.0, 1, count, 0.0  # by number, as exactly as may be
    sizes = modes, n, work, len(work), iwork, failed
    _call("dsygvx", 1, b"V", b"I", b"L", n, a, n, b, n, *reach, found, omega2, *sizes)
    return omega2[:count], modes


def _call(name: str, *arguments: Any) -> None:
    """Call LAPACK by the address under which SciPy offers it to Cython."""
    info = ctypes.c_int(0)
    function = ctypes.CFUNCTYPE(None)(_address(name))
    function(*[_pointer(value) for value in arguments], ctypes.byref(info))
    if info.value:
        raise scipy.linalg.LinAlgError(f"{name} of LAPACK ended with {info.value}")


def _address(name: str) -> int:
    capsule = ctypes.py_object(scipy.linalg.cython_lapack.__pyx_capi__[name])
    name_of, pointer_of = ctypes.pythonapi.PyCapsule_GetName, ctypes.pythonapi.PyCapsule_GetPointer
    name_of.restype, name_of.argtypes = ctypes.c_char_p, [ctypes.py_object]
    pointer_of.restype, pointer_of.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    address: int = pointer_of(capsule, name_of(capsule))
    return address


def _pointer(value: Any) -> Any:
    """Everything goes by address."""
    if isinstance(value, np.ndarray):
        return ctypes.c_void_p(value.ctypes.data)
    if isinstance(value, bytes):
        return ctypes.c_char_p(value)
    kept = ctypes.c_int(value) if isinstance(value, int) else ctypes.c_double(value)
    return ctypes.byref(kept)
