"""From a finite-element body and a contact functional to its star: section 2 of the paper."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from . import _core
from .checks import choice, integer
from .contact import ContactPoint
from .errors import AOImpactWarning, InputError, InputTypeError, SingularError
from .solvers import factorize
from .spectra import DENSE_DOFS, lowest, lowest_sparse, shifted
from .star import AOModel, Origin

__all__ = ["ModalModel", "StaticMode", "antioscillators", "modal", "moves_rigidly", "static_mode"]

FloatArray = npt.NDArray[np.float64]

# LAPACK on the whole pencil beyond this takes minutes and gigabytes.
_DENSE_MOST = 6000

# An oscillator with less than this share of the static mass carries none: it is rounding.
_NO_MASS = 1e-13

# Constraint modes closer than this, relative, are one multiple eigenvalue.
_EQUAL = 1e-9


@dataclass(frozen=True, eq=False)
class StaticMode:
    """The static mode of a body at a contact functional, eqs. (1)-(3), (11).

    Attributes
    ----------
    phi : ndarray, shape (n_dofs,)
        φ_st with bᵀφ_st = 1.
    k0 : float
        φ_stᵀ K φ_st, N/m; exactly 0 where b moves the body rigidly.
    m_phi : ndarray, shape (n_dofs,)
        M φ_st.
    mass : float
        m_st = φ_stᵀ M φ_st, kg.
    silent : ndarray, shape (n_dofs, r)
        The M-orthonormal rigid motions that never feel the contact.
    """

    phi: FloatArray
    k0: float
    m_phi: FloatArray
    mass: float
    silent: FloatArray


def static_mode(tip: ContactPoint) -> StaticMode:
    """Return the static mode; for a body that b can move rigidly, that rigid motion.

    Raises
    ------
    SingularError
        If K is singular though the body has no rigid motion: a mechanism.
    """
    if not isinstance(tip, ContactPoint):
        raise InputTypeError(f"tip must come from FEModel.contact(...), got {tip!r}")
    rigid, b = tip.body.rigid_modes, tip.b
    reach = rigid.T @ b
    if moves_rigidly(tip):
        phi = np.empty_like(b)
        mass = _core.static_free(np.ascontiguousarray(rigid.T), b, phi)
        across = la.qr(reach[:, None])[0][:, 1:]
        return StaticMode(phi, 0.0, tip.body.M @ phi, mass, rigid @ across)
    phi = np.ascontiguousarray(_static_displacement(tip, rigid))
    k0 = _core.static_held(b, phi)
    m_phi = tip.body.M @ phi
    return StaticMode(phi, k0, m_phi, float(phi @ m_phi), rigid)


def moves_rigidly(tip: ContactPoint) -> bool:
    """Whether a force at the contact moves the body as a whole: seen from there it is free."""
    rigid = tip.body.rigid_modes
    reach = float(np.linalg.norm(rigid.T @ tip.b))
    return reach > 1e-10 * float(np.linalg.norm(tip.b) * np.linalg.norm(rigid))


def _static_displacement(tip: ContactPoint, rigid: FloatArray) -> FloatArray:
    """Return K⁻¹ b; where K has rigid modes that b does not move, the solution M-orthogonal to them."""
    K, M, b = tip.body.K, tip.body.M, tip.b
    if rigid.shape[1] == 0:
        try:
            return factorize(K, what="the stiffness matrix").solve(b)
        except SingularError as error:
            raise SingularError(
                f"{error}, though the body has no rigid motion left: part of it is a mechanism "
                "(a piece not connected, an element without stiffness); see body.frequencies(10)"
            ) from None
    base = shifted(K, M, rigid=rigid)
    x = np.zeros_like(b)
    for _ in range(100):  # the shift makes each pass gain a factor ω₁²/s²
        change = base.factors.solve(b - K @ x)
        change -= rigid @ (rigid.T @ (M @ change))
        x += change
        if np.linalg.norm(change) <= 1e-15 * np.linalg.norm(x):
            break
    return x


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
    """Eqs. (6), (9), (12) for M-orthonormal constraint modes; members of a multiple one are joined."""
    modal_mass = np.einsum("ij,ij->j", phi, tip.body.M @ phi)
    coupling = phi.T @ static.m_phi
    carries = coupling**2 > _NO_MASS * static.mass * modal_mass
    if (omega2[carries] <= 0.0).any():
        raise SingularError(
            "a constraint mode that carries mass has no stiffness: part of the body is a mechanism, "
            "or K is not positive semidefinite; see body.frequencies(10)"
        )
    omega2, phi = omega2[carries], phi[:, carries]
    c, m, k = (np.empty(len(omega2)) for _ in range(3))
    _core.oscillators_project(
        np.ascontiguousarray(phi.T), modal_mass[carries], omega2, static.m_phi, c, m, k
    )
    shapes = phi * c
    starts = np.flatnonzero(
        np.concatenate([[True], np.diff(omega2) > _EQUAL * omega2[1:]]) if len(omega2) else []
    )
    if len(starts) < len(omega2):
        m, k = np.add.reduceat(m, starts), np.add.reduceat(k, starts)
        shapes = np.add.reduceat(shapes, starts, axis=1)
        omega2 = k / m
    return _Oscillators(omega2, m, k, shapes)


def _all_oscillators(tip: ContactPoint, static: StaticMode) -> _Oscillators:
    """All constraint modes by LAPACK: a Householder reflection turns bᵀφ = 0 into "first entry 0"."""
    n = tip.body.n_dofs
    h, work = np.empty(n), np.empty(n)
    _core.constraint_reflector(tip.b, h)
    pencil = []
    for matrix in (tip.body.K, tip.body.M):
        dense = np.ascontiguousarray(matrix.toarray())
        _core.constraint_congruence(h, dense, work)
        pencil.append(dense[1:, 1:])
    omega2, y = la.eigh(pencil[0], pencil[1], overwrite_a=True, overwrite_b=True)
    phi = np.vstack([np.zeros(n - 1), y])
    phi -= np.outer(h, h @ phi)
    return _oscillators(tip, static, omega2, phi)


def _lowest_oscillators(tip: ContactPoint, static: StaticMode, count: int) -> _Oscillators:
    """The oscillators among the `count` lowest constraint modes, by shift-and-invert on bᵀφ = 0.

    The iteration starts from φ_st, so that of each multiple eigenvalue it meets the one mode that
    carries mass.
    """
    K, M, b = tip.body.K, tip.body.M, tip.b
    if tip.body.rigid_modes.shape[1] == 0:
        factors, s2 = factorize(K, what="the stiffness matrix"), 0.0
    else:
        base = shifted(K, M, rigid=tip.body.rigid_modes)
        factors, s2 = base.factors, base.s2
    z = factors.solve(b)

    def inverse(f: FloatArray) -> FloatArray:
        x = np.ascontiguousarray(factors.solve(f))
        _core.constraint_project(b, z, x)
        return x

    omega2, phi = lowest_sparse(M, inverse, s2, count, away_from=static.silent, start=static.phi)
    return _oscillators(tip, static, omega2, phi)


def _ordered(found: _Oscillators, order: str) -> _Oscillators:
    key = found.omega2 if order == "frequency" else -found.m
    return found.take(np.argsort(key, kind="stable"))


def _enough(found: _Oscillators, static: StaticMode, n: int, order: str) -> bool:
    """Whether the first `n` of `found` (in order) are certainly the first `n` of all."""
    if len(found.m) < n:
        return False
    if order == "frequency" or n == 0:
        return True
    # What no mode found so far carries bounds the mass of each one not found.
    return static.mass - math.fsum(found.m) <= float(found.m[n - 1])


def _wanted_oscillators(tip: ContactPoint, static: StaticMode, n: int, order: str) -> _Oscillators:
    dofs = tip.body.n_dofs
    small = dofs <= _DENSE_MOST
    most = dofs // 5 if small else max(256, 4 * n)
    count = max(2 * n, n + 8)
    while dofs > DENSE_DOFS and count <= most:
        found = _ordered(_lowest_oscillators(tip, static, count), order)
        if _enough(found, static, n, order):
            return found
        if count == most:
            break
        count = min(2 * count, most) if not small else 2 * count
    if small:
        return _ordered(_all_oscillators(tip, static), order)
    rest = static.mass - math.fsum(found.m)
    warnings.warn(
        f"n={n}: among the {most} lowest constraint modes the first oscillators hold "
        f"{1.0 - rest / static.mass:.2%} of the static mass; one above may hold up to {rest:.3g} kg, "
        f"more than the smallest of those returned. order='frequency' needs no such search",
        AOImpactWarning,
        stacklevel=3,
    )
    return found


def antioscillators(
    tip: ContactPoint, n: int | None = None, *, method: str = "eigen", order: str | None = None
) -> AOModel:
    """Return the anti-oscillator model of a body at its contact, eqs. (1)-(12).

    Parameters
    ----------
    tip : ContactPoint
        From `FEModel.contact`.
    n : int, optional
        How many oscillators that carry mass; all of them if not given. The others' mass stays in
        m0, eq. (10).
    method : {"eigen"}
        "eigen": the constraint modes of the paper.
    order : {"mass", "frequency"}, optional
        Which come first: those of the largest mass (default) or of the lowest frequency.

    Returns
    -------
    AOModel
        With fewer than `n` oscillators, and a warning, if b excites fewer.

    Raises
    ------
    InputError
        If `n` is not in 0 … n_dofs - 1, or None on a body too large for all of them.
    SingularError
        If part of the body is a mechanism.
    """
    static = static_mode(tip)
    choice("method", method, ("eigen",))
    by = choice("order", "mass" if order is None else order, ("mass", "frequency"))
    dofs = tip.body.n_dofs
    if n is None and dofs > _DENSE_MOST:
        raise InputError(
            f"n=None asks for all {dofs - 1} anti-oscillators of a body of {dofs} dofs, which needs "
            f"dense matrices; give n (all are computed up to {_DENSE_MOST} dofs)"
        )
    if n is None:
        found = _ordered(_all_oscillators(tip, static), by)
    else:
        found = _wanted_oscillators(tip, static, integer("n", n, low=0, high=dofs - 1), by)
        if len(found.m) < n:
            warnings.warn(
                f"n={n}: only {len(found.m)} anti-oscillators carry mass at this contact",
                AOImpactWarning,
                stacklevel=2,
            )
        found = found.take(np.arange(min(n, len(found.m))))
    return _model(tip, static, found, "AO")


def _model(tip: ContactPoint, static: StaticMode, found: _Oscillators, label: str) -> AOModel:
    """Put the star together; what its oscillators do not hold is the residual mass, eq. (10)."""
    residual = static.mass - math.fsum(found.m)
    if residual < 0.0 and residual > -1e-11 * static.mass:
        residual = 0.0
    return AOModel(
        m0=residual,
        k0=static.k0,
        m=found.m,
        k=found.k,
        origin=_origin(tip, static, found.shapes, label),
    )


def _origin(tip: ContactPoint, static: StaticMode, shapes: FloatArray, label: str) -> Origin:
    body = tip.body
    if tip.direction is None or body.mass is None:
        # Without nodes the mean over the static mode stands for the centre of mass.
        return Origin(label, tip, static.phi, shapes, static.m_phi / static.mass, static.mass)
    centre = body.com_functional(tip.direction)
    return Origin(label, tip, static.phi, shapes, centre, body.mass)


@dataclass(frozen=True, eq=False)
class ModalModel:
    """The first natural modes of a body: the classical truncated model.

    Attributes
    ----------
    tip : ContactPoint
    omega2 : ndarray, shape (n,)
        ω², (rad/s)², ascending; zero for rigid modes.
    modes : ndarray, shape (n_dofs, n)
        M-orthonormal.
    """

    tip: ContactPoint
    omega2: FloatArray
    modes: FloatArray

    def __repr__(self) -> str:
        return f"ModalModel(n={self.n}, tip={self.tip!r})"

    @property
    def n(self) -> int:
        """Number of modes, rigid ones included."""
        return len(self.omega2)

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies, Hz, ascending, shape (n,)."""
        return np.sqrt(self.omega2) / (2.0 * np.pi)

    @property
    def participation(self) -> FloatArray:
        """r_j = bᵀφ_j, 1/√kg, shape (n,)."""
        result: FloatArray = self.modes.T @ self.tip.b
        return result

    def truncated(self, n: int) -> ModalModel:
        """Return the model of the first `n` modes."""
        kept = integer("n", n, low=1, high=self.n)
        return ModalModel(self.tip, self.omega2[:kept], self.modes[:, :kept])

    @cached_property
    def star(self) -> AOModel:
        """The same model as a star: its antiresonances by the secular equation.

        Modes of one frequency act as one; those that b does not excite are left out. The result is
        exact: both have the same receptance Σ r_j²/(ω_j² - ω²).
        """
        weight = self.participation**2
        excited = weight > 1e-14 * weight.sum()
        if not excited.any():
            raise InputError(f"none of the {self.n} modes moves the contact: take more modes")
        omega2, weight = self.omega2[excited], weight[excited]
        shapes = self.modes[:, excited] * self.participation[excited]
        new = np.diff(omega2) > _EQUAL * omega2[1:]
        starts = np.flatnonzero(np.concatenate([[True], new]))
        weight = np.add.reduceat(weight, starts)
        return self._star(omega2[starts], weight, np.add.reduceat(shapes, starts, axis=1))

    def _star(self, omega2: FloatArray, weight: FloatArray, r_phi: FloatArray) -> AOModel:
        """Star of distinct modes; column j of `r_phi` is r_j φ_j."""
        m, k = np.empty(len(omega2) - 1), np.empty(len(omega2) - 1)
        m0, k0 = _core.star_from_modal(omega2, weight, m, k)
        kept = m > _NO_MASS * (m0 + m.sum())
        m, k = m[kept], k[kept]
        # In modal coordinates φ_st is r_j k0/ω_j² (or the rigid mode), Ψ_i is r_j k_i/(ω_j² - ω_i²).
        static = r_phi @ (k0 / omega2) if k0 > 0.0 else r_phi[:, 0] / weight[0]
        shapes = r_phi @ -(k / np.subtract.outer(omega2, k / m))
        mass = m0 + math.fsum(m)
        phi = StaticMode(static, k0, self.tip.body.M @ static, mass, np.empty((len(static), 0)))
        origin = _origin(self.tip, phi, shapes, "modal")
        return AOModel(m0=m0, k0=k0, m=m, k=k, origin=origin)


def modal(tip: ContactPoint, n: int) -> ModalModel:
    """Return the classical modal truncation of a body: its `n` lowest natural modes.

    Parameters
    ----------
    tip : ContactPoint
    n : int
        Number of modes, rigid ones included, 1 … n_dofs.

    Raises
    ------
    InputError
        If `n` is out of range.
    """
    if not isinstance(tip, ContactPoint):
        raise InputTypeError(f"tip must come from FEModel.contact(...), got {tip!r}")
    wanted = integer("n", n, low=1, high=tip.body.n_dofs)
    omega2, modes = lowest(tip.body.K, tip.body.M, wanted, known=tip.body.rigid_modes)
    return ModalModel(tip, omega2, modes)
