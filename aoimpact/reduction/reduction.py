"""Reduction by eigenpairs: a body's natural modes, and its constraint modes, eqs. (4)-(12)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import scipy

from .. import _core
from ..base import (
    ArrayPair,
    ConvergenceError,
    FloatArray,
    InputError,
    InputTypeError,
    SingularError,
    bar,
    choice,
    integer,
    warn,
)
from ..contact import ContactPoint, StaticMode, refuse_massless, refuse_mechanism, static_mode
from ..linalg import (
    DENSE_DOFS,
    EQUAL,
    FEW_SOLUTIONS,
    LinearSolver,
    Solver,
    checked_solver,
    dense_modes,
    lowest,
    shifted,
    warn_of_rounding,
)
from .body import Body, checked_ports, of_modes
from .krylov import KrylovSpace
from .star import AOModel, excited, with_shapes

# Dofs up to which LAPACK finds all oscillators: a minute or so; beyond, minutes and gigabytes.
_DENSE_MOST = 6000

# Steps of Lanczos' method at most: a number, and some and a share of the dofs, so that steps in
# vain take a tenth of what LAPACK then takes from 2000 dofs on. Residual, relative to the
# eigenvalue, of a mode found.
_MOST_STEPS, _SOME, _SHARE_OF_DOFS, _CONVERGED = 600, 60, 1 / 12, 1e-10

# Solutions foreseen for each oscillator: on a beam, a plate and a block 5 to 300 were counted, the
# least for many in the order of their frequencies.
_SOLUTIONS_EACH = 20

# An oscillator with less than this share of the static mass carries none: it is rounding.
_NO_MASS = 1e-13

# A residual mass of no more than this share of the static mass is none: the rounding of thousands
# of masses. A contact on a dof without mass has none.
_ROUNDING_OF_MASS = 1e-11


# Returns the solver of K + s²M for s².
Invert = Callable[[float], LinearSolver]

# Masses, stiffnesses, and shapes Ψ_i = c_i φ_i of the anti-oscillators found so far.
_Found = tuple[FloatArray, FloatArray, FloatArray]


def _oscillators(
    tip: ContactPoint, static: StaticMode, omega2: FloatArray, phi: FloatArray
) -> _Found:
    """Eqs. (6), (9), (12) for constraint modes of ascending frequency; multiple ones are joined."""
    m, k, c = (np.empty(len(omega2)) for _ in range(3))
    of = np.empty(len(omega2), dtype=np.int32)
    by_mode, m_by_mode = (np.ascontiguousarray(x.T) for x in (phi, tip.body.M @ phi))
    try:
        count, _ = _core.star_from_constraint_modes(
            static.phi, static.m_phi, static.k0, by_mode, m_by_mode, omega2, m, k, c, of
        )
    except SingularError:
        raise SingularError(
            "a constraint mode that carries mass has no stiffness: part of the body is a mechanism"
            ", or K is not positive semidefinite; see body.frequencies(10)"
        ) from None
    shapes = np.zeros((len(phi), count))
    np.add.at(shapes.T, of[of >= 0], (c * phi).T[of >= 0])
    return m[:count], k[:count], shapes


def _all_constraint_modes(tip: ContactPoint) -> ArrayPair:
    """By LAPACK: a reflection turns bᵀφ = 0 into "first entry zero".

    The dof that b moves most comes first: a reflection of one that b does not move loses its mass
    in the rounding of a far heavier one that b moves.
    """
    n = tip.body.n_dofs
    order, most = np.arange(n), int(np.argmax(np.abs(tip.b)))
    order[[0, most]] = most, 0
    across = np.empty((n, n - 1))
    across[order] = np.linalg.qr(tip.b[order][:, None], mode="complete")[0][:, 1:]
    few = scipy.sparse.csr_array(across)  # b moves few dofs
    pencil = [(few.T @ matrix @ few).toarray(order="F") for matrix in (tip.body.K, tip.body.M)]
    omega2, y = dense_modes(*pencil)
    return omega2, few @ y


def _first_oscillators(
    tip: ContactPoint,
    static: StaticMode,
    n: int,
    order: str,
    solvers: Invert,
) -> tuple[_Found, float]:
    """Return the first `n` oscillators among those found, and the mass that one left out may have.

    Lanczos' method on bᵀφ = 0, started from what φ_st is there: the masses that its Ritz values
    have are Gauss' weights of the masses m_i over 1/(ω_i² + s²). No more mass lies between two
    neighbours than both have (Chebyshev, Markov and Stieltjes; Szegő, Orthogonal Polynomials,
    3.41). Of each multiple eigenvalue it meets the one mode that carries mass.
    """
    K, M, b = tip.body.K, tip.body.M, tip.b
    if tip.body.rigid_modes.shape[1] == 0:
        base = solvers(0.0)
    else:
        base = shifted(K, M, tip.body.rigid_modes, solvers)
    z, idle = base.solve(b), static.unobservable
    start = _across(tip, static)
    mass = float(start @ (M @ start))
    most = min(_MOST_STEPS, _SOME + int(_SHARE_OF_DOFS * tip.body.n_dofs))
    basis = np.empty((most + 1, tip.body.n_dofs))
    basis[0] = start / math.sqrt(mass)
    diagonal, off, look = np.empty(most), np.empty(most), n
    for k in range(most):
        x = base.solve(M @ basis[k])
        for _ in range(2):  # the first subtracts large numbers where b is soft beside the rest
            x -= (b @ x) / (b @ z) * z
        x -= idle @ (idle.T @ (M @ x))
        parts = basis[: k + 1] @ (M @ x)
        x -= parts @ basis[: k + 1]
        x -= (basis[: k + 1] @ (M @ x)) @ basis[: k + 1]  # once more, for what rounding leaves
        diagonal[k], off[k] = parts[k], math.sqrt(x @ (M @ x))
        if not math.isfinite(off[k]):
            raise ConvergenceError("the contact functional is too small to be computed with")
        exhausted = off[k] == 0.0
        if not exhausted:
            basis[k + 1] = x / off[k]
        if k < look and k + 1 < most and not exhausted:
            continue
        look += max(4, look // 4)
        theta, y = scipy.linalg.eigh_tridiagonal(diagonal[: k + 1], off[:k])
        theta, y = theta[::-1], y[:, ::-1]
        masses = mass * y[0] ** 2
        found = off[k] * np.abs(y[-1]) <= _CONVERGED * theta
        left = np.where(found, 0.0, masses)
        if order == "frequency":  # those below the first that has not converged
            found &= np.cumsum(~found) == 0
        chosen = np.flatnonzero(found & (masses > _NO_MASS * static.mass))
        largest = float((left + np.append(left[1:], 0.0)).max())
        omega2 = 1.0 / theta[chosen] - base.s2
        # Rounding brings in further modes of a multiple eigenvalue, which make one oscillator.
        enough = np.count_nonzero(np.diff(omega2, prepend=-np.inf) > EQUAL * omega2) >= n
        if enough and order == "mass" and n:
            enough = largest <= np.sort(masses[chosen])[-n]
        if enough or exhausted:
            largest = 0.0
            break
    phi = y[:, chosen].T @ basis[: k + 1]
    return _oscillators(tip, static, omega2, phi.T), largest


def _across(tip: ContactPoint, static: StaticMode) -> FloatArray:
    """Return the part of φ_st in bᵀx = 0, M-orthogonal to all else: φ_st less a share of M⁻¹ b."""
    M, b = tip.body.M, tip.b
    diagonal = np.where(M.diagonal() > 0.0, M.diagonal(), 1.0)
    jacobi = scipy.sparse.diags_array(1.0 / diagonal)
    with np.errstate(all="ignore"):
        x, failed = scipy.sparse.linalg.cg(M, b, rtol=1e-13, maxiter=2000, M=jacobi)
    reach = float(b @ x)
    if failed or not reach > 0.0:
        raise ConvergenceError("some motion at the contact has no mass: take method='krylov'")
    found: FloatArray = static.phi - x * (float(b @ static.phi) / reach)
    return found


def _wanted_oscillators(
    tip: ContactPoint,
    static: StaticMode,
    n: int,
    order: str,
    solvers: Invert,
) -> _Found:
    dofs, found, left_out = tip.body.n_dofs, None, math.inf
    if dofs > DENSE_DOFS:
        try:
            with np.errstate(over="ignore", invalid="ignore"):  # found by what comes of it
                found, left_out = _first_oscillators(tip, static, n, order, solvers)
        except ConvergenceError:
            if dofs > _DENSE_MOST:
                raise
    if found is None or (left_out > 0.0 and dofs <= _DENSE_MOST):
        return _oscillators(tip, static, *_all_constraint_modes(tip))
    if left_out > 0.0:
        warn(
            f"n={n}: {len(found[0])} anti-oscillators were found in {_MOST_STEPS} steps, and one "
            f"of up to {left_out:.3g} kg may be missing. Take fewer, or method='krylov'"
        )
    return found


def antioscillators(
    tip: ContactPoint,
    n: int | None = None,
    *,
    method: str = "eigen",
    order: str | None = None,
    contact_time: float | None = None,
    duration: float | None = None,
    solver: Solver = "auto",
) -> AOModel:
    """Return the anti-oscillator model of a body at its contact: equations (1) to (12).

    Parameters
    ----------
    tip : ContactPoint
        From `FEModel.contact`.
    n : int, optional
        How many oscillators that carry mass; all of them if not given ("eigen" only). The others'
        mass stays in m0, eq. (10).
    method : {"eigen", "krylov"}
        For an impact take "krylov", with `contact_time`: 5 of its oscillators give the force on the
        beam of the paper to 0.5 %, where "eigen" needs 28. They are those of the body projected on
        its static mode and the motions that an impact excites; vibration long after the impact
        needs `duration`, and an oscillator or two for each natural mode in it. "eigen": the
        constraint modes of the paper, which fit no scene and converge at every time scale.
    order : {"mass", "frequency"}, optional
        Which come first: those of the largest mass ("eigen"'s default) or of the lowest frequency
        ("krylov"'s only one).
    contact_time : float, optional
        How long the contact lasts, s, roughly ("krylov" only); else estimated, see `KrylovSpace`.
    duration : float, optional
        How long the motion is to be right, s, if much longer than the contact ("krylov" only).
    solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        The linear solver for what is too large for dense matrices; see `FEModel.inverse`.

    Returns
    -------
    AOModel
        With fewer than `n` oscillators, and a warning, if b excites fewer.

    Raises
    ------
    InputError
        If `n` is not in 0 … n_dofs - 1, or None on a body too large for all of them.
    SingularError
        If the contact moves part of the body as a mechanism. One that it does not move does no harm
        to a free body; a constrained one is refused where K has to be factorised.

    Warns
    -----
    AOImpactWarning
        If b excites fewer than `n` oscillators, or it is not proven that they are the heaviest.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> end = bar.contact(point=(0.1, 0.005, 0.005))
    >>> model = ao.antioscillators(end, n=4, method="krylov", contact_time=1e-4)
    >>> model.n, model.k0, round(model.static_mass / bar.mass, 6)  # free, struck through its centre
    (4, 0.0, 1.0)
    """
    if not isinstance(tip, ContactPoint):
        raise InputTypeError(f"tip must come from FEModel.contact(...), got {tip!r}")
    if choice("method", method, ("eigen", "krylov")) == "krylov":
        if order is not None:
            choice("order", order, ("frequency",))
        if n is None:
            raise InputError("n=None: method='krylov' makes a given number of oscillators; give n")
        space = KrylovSpace(tip, contact_time=contact_time, duration=duration, solver=solver)
        return space.antioscillators(n)
    by = choice("order", "mass" if order is None else order, ("mass", "frequency"))
    if contact_time is not None or duration is not None:
        raise InputError(
            "contact_time and duration are for method='krylov'; method='eigen' fits no scene"
        )
    dofs = tip.body.n_dofs
    wanted = None if n is None else integer("n", n, low=0, high=dofs - 1)
    if wanted is None and dofs > _DENSE_MOST:
        raise InputError(
            f"n=None asks for all {dofs - 1} anti-oscillators of a body of {dofs} dofs, which "
            f"needs dense matrices; give n (all are computed up to {_DENSE_MOST} dofs)"
        )
    refuse_mechanism([tip])
    solutions = _SOLUTIONS_EACH * (FEW_SOLUTIONS if wanted is None else wanted)
    invert = partial(tip.body.inverse, solver=checked_solver(solver), solutions=solutions)
    used: list[LinearSolver] = []

    def solvers(s2: float) -> LinearSolver:
        used[:] = [invert(s2)]  # the body finds the last one, as long as it is kept
        return used[0]

    static = static_mode(tip, invert=solvers)
    if wanted is None:
        m, k, shapes = _oscillators(tip, static, *_all_constraint_modes(tip))
    else:
        with bar(f"constraint modes of {dofs} dofs", unit="solution"):
            m, k, shapes = _wanted_oscillators(tip, static, wanted, by, solvers)
        if len(m) < wanted:
            warn(f"n={n}: only {len(m)} anti-oscillators carry mass at this contact")
    first = np.argsort(k / m if by == "frequency" else -m, kind="stable")[:wanted]
    m, k, shapes = m[first], k[first], shapes[:, first]
    if wanted is not None:
        warn_of_rounding(tip.body.K, shapes, f"{len(m)} anti-oscillators")
    residual = static.mass - math.fsum(m)  # eq. (10): what the oscillators do not hold
    if abs(residual) < _ROUNDING_OF_MASS * static.mass:
        residual = 0.0
    numbers = AOModel(m0=residual, k0=static.k0, m=m, k=k)
    return with_shapes(numbers, tip, static.phi, shapes, linear_solver=used[0].name if used else "")


def modal(tips: ContactPoint | Sequence[ContactPoint], n: int, *, solver: Solver = "auto") -> Body:
    """Return the classical modal truncation of a body: its `n` lowest natural modes.

    Parameters
    ----------
    tips : ContactPoint or sequence of ContactPoint
        Where it is touched, from `FEModel.contact`: one place, or several of one body.
    n : int
        Number of modes, rigid ones included, 1 … n_dofs.
    solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        The linear solver for what is too large for dense matrices; see `FEModel.inverse`.

    Returns
    -------
    Body

    Raises
    ------
    InputError
        If `n` is out of range, or there are fewer modes, the other motions having no mass; if the
        tips are not on one body, or act on dofs without mass.

    Warns
    -----
    AOImpactWarning
        If `n` takes in some of the rigid motions only.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> end, middle = (bar.contact(point=(x, 0.005, 0.01)) for x in (0.09, 0.05))
    >>> ao.modal(end, n=8).frequencies.shape
    (8,)
    >>> ao.modal([end, middle], n=8).participation.shape
    (2, 8)
    """
    ports = checked_ports("tips", tips)
    refuse_massless(ports)
    body = ports[0].body
    wanted = integer("n", n, low=1, high=body.n_dofs)
    invert = partial(body.inverse, solver=checked_solver(solver))
    rigid = body.rigid_modes.shape[1]
    if wanted < rigid:
        warn(
            f"n={n} takes in some of {rigid} rigid motions, and the force depends on which; take "
            f"n={rigid} or more"
        )
    omega2, modes = lowest(body.K, body.M, wanted, known=body.rigid_modes, invert=invert)
    warn_of_rounding(body.K, modes[:, rigid:], f"{len(omega2) - rigid} elastic modes")
    if len(omega2) < wanted:
        raise InputError(
            f"n must be at most {len(omega2)}, got {n}: the other motions have no mass"
        )
    found = of_modes(ports, omega2, modes, kind="modal")
    if len(ports) == 1:
        excited(found)  # or it is refused
    return found
