"""Frequency response functions: displacement, velocity or acceleration per unit force.

The displacement cᵀX under a unit force along b, with b_j = φ_jᵀb and c_j = φ_jᵀc, is

    H(ω) = Σ_j c_j b_j / (ω_j² - ω² + 2iσ_jω).

The modes j ≤ m reach well above the requested frequencies. All others are summed as a power series
of static solutions (M. A. Akgün, *J. Sound Vib.* 167, 289, 1993; the first term is the residual
flexibility),

    Σ_{j>m} c_j b_j / (ω_j² - μ) = Σ_k μᵏ S_k,

with S_k = cᵀ(K⁻¹M)ᵏ K⁻¹ b minus the contribution of the modes j ≤ m. Rayleigh's damping gives
μ = (ω² - iαω)/(1 + iβω) and divides the sum by 1 + iβω.

The error is bounded by the sum of three terms.

- Truncation after p terms leaves at most rᵖ/(1 - r) · √(bᵀX_b cᵀX_c), by Cauchy and Schwarz, with
  r = |μ|/ω_{m+1}² and the static residuals X. The neglect of modal damping in the series is bounded
  in the same way.
- Rounding of ω_j² is that of φ_jᵀKφ_j, growing as √k with k entries per row; rigid modes have none.
- Far above the highest mode, the modal terms nearly cancel. If E = ΦᵀMΦ - I is the modes' error of
  orthogonality, the sum is wrong by up to ω² ‖E‖ ‖b_j g_j‖ ‖c_j g_j‖ with g_j = 1/(ω_j² - ω²).

A few frequencies above many modes are solved directly, after the rigid-body part is separated. The
error of cᵀX is then yᵀr, with the residual r and the response y to c.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import (
    HUGE,
    ROUNDING,
    ComplexArray,
    FloatArray,
    Frozen,
    InputError,
    InputTypeError,
    choice,
    finite_array,
    given_axes,
    in_batches,
)
from ..linalg import DENSE_DOFS, lowest
from .damping import Damping, ModalDamping, Rayleigh
from .model import FEModel
from .statics import displacement

if TYPE_CHECKING:
    from matplotlib.axes import Axes


KINDS = {"receptance": "m/N", "mobility": "m/(s N)", "accelerance": "m/(s² N)"}

# `_BEYOND`: least ratio of the highest modal frequency to the highest requested frequency.
# `_BEYOND_DAMPED`: this ratio with modal damping ζ, whose neglect in the series causes an error of
# 2ζ/10 of the static residual.
_BEYOND, _BEYOND_DAMPED = 2.0, 10.0

# Number of modes that take about as long as the direct solution at one frequency.
_FOR_EACH = 16


@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponse(Frozen):
    """A frequency response function of a body.

    Attributes
    ----------
    frequencies : ndarray, shape (n,)
        Frequencies, Hz.
    values : ndarray of complex, shape (n,)
        Ratio of response to force for e^{iωt}, in the unit of `kind`.
    error : ndarray, shape (n,)
        Bound of |values - exact|, in the unit of the values. The exact values are those of the
        given K and M: the discretisation error of the mesh is not included.
    kind : str
        "receptance" (displacement, m/N), "mobility" (velocity) or "accelerance" (acceleration).
    modes : int
        Number of natural modes used; 0 for direct solutions and for measurements.
    """

    frequencies: FloatArray
    values: ComplexArray
    error: FloatArray
    kind: str
    modes: int = 0

    def __repr__(self) -> str:
        low, high = self.frequencies.min(), self.frequencies.max()
        modes = f", {self.modes} modes" if self.modes else ""
        return (
            f"{type(self).__name__}({self.kind}, {len(self.frequencies)} frequencies from "
            f"{low:.4g} to {high:.4g} Hz{modes})"
        )

    def plot(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the magnitude against frequency; keywords go to ``Axes.semilogy``.

        Examples
        --------
        >>> K, M = np.array([[2e6, -1e6], [-1e6, 1e6]]), np.diag([0.5, 0.5])
        >>> chain = ao.FEModel(K=K, M=M, damping=ao.ModalDamping(0.01))
        >>> end = chain.contact(dof=1)
        >>> ax = chain.frf(excitation=end, frequencies=np.linspace(1, 500, 100)).plot()
        """
        ax = given_axes(ax)
        ax.semilogy(self.frequencies, np.abs(self.values), **kwargs)
        ax.set(xlabel="frequency [Hz]", ylabel=f"{self.kind} [{KINDS[self.kind]}]")
        return ax


