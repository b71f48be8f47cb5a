"""The lowest eigenpairs of K φ = ω² M φ, none missed: by LAPACK, or by Davidson's method.

Davidson's method adds a block of preconditioned residuals to its basis at each step. With factors
as preconditioner it is a block Lanczos method, which finds every member of a multiple eigenvalue.
With V-cycles it is quicker than Lanczos' method with multigrid solutions: 16 modes of balls of 20
000 and 45 000 dofs take 1.2 and 3.0 s of processor time instead of 6.8 and 17.5 s, those of a plate
of 55 000 dofs 10.7 s instead of 30 s. With PARDISO's factors these three cases take 3.8, 11.8 and
7.2 s. SciPy's `lobpcg` with the same V-cycles takes 1.2 to 2.2 times as long.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
import scipy

from ..base import (
    PRINTED,
    ROUNDING,
    ArrayPair,
    ConvergenceError,
    FloatArray,
    SingularError,
    bar,
    warn,
)
from .pencil import Pencil
from .rigidity import m_orthonormal
from .solvers import LinearSolver, linear_solver

# Dofs up to which LAPACK on dense matrices is quicker than setting up an iteration.
DENSE_DOFS = 500

# Dofs up to which LAPACK computes all modes, in about a minute; with more dofs it would take
# several minutes and gigabytes.
DENSE_MOST = 6000

# Dofs up to which LAPACK replaces iterations that do not converge, as for the closely spaced
# eigenvalues of a pair K, M whose matrices were interchanged.
_DENSE_AT_WORST = 2000

# Ratio of the first guess of s² to ΣK_ii/ΣM_ii, which is near the highest ω². With this guess,
# K + s²M is definite beyond rounding, and the lowest ω² remain distinct.
_FIRST_SHIFT = 1e-4

# Smallest ω²/s² of the first elastic mode at which s² is kept: below it K is lost in the rounding
# of s²M. The largest one is 1 / _FIRST_SHIFT: above it s²M is lost in the rounding of K.
_SHIFT_BELOW = 0.1

# `_INVERSE_STEPS`: steps of inverse iteration from a random vector, and maximum corrections of s².
# The steps find the order of magnitude of the first elastic ω² unless it is far below s². In that
# case they find some s²/200 (of strips 1 m long and 0.5 to 3 mm thick), and the next s² is _FURTHER
# times this value.
_INVERSE_STEPS, _FURTHER = 8, 0.01

# Largest relative rounding of a mode's stiffness, eps |φ|ᵀ|K||φ| / φᵀKφ, without a warning. Bars
# and plates 1 000 to 10 000 times as long as thick: above this limit, the first ω is off by 1 % or
# more; below, by at most 0.3 %.
_DROWNED = 0.2

# Ratio of s² to its first guess for the removal of elastic strain from computed rigid modes.
_STRAIN_SHIFT = 1e-6

# Smallest ratio of a pivot of M to its diagonal entry at which LAPACK's reduction by M⁻¹ keeps the
# digits of low ω².
_LIGHT = 1e-6

# `_TOLERANCE`: limit of r·T r / ω², with the residual r and T ≈ (K + s²M)⁻¹; this is the relative
# error of ω², and its square root is the relative error of the mode. `_EPSILON`: ε in a bound of
# the rounding of K φ. The component of this rounding along any mode is up to ρ = ε √m Σ K_ii φ_i²,
# with m entries in a row; r·T r cannot fall below ρ² divided by the lowest ω² + s².
_TOLERANCE, _EPSILON = 1e-14, float(np.finfo(float).eps)

# Extra vectors in a block: one for every `_SPARE` modes, and at least `_SPARE`. They speed up the
# convergence of the last modes, and each random vector finds one member of a multiple eigenvalue.
_SPARE = 4

# Maximum size of the basis, in blocks, before a restart with a basis of two blocks.
_MOST_BLOCKS = 12

# Maximum number of steps. Cubes and beams take 13 to 21 for 4 and 16 modes; a sheet 150 times as
# long as thick takes 98 for 16 modes, and more for 4.
_MOST_STEPS = 100


def dense_modes(stiffness: FloatArray, mass: FloatArray, n: int | None = None) -> ArrayPair:
    """Return ω² and M-orthonormal φ of K φ = ω² M φ by LAPACK: the `n` lowest, or all.

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
    some = None if n is None else [0, n - 1]
    solved = partial(scipy.linalg.eigh, subset_by_index=some, overwrite_a=True, overwrite_b=True)
    factor, failed = scipy.linalg.lapack.dpotrf(mass, lower=1)
    whole = float(np.trace(mass))
    try:
        if not failed and (np.diagonal(factor) ** 2 >= _LIGHT * np.diagonal(mass)).all():
            omega2, modes = solved(stiffness, mass)
            return omega2, modes
        # For motions with almost no mass, such as those of elements with mass at few points, solve
        # M φ = θ (K + s²M) φ with θ = 1/(ω² + s²), in which these motions have θ = 0.
        if whole <= 0.0:
            raise scipy.linalg.LinAlgError("mass is not positive semidefinite")
        s2 = _FIRST_SHIFT * float(np.trace(stiffness)) / whole
        inverse, modes = solved(-mass, stiffness + s2 * mass)
        theta = -inverse
        if theta[-1] < -np.sqrt(ROUNDING) * theta[0]:
            raise scipy.linalg.LinAlgError("mass is not positive semidefinite")
    except scipy.linalg.LinAlgError as error:
        raise SingularError(
            f"K and M have no modes that can be computed ({error}); give both with all their "
            "digits, hold what is too heavy to move, and condense out what has no mass"
        ) from None
    heavy = theta > ROUNDING * theta[0]
    return 1.0 / theta[heavy] - s2, modes[:, heavy] / np.sqrt(theta[heavy])


