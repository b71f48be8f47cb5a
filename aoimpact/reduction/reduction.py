"""The constraint modes of a body and its anti-oscillators: eqs. (4)-(10) and (12) of the paper."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt
import scipy

from .. import _core
from ..base import (
    FloatArray,
    InputError,
    InputTypeError,
    SingularError,
    bar,
    choice,
    integer,
    warn,
)
from ..fem import ContactPoint, StaticMode, refuse_mechanism, static_mode
from ..linalg import (
    EQUAL,
    FEW_SOLUTIONS,
    Solver,
    SolverBook,
    checked_solver,
    dense_modes,
    lowest_sparse,
    shifted,
    warn_of_rounding,
)
from .krylov import KrylovSpace
from .origin import origin_of
from .star import AOModel

__all__ = ["antioscillators"]


# LAPACK on the whole pencil: a second up to here, minutes and gigabytes beyond there.
_DENSE_QUICK = 1500
_DENSE_MOST = 6000

# Solutions foreseen for each oscillator: on a beam, a plate and a block 5 to 300 were counted, the
# least for many in the order of their frequencies.
_SOLUTIONS_EACH = 20

# Slack of the masses in a proof.
_ROUNDING = 1e-12

# An oscillator with less than this share of the static mass carries none: it is rounding.
_NO_MASS = 1e-13

# Eigenvalues of LAPACK are known to the largest one's rounding times a modest number (LAPACK Users'
# Guide, 4.10).
_LOST = 10.0

# A residual mass of no more than this share of the static mass is none: the rounding of thousands
# of masses. A contact on a dof without mass has none.
_ROUNDING_OF_MASS = 1e-11


@dataclass(frozen=True, eq=False)
class _Oscillators:
    """Anti-oscillators found so far: frequencies, masses, stiffnesses, and shapes Ψ_i = c_i φ_i."""

    omega2: FloatArray
    m: FloatArray
    k: FloatArray
    shapes: FloatArray

    def take(self, which: npt.NDArray[np.intp]) -> _Oscillators:
        return _Oscillators(self.omega2[which], self.m[which], self.k[which], self.shapes[:, which])


def _oscillators(
    tip: ContactPoint, static: StaticMode, omega2: FloatArray, phi: FloatArray
) -> _Oscillators:
    """Eqs. (6), (9), (12) for M-orthonormal constraint modes; multiple ones are joined."""
    modal_mass = np.einsum("ij,ij->j", phi, tip.body.M @ phi)
    coupling = phi.T @ static.m_phi
    carries = coupling**2 > _least_share(omega2) * static.mass * modal_mass
    if (omega2[carries] <= 0.0).any():
        raise SingularError(
            "a constraint mode that carries mass has no stiffness: part of the body is a mechanism"
            ", or K is not positive semidefinite; see body.frequencies(10)"
        )
    omega2, phi = omega2[carries], phi[:, carries]
    c, m, k = (np.empty(len(omega2)) for _ in range(3))
    _core.oscillators_project(
        np.ascontiguousarray(phi.T), modal_mass[carries], omega2, static.m_phi, c, m, k
    )
    shapes = phi * c
    starts = np.flatnonzero(np.diff(omega2, prepend=-np.inf) > EQUAL * omega2)
    if len(starts) < len(omega2):
        m, k = np.add.reduceat(m, starts), np.add.reduceat(k, starts)
        shapes = np.add.reduceat(shapes, starts, axis=1)
        omega2 = k / m
    return _Oscillators(omega2, m, k, shapes)


def _least_share(omega2: FloatArray) -> FloatArray:
    """Of the static mass, what each of the modes must have to count as an oscillator.

    Eigenvalues are known to ε of the largest. A mode below that is a mixture: of the lowest mode
    above it has the part that first-order perturbation gives, that error over their distance.
    """
    lost = _LOST * np.finfo(float).eps * float(omega2.max(initial=0.0))
    above = omega2[omega2 > lost]
    mixed = lost / float(above.min()) if len(above) else 0.0
    return np.where(omega2 > lost, _NO_MASS, max(_NO_MASS, mixed**2))


def _all_oscillators(tip: ContactPoint, static: StaticMode) -> _Oscillators:
    return _oscillators(tip, static, *_all_constraint_modes(tip))


def _all_constraint_modes(tip: ContactPoint) -> tuple[FloatArray, FloatArray]:
    """By LAPACK: a reflection turns bᵀφ = 0 into "first entry zero".

    The dof that b moves most comes first: a reflection of one that b does not move loses its mass
    in the rounding of a far heavier one that b moves.
    """
    n = tip.body.n_dofs
    order, most = np.arange(n), int(np.argmax(np.abs(tip.b)))
    order[[0, most]] = most, 0
    h, work = np.empty(n), np.empty(n)
    _core.constraint_reflector(np.ascontiguousarray(tip.b[order]), h)
    pencil = []
    for matrix in (tip.body.K, tip.body.M):
        dense = np.ascontiguousarray(matrix.toarray()[np.ix_(order, order)])
        _core.constraint_congruence(h, dense, work)
        pencil.append(dense[1:, 1:])
    omega2, y = dense_modes(pencil[0], pencil[1])
    phi = np.vstack([np.zeros(y.shape[1]), y])
    phi -= np.outer(h, h @ phi)
    return omega2, phi[order]


def _lowest_oscillators(
    tip: ContactPoint, static: StaticMode, count: int, solvers: SolverBook
) -> _Oscillators:
    """The oscillators among the `count` lowest constraint modes, by shift-and-invert on bᵀφ = 0.

    The iteration starts from φ_st, so that of each multiple eigenvalue it meets the one mode that
    carries mass.
    """
    K, M, b = tip.body.K, tip.body.M, tip.b
    if tip.body.rigid_modes.shape[1] == 0:
        base = solvers(0.0)
    else:
        base = shifted(K, M, rigid=tip.body.rigid_modes, invert=solvers)
    z = base.solve(b)

    def inverse(f: FloatArray) -> FloatArray:
        x = np.ascontiguousarray(base.solve(f))
        _core.constraint_project(b, z, x)
        return x

    omega2, phi = lowest_sparse(
        M, inverse, base.s2, count, away_from=static.unobservable, start=static.phi
    )
    return _oscillators(tip, static, omega2, phi)


def _ordered(found: _Oscillators, order: str) -> _Oscillators:
    key = found.omega2 if order == "frequency" else -found.m
    return found.take(np.argsort(key, kind="stable"))


def _mass_of_all(tip: ContactPoint, static: StaticMode) -> float:
    """Σ m_i over all oscillators: m_st less the bare contact's 1/(bᵀM⁻¹b), kg.

    At infinite frequency the oscillators are at rest, and only m0 moves: 1/m0 = bᵀM⁻¹b. Where
    massless motions leave bᵀM⁻¹b undefined, m_st is a bound.
    """
    M, b = tip.body.M, tip.b
    diagonal = np.where(M.diagonal() > 0.0, M.diagonal(), 1.0)
    jacobi = scipy.sparse.linalg.LinearOperator(
        M.shape, matvec=lambda x: x / diagonal, dtype=np.float64
    )
    with np.errstate(all="ignore"):
        x, failed = scipy.sparse.linalg.cg(M, b, rtol=1e-10, maxiter=2000, M=jacobi)
        bare = math.nan if failed else float(1.0 / (b @ x))
    return static.mass - bare if 0.0 < bare < static.mass else static.mass


def _enough(found: _Oscillators, mass_of_all: float, n: int, order: str) -> bool:
    """Whether the first `n` of `found` (in order) are certainly the first `n` of all."""
    if len(found.m) < n:
        return False
    if order == "frequency" or n == 0:
        return True
    # What no mode found so far carries bounds the mass of each one not found.
    rest = mass_of_all - math.fsum(found.m) + _ROUNDING * mass_of_all
    return rest <= float(found.m[n - 1])


def _wanted_oscillators(
    tip: ContactPoint, static: StaticMode, n: int, order: str, solvers: SolverBook
) -> _Oscillators:
    dofs = tip.body.n_dofs
    small = dofs <= _DENSE_MOST
    most = dofs // 20 if small else max(64, 4 * n)
    count = max(2 * n, n + 8)
    bounded = order == "mass" and dofs > _DENSE_QUICK
    mass_of_all = _mass_of_all(tip, static) if bounded else static.mass
    while dofs > _DENSE_QUICK and count <= most:
        found = _ordered(_lowest_oscillators(tip, static, count, solvers), order)
        if _enough(found, mass_of_all, n, order):
            return found
        if count == most:
            break
        count = min(2 * count, most)
    if small:
        return _ordered(_all_oscillators(tip, static), order)
    rest = mass_of_all - math.fsum(found.m)
    warn(
        f"n={n}: among the {most} lowest constraint modes the first oscillators hold "
        f"{math.fsum(found.m) / static.mass:.2%} of the static mass; one above may hold up to "
        f"{rest:.3g} kg, more than the smallest of those returned; order='frequency' needs no such "
        "search"
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
        "eigen": the constraint modes of the paper, right at every time scale in the end. "krylov":
        those of the body projected on its static mode and the motions that an impact excites, of
        which few give the force; vibration long after it needs `duration`, and an oscillator or two
        for each natural mode in it.
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
    solvers = SolverBook(
        partial(tip.body.inverse, solver=checked_solver(solver), solutions=solutions)
    )
    static = static_mode(tip, invert=solvers)
    if wanted is None:
        found = _ordered(_all_oscillators(tip, static), by)
    else:
        with bar(f"constraint modes of {dofs} dofs", unit="solution"):
            found = _wanted_oscillators(tip, static, wanted, by, solvers)
        if len(found.m) < wanted:
            warn(f"n={n}: only {len(found.m)} anti-oscillators carry mass at this contact")
        found = found.take(np.arange(min(wanted, len(found.m))))
        warn_of_rounding(tip.body.K, found.shapes, f"{len(found.m)} anti-oscillators")
    return _model(tip, static, found, "AO", solvers.name)


def _model(
    tip: ContactPoint, static: StaticMode, found: _Oscillators, label: str, solver: str
) -> AOModel:
    """Put the star together; what its oscillators do not hold is the residual mass, eq. (10)."""
    residual = static.mass - math.fsum(found.m)
    if abs(residual) < _ROUNDING_OF_MASS * static.mass:
        residual = 0.0
    return AOModel(
        m0=residual,
        k0=static.k0,
        m=found.m,
        k=found.k,
        origin=origin_of(tip, static.phi, found.shapes, label, solver=solver),
        damping=tip.body.damping,
    )