def frequency_response(
    body: FEModel, excitation: Any, response: Any, frequencies: Any, kind: str
) -> FrequencyResponse:
    """Return a frequency response function; see `FEModel.frf`."""
    other = excitation if response is None else response
    for name, point in (("excitation", excitation), ("response", other)):
        if getattr(point, "body", None) is not body:
            kind_of = InputError if hasattr(point, "body") else InputTypeError
            raise kind_of(f"{name} must come from this body's contact(...), got {point!r}")
    b, c = excitation.b, other.b
    hertz = np.atleast_1d(finite_array("frequencies", frequencies, unit="Hz", most=HUGE))
    if hertz.ndim != 1 or not hertz.size or hertz.min() < 0.0:
        raise InputError(f"frequencies must be a list, none negative, got {frequencies!r}")
    if hertz.min() == 0.0 and body.rigid_modes.shape[1]:
        raise InputError("frequencies: a free body has no response at 0 Hz; give some above 0")
    of = choice("kind", kind, tuple(KINDS))
    omega = 2.0 * math.pi * hertz
    mu, _ = _without_damping(body.damping, omega)
    direct = not isinstance(body.damping, ModalDamping)
    most = _FOR_EACH * len(hertz) if direct else body.n_dofs
    modes = _modes(body, math.sqrt(float(np.abs(mu).max())), most)
    if modes is None:
        values, error = _solved(body, b, c, omega)
    else:
        values, error = _by_modes(body, modes, b, c, omega)
    if not np.isfinite(values).all():
        at = hertz[~np.isfinite(values)][0]
        raise InputError(f"frequencies: {at:g} Hz is an undamped natural frequency; take others")
    factor = (1j * omega) ** list(KINDS).index(of)  # index in KINDS: number of time derivatives
    taken = 0 if modes is None else len(modes[0])
    return FrequencyResponse(hertz, factor * values, np.abs(factor) * error, of, taken)