def shifted(
    K: Any,
    M: Any,
    rigid: FloatArray,
    solver_at: Callable[[float], LinearSolver],
    first: LinearSolver | None = None,
) -> LinearSolver:
    """Return the solver of K + s²M with s² near the lowest elastic eigenvalue.

    K of a free body is singular, and K + s²M is not. If s² is far below the first elastic
    eigenvalue, digits are lost; if s² is far above, more iterations are needed. So s² is corrected
    once the eigenvalue is known roughly.

    Parameters
    ----------
    K, M : scipy.sparse matrices, shape (n, n)
    rigid : ndarray, shape (n, r)
        M-orthonormal basis of the null space of K.
    solver_at : callable
        s² ↦ the solver of K + s²M, such as `FEModel.inverse`, which uses the body's mesh.
    first : LinearSolver, optional
        The solver at the first guess of s², if it exists already.
    """
    current = first or solver_at(_first_shift(K, M))
    for _ in range(_INVERSE_STEPS):  # the second is the last except for the slenderest bodies
        modes, x = rigid, np.random.default_rng(1).standard_normal((K.shape[0], 1))
        for _ in range(_INVERSE_STEPS):
            x = m_orthonormal(modes, current.solve(M @ x), M)
            modes = np.column_stack([modes, x])
        basis = modes[:, rigid.shape[1] :]
        # Upper bound of the first elastic ω², by Lanczos' method. It is a rounding error if `rigid`
        # lacks a rigid motion.
        elastic = float(np.linalg.eigvalsh(basis.T @ (K @ basis))[0])
        if elastic <= 0.0 or _SHIFT_BELOW * current.s2 <= elastic <= current.s2 / _FIRST_SHIFT:
            break
        try:
            current = solver_at(elastic if elastic > current.s2 else _FURTHER * elastic)
        except SingularError:  # rounding of K may leave a rigid motion a negative stiffness
            break
    return current


def _first_shift(K: Any, M: Any) -> float:
    """Return a guess of s², (rad/s)²: K + s²M is definite beyond rounding, s²M small beside K."""
    return _FIRST_SHIFT * float(K.diagonal().sum() / M.diagonal().sum())


def null_space(K: Any, M: Any, soft: float | None = None) -> FloatArray:
    """Return the M-orthonormal modes of zero stiffness, shape (n, r), from the matrices alone.

    A mode counts as rigid if ‖Kφ‖ ≤ 1e-12 ‖|K||φ|‖: its elastic forces are rounding errors. The
    ratio is some 1e-15 for rigid modes, and 1e-9 for elastic modes of the slenderest meshes that
    doubles can represent.

    Parameters
    ----------
    K, M : scipy.sparse matrices, shape (n, n)
    soft : float, optional
        Return instead the modes with ω² up to this value, (rad/s)².
    """
    n = K.shape[0]
    wanted = min(n, 8)
    while True:
        omega2, modes = lowest(K, M, wanted)
        forces = np.linalg.norm(K @ modes, axis=0)
        scale = np.linalg.norm(abs(K) @ np.abs(modes), axis=0)
        rigid = forces <= ROUNDING * scale if soft is None else omega2 <= soft
        if not rigid.all() or len(rigid) < wanted or wanted == n:
            break
        wanted = min(n, 4 * wanted)
    modes = modes[:, rigid]
    if rigid.any() and soft is None:
        # This multiplies a component of elastic strain by s²/(ω² + s²); s² is far below any elastic
        # ω².
        near_k = linear_solver(Pencil(K, M, _STRAIN_SHIFT * _first_shift(K, M)))
        modes = modes - near_k.solve(K @ modes)
    return np.ascontiguousarray(m_orthonormal(None, modes, M))


