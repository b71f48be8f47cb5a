"""Reduction by eigenmodes: a body's natural modes, and its constraint modes, eqs. (4)-(12)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import scipy

from .. import _core
from ..base import (
    PRINTED,
    ROUNDING,
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
    DENSE_MOST,
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

# _MOST_STEPS: largest number of Lanczos steps. _CONVERGED: largest residual of a converged mode,
# relative to the eigenvalue.
_MOST_STEPS, _CONVERGED = 600, 1e-10

# Expected number of linear solutions per oscillator. On a beam, a plate and a block the number was
# 5 to 300, smallest if many oscillators are wanted in the order of frequency.
_SOLUTIONS_EACH = 20


# Function of s² that returns the linear solver of K + s²M.
Invert = Callable[[float], LinearSolver]

# Masses, stiffnesses, and shapes Ψ_i = c_i φ_i of anti-oscillators.
_Found = tuple[FloatArray, FloatArray, FloatArray]


def _oscillators(
    tip: ContactPoint, static: StaticMode, omega2: FloatArray, phi: FloatArray
) -> _Found:
    """Return oscillators, eqs. (6), (9), (12), from constraint modes in ascending frequency.

    Modes of equal frequency become one oscillator.
    """
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
    """Return all constraint modes by LAPACK, after a reflection that turns bᵀφ = 0 into φ₁ = 0.

    The dof with the largest entry of b comes first. Otherwise the mass of a dof with a zero entry
    may be lost in rounding errors of a far heavier dof.
    """
    n = tip.body.n_dofs
    order, most = np.arange(n), int(np.argmax(np.abs(tip.b)))
    order[[0, most]] = most, 0
    across = np.empty((n, n - 1))
    across[order] = np.linalg.qr(tip.b[order][:, None], mode="complete")[0][:, 1:]
    few = scipy.sparse.csr_array(across)  # b has few nonzero entries
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
    """Return the oscillators found, and an upper bound of the mass of one not found.

    Lanczos' method is applied in the space bᵀφ = 0, started from the projection of φ_st. The masses
    of its Ritz values are Gauss quadrature weights of the masses m_i over 1/(ω_i² + s²). Between
    two neighbouring Ritz values lies no more mass than these two have (Chebyshev, Markov and
    Stieltjes; Szegő, Orthogonal Polynomials, 3.41). For a multiple eigenvalue, only the mode with
    mass is found.
    """
    K, M, b = tip.body.K, tip.body.M, tip.b
    if tip.body.rigid_modes.shape[1] == 0:
        base = solvers(0.0)
    else:
        base = shifted(K, M, tip.body.rigid_modes, solvers)
    z, idle = base.solve(b), static.unobservable
    start = _across(tip, static)
    mass = float(start @ (M @ start))
    # A failed attempt at the heaviest takes a tenth of LAPACK's time for 2000 dofs or more.
    most = min(_MOST_STEPS, tip.body.n_dofs if order == "frequency" else 60 + tip.body.n_dofs // 12)
    basis = np.empty((most + 1, tip.body.n_dofs))
    basis[0] = start / math.sqrt(mass)
    diagonal, off, look = np.empty(most), np.empty(most), n
    for k in range(most):
        x = base.solve(M @ basis[k])
        for _ in range(2):  # cancellation spoils the first pass if the body is soft along b
            x -= (b @ x) / (b @ z) * z
        x -= idle @ (idle.T @ (M @ x))
        parts = basis[: k + 1] @ (M @ x)
        x -= parts @ basis[: k + 1]
        x -= (basis[: k + 1] @ (M @ x)) @ basis[: k + 1]  # second pass: removes rounding errors
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
        if order == "frequency":  # only modes below the first that has not converged
            found &= np.cumsum(~found) == 0
        chosen = np.flatnonzero(found & (masses > ROUNDING * static.mass))
        largest = float((left + np.append(left[1:], 0.0)).max())
        omega2 = 1.0 / theta[chosen] - base.s2
        # Due to rounding errors, several modes appear for a multiple eigenvalue; they are one
        # oscillator.
        enough = np.count_nonzero(np.diff(omega2, prepend=-np.inf) > PRINTED * omega2) >= n
        if enough and order == "mass" and n:
            enough = largest <= np.sort(masses[chosen])[-n]
        if enough or exhausted:
            largest = 0.0
            break
    phi = y[:, chosen].T @ basis[: k + 1]
    return _oscillators(tip, static, omega2, phi.T), largest


def _across(tip: ContactPoint, static: StaticMode) -> FloatArray:
    """Return the M-orthogonal projection of φ_st on bᵀx = 0, φ_st minus a multiple of M⁻¹ b."""
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
            with np.errstate(over="ignore", invalid="ignore"):  # overflow shows in the result
                found, left_out = _first_oscillators(tip, static, n, order, solvers)
        except ConvergenceError:
            if dofs > DENSE_MOST:
                raise
    if found is None or (left_out > 0.0 and dofs <= DENSE_MOST):
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
        Contact point, from `FEModel.contact`.
    n : int, optional
        Number of oscillators with mass; by default all ("eigen" only). The mass of the others
        stays in m0, eq. (10).
    method : {"eigen", "krylov"}
        For an impact take "krylov", with `contact_time`: 5 of its oscillators give the force on the
        beam of the paper to 0.5 %, where "eigen" needs 28. Its oscillators are those of the body
        projected on its static mode and the motions that an impact excites. Vibration long after
        the impact needs `duration`, and one or two oscillators for each natural mode that vibrates.
        "eigen" takes the constraint modes of the paper, which are not fitted to a time scale, and
        whose models converge on all time scales.
    order : {"mass", "frequency"}, optional
        Order of the oscillators, of which the first `n` are taken: by descending mass (default of
        "eigen"), or by ascending frequency (the only order of "krylov").
    contact_time : float, optional
        Approximate duration of the contact, s ("krylov" only); by default estimated, see
        `KrylovSpace`.
    duration : float, optional
        Duration for which the motion must be accurate, s, if much longer than the contact ("krylov"
        only).
    solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        The linear solver for bodies too large for dense matrices; see `FEModel.inverse`.

    Returns
    -------
    AOModel
        Model of `n` oscillators, or of fewer, with a warning, if b excites fewer.

    Raises
    ------
    InputError
        If `n` is not in 0 … n_dofs - 1, or is None for a body too large to compute all oscillators.
    SingularError
        If the contact moves part of the body as a mechanism. Any other mechanism is accepted in a
        free body; in a constrained body only if K need not be factorised.

    Warns
    -----
    AOImpactWarning
        If b excites fewer than `n` oscillators, or those found are not proven to be the heaviest.

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
    if wanted is None and dofs > DENSE_MOST:
        raise InputError(
            f"n=None asks for all {dofs - 1} anti-oscillators of a body of {dofs} dofs, which "
            f"needs dense matrices; give n (all are computed up to {DENSE_MOST} dofs)"
        )
    refuse_mechanism([tip])
    solutions = _SOLUTIONS_EACH * (FEW_SOLUTIONS if wanted is None else wanted)
    invert = partial(tip.body.inverse, solver=checked_solver(solver), solutions=solutions)
    used: list[LinearSolver] = []

    def solvers(s2: float) -> LinearSolver:
        used[:] = [invert(s2)]  # kept here, as the body refers to the solver weakly
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
    residual = static.mass - math.fsum(m)  # eq. (10)
    if abs(residual) < ROUNDING * (10 + len(m)) * static.mass:
        residual = 0.0  # as of a contact on a dof without mass
    numbers = AOModel(m0=residual, k0=static.k0, m=m, k=k)
    return with_shapes(numbers, tip, static.phi, shapes, linear_solver=used[0].name if used else "")


def modal(tips: ContactPoint | Sequence[ContactPoint], n: int, *, solver: Solver = "auto") -> Body:
    """Return the classical modal truncation of a body: its `n` lowest natural modes.

    Parameters
    ----------
    tips : ContactPoint or sequence of ContactPoint
        Contact points from `FEModel.contact`: one, or several of one body.
    n : int
        Number of modes, rigid motions included, 1 … n_dofs.
    solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        The linear solver for bodies too large for dense matrices; see `FEModel.inverse`.

    Returns
    -------
    Body

    Raises
    ------
    InputError
        If `n` is out of range or exceeds the number of modes with mass, or if the tips are on
        different bodies or act on dofs without mass.

    Warns
    -----
    AOImpactWarning
        If `n` is less than the number of rigid motions.

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
        excited(found)  # raises if no mode moves the contact
    return found