def _solved(
    body: FEModel, b: FloatArray, c: FloatArray, omega: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Return the receptance and its error, m/N, from a complex factorisation at each frequency."""
    from scipy.sparse.linalg import splu  # slow to import

    values, error = np.empty(len(omega), dtype=np.complex128), np.empty(len(omega))
    mu, stiffer = _without_damping(body.damping, omega)
    rigid, moved = body.rigid_modes, body.M @ body.rigid_modes
    whole = float((rigid.T @ c) @ (rigid.T @ b))
    load, seen = (of - moved @ (rigid.T @ of) for of in (b, c))
    for i, (shift, scale) in enumerate(zip(mu, stiffer, strict=True)):
        matrix = (scale * (body.K - shift * body.M)).tocsc()
        options = {"SymmetricMode": True}
        lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options=options)
        x, y = (
            found - rigid @ (moved.T @ found) for found in map(lu.solve, (load + 0j, seen + 0j))
        )
        values[i] = seen @ x - (whole / (scale * shift) if rigid.size else 0.0)
        rounding = np.finfo(float).eps * (np.abs(load) + abs(matrix) @ np.abs(x))
        error[i] = np.abs(y) @ (np.abs(load - matrix @ x) + rounding)
        error[i] += np.finfo(float).eps * abs(values[i])
    return values, error


def _without_damping(
    damping: Damping | None, omega: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return μ and 1 + iωβ so that K - ω²M + iω(αM + βK) = (1 + iωβ)(K - μM)."""
    alpha, beta = (damping.alpha, damping.beta) if isinstance(damping, Rayleigh) else (0.0, 0.0)
    stiffer = 1.0 + 1j * beta * omega
    mu = np.asarray((omega**2 - 1j * alpha * omega) / stiffer, dtype=np.complex128)
    return mu, np.asarray(stiffer, dtype=np.complex128)


def _modes(body: FEModel, highest: float, most: int) -> tuple[FloatArray, FloatArray, float] | None:
    """Return the modes up to well above √|μ| = `highest`, rad/s, where the series converges.

    The result consists of angular frequencies, rad/s, mode shapes, and a lower bound of the angular
    frequencies of all other modes, rad/s. It is None if more than `most` modes would be needed.
    """
    beyond = _BEYOND_DAMPED if isinstance(body.damping, ModalDamping) else _BEYOND
    dofs, rigid = body.n_dofs, body.rigid_modes
    count = dofs if dofs <= DENSE_DOFS else min(dofs, rigid.shape[1] + _FOR_EACH)
    while count == dofs or count <= max(most, rigid.shape[1] + _FOR_EACH):
        omega2, shapes = lowest(body.K, body.M, count, known=rigid, invert=body.inverse)
        omega = np.sqrt(omega2)
        if len(omega) < count or count == dofs:
            return omega, shapes, math.inf
        if omega[-1] > beyond * highest:
            # The last computed mode is not used: its frequency is a lower bound of the frequencies
            # of all other modes.
            return omega[:-1], shapes[:, :-1], float(omega[-1])
        count = dofs if 10 * count > dofs else 2 * count
    return None


def _by_modes(
    body: FEModel,
    modes: tuple[FloatArray, FloatArray, float],
    b: FloatArray,
    c: FloatArray,
    omega: FloatArray,
) -> tuple[ComplexArray, FloatArray]:
    """Return the receptance by modes and series, and a bound of its error, m/N, each (n,)."""
    (natural, shapes, above), damping = modes, body.damping
    moved = body.M @ shapes

    def static(load: FloatArray) -> FloatArray:
        """Return K⁻¹ times a load, minus the contribution of the computed modes, (n_dofs,)."""
        rest = load - moved @ (shapes.T @ load)
        if not np.abs(rest).max(initial=0.0) > 1e-12 * np.abs(load).max(initial=0.0):
            return np.zeros_like(load)
        found = displacement(body, rest, body.inverse)
        return np.asarray(found - shapes @ (moved.T @ found))

    product = shapes.T @ moved
    eps = float(np.finfo(float).eps)
    skew = float(np.linalg.norm(product - np.eye(len(product)))) + eps
    sizes, row = np.abs(shapes), float(np.diff(body.K.indptr).max(initial=1))
    rounding = math.sqrt(row) * eps * np.einsum("ij,ij->j", sizes, abs(body.K) @ sizes)
    rounding[natural == 0.0] = 0.0
    of_force, of_response = shapes.T @ b, shapes.T @ c
    seen = of_force * of_response != 0.0  # other modes contribute nothing, even at resonance
    own, weight = natural[seen], (of_force * of_response)[seen]
    decay = np.zeros_like(own) if damping is None else damping.decay(own)
    squares = np.stack(
        [np.abs(weight) * rounding[seen], of_force[seen] ** 2, of_response[seen] ** 2]
    )
    found, error = np.empty(len(omega), dtype=np.complex128), np.empty(len(omega))
    for some in in_batches(len(omega), 16.0 * max(len(own), 1)):
        of = omega[some, None]
        with np.errstate(divide="ignore", invalid="ignore"):  # undamped resonance is refused later
            gain = 1.0 / (own**2 - of**2 + 2j * decay * of)
            found[some] = gain @ weight
            sharp, force, response = squares @ np.abs(gain.T) ** 2
            error[some] = sharp + skew * of[:, 0] ** 2 * np.sqrt(force * response)
    mu, stiffer = _without_damping(damping, omega)
    ratio = np.abs(mu) / above**2
    residual = static(b)
    other = residual if c is b else static(c)
    size = math.sqrt(abs(float(b @ residual)) * abs(float(c @ other)))
    terms, largest = 1, float(ratio.max())
    if largest > 0.0:
        terms = max(1, math.ceil(math.log(ROUNDING) / math.log(largest)))
    power = np.ones_like(mu)
    for _ in range(terms):
        found = found + power * (c @ residual) / stiffer
        residual, power = static(body.M @ residual), power * mu
    error = error + size * ratio**terms / (1.0 - ratio)
    if isinstance(damping, ModalDamping):
        error = error + size * 2.0 * damping.ratio * np.sqrt(ratio) / (1.0 - ratio) ** 2
    return found, error