def lowest(
    K: Any,
    M: Any,
    n: int,
    *,
    known: FloatArray | None = None,
    invert: Callable[[float], LinearSolver] | None = None,
) -> ArrayPair:
    """Return the `n` lowest eigenpairs, none missed.

    Parameters
    ----------
    K, M : scipy.sparse matrices, shape (dofs, dofs)
        Symmetric, positive semidefinite; K + s²M positive definite.
    n : int
        Number of eigenpairs, 1 … dofs; fewer are returned if motions have no mass.
    known : ndarray, shape (dofs, r), optional
        M-orthonormal basis of the null space of K; its modes come first, with ω² exactly 0.
    invert : callable, optional
        s² ↦ the solver of K + s²M, such as `FEModel.inverse`.

    Returns
    -------
    omega2 : ndarray, shape (n,), or fewer
        ω², (rad/s)², ascending, not below 0.
    modes : ndarray, shape (dofs, n), or fewer
        M-orthonormal.
    """
    dofs = K.shape[0]
    rigid = np.zeros((dofs, 0)) if known is None else known
    count = rigid.shape[1]
    n = min(n, int(np.count_nonzero(M.diagonal())))  # rows without mass add no modes
    if n <= count:
        return np.zeros(n), rigid[:, :n].copy()
    if dofs > DENSE_DOFS and n <= dofs // 5:
        try:
            omega2, modes = _iterated(K, M, n - count, known, invert)
            return (
                np.concatenate([np.zeros(count), np.maximum(omega2, 0.0)])[:n],
                np.column_stack([rigid, modes])[:, :n],
            )
        except ConvergenceError:
            if dofs > _DENSE_AT_WORST:
                raise
    omega2, modes = dense_modes(K.toarray(order="F"), M.toarray(order="F"), n)
    omega2[:count], modes[:, :count] = 0.0, rigid
    return np.maximum(omega2, 0.0), modes


def _iterated(
    K: Any,
    M: Any,
    n: int,
    known: FloatArray | None,
    invert: Callable[[float], LinearSolver] | None,
) -> ArrayPair:
    """Return eigenpairs by Davidson's method; preconditioner: V-cycles, or a direct solver."""
    solver_at = invert or (lambda s2: linear_solver(Pencil(K, M, s2)))
    near = None
    if known is not None and not known.shape[1]:
        with suppress(SingularError):  # K may be singular to rounding
            near = solver_at(0.0)
    near = near or solver_at(_first_shift(K, M))
    if known is None:  # correcting the first guess of s² needs the null space
        return davidson(K, M, near.solve, n, s2=near.s2)
    if (cycle := near.precondition) is not None:
        try:
            return davidson(K, M, cycle, n, away_from=known, s2=near.s2, most=near.most)
        except ConvergenceError:
            if near.most == np.inf:
                raise
        near.factorise()
    base = near if near.s2 == 0.0 else shifted(K, M, known, solver_at, near)
    return davidson(K, M, base.solve, n, away_from=known, s2=base.s2)


