"""MKL PARDISO: factors of large sparse matrices, where the package py-mkl-pardiso is installed."""

from __future__ import annotations

import importlib.util
import math
from functools import partial
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, MemoryLimitError, SingularError
from .method import Inverse, Method, of_factors
from .pencil import Pencil
from .superlu import check_condition

# PARDISO's iparm, counted from 0. 1: nested dissection; 23: two-level scheduling of the
# factorisation; 36 (`_BLOCKS`): rows of like patterns, such as the rows of a node, are ordered as
# one block if at least `_ALIKE` percent of the block are entries. On plates, balls and shells of
# 14 000 to 224 000 dofs, blocks reduce the time of the analysis to 0.2 to 0.5 of the time without
# blocks, and leave the size of the factors unchanged.
_OPTIONS = {1: 2, 23: 1}
_BLOCKS, _ALIKE = 36, 80

# Maximum rows of a block of like rows, with a margin: more than 128 rows, such as those of the
# nodes of a rigid mass, overwrite PARDISO's stack and crash the interpreter.
_LARGEST = 100

# Times, s, and bytes for `of_factors`. PARDISO stores L by supernodes, and a copy of K.
_COST = of_factors((1e-11, 3e-8, 0.9e-9), 12.0, 30.0)


def is_installed() -> bool:
    """Return whether the package py-mkl-pardiso is installed."""
    return importlib.util.find_spec("pymklpardiso") is not None


class _Factors:
    """Factors of K + s²M for one s² at a time; the analysis of the pattern serves every s².

    Replacing the factors takes at most half the time of a first factorisation. It speeds up the
    construction of models of thin bodies, which also need factors of K for their static mode, by a
    factor of 1.31 to 1.37 (benchmarks/reduction.py --constrained: two plates and a bar of
    tetrahedra).
    """

    def __init__(self, pencil: Pencil) -> None:
        self._pencil, self._s2 = pencil, math.nan
        self._indices: Any = None
        self._solver = _pardiso()
        for place, value in _OPTIONS.items():
            self._solver.set_iparm(place, value)
        self._factorise(pencil)

    def at(self, s2: float) -> Inverse:
        """Return the inverse at a shift; its solutions replace the factors of any other shift."""
        return Inverse(partial(self._solve, self._pencil.at(s2)), at=self.at)

    def _solve(self, pencil: Pencil, rhs: FloatArray) -> FloatArray:
        if pencil.s2 != self._s2:
            self._factorise(pencil)
        solution: FloatArray = self._solver.solve(rhs)
        return solution

    def _factorise(self, pencil: Pencil) -> None:
        what, diagonal = pencil.what, pencil.diagonal
        without = np.flatnonzero(~(diagonal > 0.0))
        if len(without):  # PARDISO reads out of bounds in a row without a diagonal entry
            raise SingularError(
                f"{what} is singular or not positive definite (its diagonal entry {without[0]}, "
                f"counted from 0, is {diagonal[without[0]]:g})"
            )
        matrix, by = pencil.matrix(), self._solver.refactor_values
        if matrix.indices is not self._indices:
            self._take_pattern(matrix)
            by = self._solver.factor
        self._s2 = math.nan  # no valid factors until the new ones exist
        try:
            by(matrix.data[self._upper])
        except RuntimeError as error:  # PARDISO: "zero pivot / numerical factorization failure"
            if "memory" in str(error):
                raise MemoryLimitError(f"solver 'pardiso' of {what}: {error}") from None
            raise SingularError(f"{what} is singular or not positive definite ({error})") from None
        check_condition(matrix, self._solver.solve, what, diagonal=diagonal)
        self._s2 = pencil.s2

    def _take_pattern(self, matrix: Any) -> None:
        row = np.repeat(np.arange(matrix.shape[0], dtype=np.int32), np.diff(matrix.indptr))
        ahead = matrix.indices - row
        self._indices, self._upper = matrix.indices, ahead >= 0
        near, counts = (
            np.add.reduceat(of, matrix.indptr[:-1], dtype=np.int64)
            for of in (self._upper & (ahead < _LARGEST), self._upper)
        )
        safe = 100 * near.max() < _ALIKE * _LARGEST
        self._solver.set_iparm(_BLOCKS, -_ALIKE if safe else 0)
        starts, columns = np.concatenate([[0], np.cumsum(counts)]), matrix.indices[self._upper]
        self._solver.set_pattern(ia=starts, ja=columns.astype(np.int64), n=len(counts))


def _pardiso() -> Any:
    """Return a solver of the package's compiled class.

    The package's Python class checks row by row, which doubles the time on slender bodies.
    """
    try:
        from pymklpardiso import MTYPE_REAL_SYM_POSDEF
        from pymklpardiso._mkl_pardiso import PardisoSolver
    except ImportError as error:
        raise InputError(
            "solver='pardiso' needs the package py-mkl-pardiso (Linux and Windows on x86-64): "
            f"pip install 'aoimpact[direct]' ({error})"
        ) from None
    return PardisoSolver(MTYPE_REAL_SYM_POSDEF, 0)


PARDISO = Method("pardiso", lambda pencil: _Factors(pencil).at(pencil.s2), _COST, is_installed)
