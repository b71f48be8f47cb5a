"""K and M of the same rows, as they are made one model: joined, checked, scaled, condensed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import InputError, IntArray, SingularError
from ..linalg import factorize
from .found import Found, symmetric

# Abaqus holds a dof by a stiffness of 1e36 on its diagonal.
_HOLDING = 1e30

# A highest frequency below 1 rad/s is that of no body that is struck: K and M are exchanged.
_LEAST_OMEGA2 = 1.0

# Up to so many dofs with mass, those without are condensed, so that all rows are displacements of
# nodes: K becomes a full matrix.
_CONDENSED = 6000


@dataclass(frozen=True, eq=False)
class Pair:
    """Matrices of the same rows, what the rows are called, and which are constrained."""

    K: Any
    M: Any
    labels: IntArray | None
    called: str


def joined(stiffness: Found, inertia: Found, given: IntArray | None) -> Pair:
    """Both matrices in the same rows."""
    called = f"{stiffness.called}, {inertia.called}"
    if (stiffness.labels is None) != (inertia.labels is None):
        raise InputError(f"{called}: only one of them lists which dofs its rows are")
    if stiffness.labels is None or inertia.labels is None:
        size = stiffness.size
        if size != inertia.size or size is None:
            raise InputError(
                f"{called}: K has {stiffness.size} rows and M {inertia.size}: is one cut short?"
            )
        return Pair(symmetric(stiffness, size), symmetric(inertia, size), given, called)
    both = np.concatenate([stiffness.labels, inertia.labels])
    labels, places = np.unique(both, axis=0, return_inverse=True)
    places = places.ravel()
    parts = places[: len(stiffness.labels)], places[len(stiffness.labels) :]
    without = np.setdiff1d(parts[1], parts[0])
    if len(without):
        node, component = labels[without[0]]
        raise InputError(
            f"{called}: K lacks {len(without)} dofs of M, as {node}.{component}: is it cut short?"
        )
    made = [
        symmetric(
            replace(one, rows=rows[one.rows], cols=rows[one.cols], labels=labels), len(labels)
        )
        for one, rows in zip((stiffness, inertia), parts, strict=True)
    ]
    return Pair(made[0], made[1], labels, called)


def _kept(pair: Pair, rows: Any) -> Pair:
    if rows.all():
        return pair
    labels = None if pair.labels is None else pair.labels[rows]
    return replace(pair, K=pair.K[rows][:, rows], M=pair.M[rows][:, rows], labels=labels)


def without_held(pair: Pair) -> Pair:
    """The pair without dofs that are constrained, and those with neither stiffness nor mass."""
    diagonal = pair.K.diagonal()
    stiff = np.asarray(abs(pair.K).sum(axis=1)).ravel()
    heavy = np.asarray(abs(pair.M).sum(axis=1)).ravel()
    keep = (diagonal < _HOLDING) & ((stiff > 0.0) | (heavy > 0.0))
    if not keep.any():
        raise InputError(f"{pair.called}: no dof has stiffness or mass and is free to move")
    return _kept(pair, keep)


def check_exchange(pair: Pair) -> None:
    """Refuse rows without their diagonal, one matrix given twice, and M in the place of K."""
    for name, matrix in (("K", pair.K), ("M", pair.M)):
        _check_diagonal(pair, name, matrix)
    if pair.K.nnz == pair.M.nnz and not (pair.K - pair.M).data.any():
        raise InputError(f"{pair.called}: K and M have the same entries; give M its own file")
    largest = float(np.abs(pair.K.diagonal()).max(initial=0.0))
    heaviest = float(np.abs(pair.M.diagonal()).max(initial=0.0))
    if 0.0 < largest < _LEAST_OMEGA2 * heaviest:
        raise InputError(
            f"{pair.called}: K is up to {largest:.3g} and M up to {heaviest:.3g}, so that no "
            "frequency reaches 1 rad/s: are K and M exchanged?"
        )


def _check_diagonal(pair: Pair, name: str, matrix: Any) -> None:
    size = np.asarray(abs(matrix).sum(axis=1)).ravel()
    without = np.flatnonzero((matrix.diagonal() == 0.0) & (size > 0.0))
    # Internal rows of Abaqus, with nodes below 1, may have no stiffness of their own.
    inner = (
        name == "K" and pair.labels is not None and bool((pair.labels[without, 0] <= 0)[:1].any())
    )
    if len(without) and not inner:
        raise InputError(
            f"{pair.called}: {name} lacks the diagonal of {_at(pair, without[0])} and of "
            f"{len(without) - 1} more rows: is the file cut short?"
        )


def _at(pair: Pair, row: int) -> str:
    """A row as its program calls it."""
    if pair.labels is None:
        return f"row {row + 1}"
    node, component = pair.labels[row]
    return f"dof {node}.{component}"


def scaled(pair: Pair, length: float, mass: float) -> Pair:
    """The pair in SI units: what belongs to rotations is a moment, of one length more."""
    D = None
    if pair.labels is not None and (pair.labels[:, 1] > 3).any():
        D = sp.diags_array(np.where(pair.labels[:, 1] > 3, length, 1.0))
    scaled = [mass * one if D is None else mass * (D @ one @ D) for one in (pair.K, pair.M)]
    return replace(pair, K=sp.csr_array(scaled[0]), M=sp.csr_array(scaled[1]))


def condensed(pair: Pair, *, rotations: bool) -> Pair:
    """The pair without inner dofs that have no mass: K̂ = K_aa - K_ai K_ii⁻¹ K_ia, exact.

    Larger models keep these dofs; then no coordinates are known of their rows. Rotations are inner
    dofs if `rotations`, and else kept.
    """
    light = np.asarray(abs(pair.M).sum(axis=1)).ravel() == 0.0
    if not rotations and pair.labels is not None:
        light &= pair.labels[:, 1] <= 3
    if not light.any() or (~light).sum() > _CONDENSED:
        return pair
    at, inner = _at(pair, int(np.flatnonzero(light)[0])), np.zeros_like(light)
    if pair.labels is not None:
        inner = (pair.labels[:, 0] <= 0) | (pair.labels[:, 1] > 3)
    if (light & ~inner).any():
        raise InputError(
            f"{pair.called}: {light.sum()} of {len(light)} dofs have no mass, the first is {at}: "
            "is M cut short, or lumped? Write a consistent mass matrix"
        )
    K = pair.K
    across = K[light][:, ~light].toarray()
    try:
        solved = factorize(K[light][:, light], what="K of the dofs without mass").solve(across)
    except SingularError as error:
        raise InputError(
            f"{pair.called}: {light.sum()} dofs without mass cannot be condensed ({error}); model "
            "without multipliers, as of hybrid elements and couplings"
        ) from None
    kept = _kept(pair, ~light)
    full = kept.K.toarray() - across.T @ solved
    return replace(kept, K=sp.csr_array(0.5 * (full + full.T)))