def davidson(
    K: Any,
    M: Any,
    precondition: Callable[[FloatArray], FloatArray],
    n: int,
    *,
    away_from: FloatArray | None = None,
    s2: float = 0.0,
    most: float = np.inf,
) -> ArrayPair:
    """Return the `n` lowest eigenpairs of K φ = ω² M φ.

    Each step adds T r_j to the basis, for the residual r_j of each pair that has not converged, and
    takes the Rayleigh-Ritz pairs of the basis: Morgan and Scott, SIAM J. Sci. Stat. Comput. 7
    (1986), in blocks.

    Parameters
    ----------
    K, M : scipy.sparse matrices, shape (dofs, dofs)
        Symmetric, positive semidefinite.
    precondition : callable
        T, f ↦ ≈ (K + s²M)⁻¹ f, f of shape (dofs, any), with s² near the lowest eigenvalues.
    n : int
    away_from : ndarray, shape (dofs, r), optional
        M-orthonormal eigenvectors to keep out of the result.
    s2 : float, optional
        s² of the preconditioner, (rad/s)².
    most : float, optional
        Maximum number of preconditioned vectors.

    Returns
    -------
    omega2, modes : ndarrays, shapes (n,), (dofs, n)
        Ascending; modes M-orthonormal. There are fewer if fewer motions have mass.

    Raises
    ------
    ConvergenceError
        If it takes more than 100 steps, or more than `most` preconditioned vectors.
    """
    width = n + max(_SPARE, n // _SPARE)
    start = np.random.default_rng(5).standard_normal((M.shape[0], width))
    block, stiff = precondition(M @ start), _EPSILON * (K.nnz / K.shape[0]) ** 0.5 * K.diagonal()
    basis, stiffness = np.zeros((M.shape[0], 0)), np.zeros((0, 0))
    open_pairs, before = np.ones(n, dtype=bool), np.full(n, np.inf)
    made = width
    with bar(f"{n} modes, {M.shape[0]} dofs", n, unit="mode") as progress:
        for _ in range(_MOST_STEPS):
            known = basis if away_from is None else np.column_stack([away_from, basis])
            new = m_orthonormal(known, block, M)
            if basis.shape[1] + new.shape[1] < n:  # too few independent vectors: add random ones
                new = m_orthonormal(known, np.column_stack([block, start]), M)
                n = min(n, basis.shape[1] + new.shape[1])
                open_pairs, before = open_pairs[:n], before[:n]
            block = new
            stiff_block = K @ block
            beside, own = basis.T @ stiff_block, block.T @ stiff_block
            stiffness = np.block([[stiffness, beside], [beside.T, 0.5 * (own + own.T)]])
            basis = np.column_stack([basis, block])
            omega2, within = scipy.linalg.eigh(stiffness)
            modes, omega2_n = basis @ within[:, :n], omega2[:n]
            # A converged ω² that changes has not converged: a lower ω² has appeared.
            open_pairs |= np.abs(omega2_n - before) > PRINTED * omega2_n
            residual = K @ modes[:, open_pairs] - (M @ modes[:, open_pairs]) * omega2_n[open_pairs]
            block = precondition(residual)
            error = np.einsum("ij,ij->j", residual, block)
            rounding = (stiff @ modes[:, open_pairs] ** 2) ** 2 / (abs(omega2[0]) + s2)
            wrong = error > np.maximum(_TOLERANCE * omega2_n[open_pairs], rounding)
            block = block[:, wrong]
            open_pairs[open_pairs] = wrong
            before = omega2_n
            progress.update(n - int(open_pairs.sum()) - progress.n)
            if not open_pairs.any():
                return omega2_n, modes
            made += len(error)
            if made > most:
                break
            if basis.shape[1] + block.shape[1] > _MOST_BLOCKS * width:
                basis = basis @ within[:, : 2 * width]
                stiffness = np.diag(omega2[: 2 * width])
    raise ConvergenceError(
        f"{int(open_pairs.sum())} of {n} modes of {M.shape[0]} dofs did not converge in {made} "
        "solutions: parts of the body may be far softer than others, or its elements flat. Ask for "
        "fewer modes, or take a coarser mesh"
    )


def warn_of_rounding(K: Any, modes: FloatArray, what: str) -> None:
    """Warn if the rounding of K is as large as the stiffness of some `modes`, shape (dofs, n).

    `what`: number and name of the modes, or of results computed from them, for the warning.
    """
    sizes = np.abs(modes)
    rounding = np.finfo(float).eps * (sizes * (abs(K) @ sizes)).sum(axis=0)
    lost = np.flatnonzero(rounding > _DROWNED * np.abs((modes * (K @ modes)).sum(axis=0)))
    if len(lost):
        warn(
            f"{len(lost)} of {what} may be wrong by percents, or altogether, the first of them "
            f"number {lost[0]}, counted from 0: rounding of K is as large as their stiffness. The "
            "body is too slender, or too thin, for solid elements; take a thicker one, or K and M "
            "of a beam or plate"
        )
