"""MKL PARDISO: factors of large sparse matrices, where the package py-mkl-pardiso is installed."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from .errors import InputError, MemoryLimitError, SingularError
from .superlu import check_condition

__all__ = ["inverse", "is_installed"]

FloatArray = npt.NDArray[np.float64]


def is_installed() -> bool:
    """Whether the package py-mkl-pardiso is there."""
    return importlib.util.find_spec("pymklpardiso") is not None


def inverse(matrix: Any, what: str) -> Callable[[FloatArray], FloatArray]:
    """Factorise a sparse symmetric positive definite matrix; return f ↦ A⁻¹ f.

    Raises
    ------
    InputError
        If the package is not installed.
    SingularError
        If the matrix is singular to rounding or not positive definite.
    """
    try:
        from pymklpardiso import MTYPE_REAL_SYM_POSDEF, PardisoSolver
    except ImportError as error:
        raise InputError(
            "solver='pardiso' needs the package py-mkl-pardiso (Linux and Windows on x86-64): "
            f"pip install 'aoimpact[direct]' ({error})"
        ) from None
    try:
        factors = PardisoSolver(sp.triu(matrix, format="csr"), MTYPE_REAL_SYM_POSDEF)
    except RuntimeError as error:  # PARDISO: "zero pivot / numerical factorization failure"
        if "memory" in str(error):
            raise MemoryLimitError(f"solver 'pardiso' of {what}: {error}") from None
        raise SingularError(f"{what} is singular or not positive definite ({error})") from None
    solve: Callable[[FloatArray], FloatArray] = factors.solve
    check_condition(matrix, solve, what)
    return solve
