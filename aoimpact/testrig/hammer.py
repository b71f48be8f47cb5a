"""Frequency response functions from the signals of an impact hammer test.

With F and A the Fourier transforms of force and acceleration, and sums over the hits, the
accelerance is H1 = Σ F*A / Σ|F|² or H2 = Σ|A|² / Σ A*F, and the coherence is H1/H2 (ISO 7626-5;
J. S. Bendat, A. G. Piersol, *Random Data*, chapters 6 and 9). A measured velocity v gives A without
differentiation:

    A(ω) = ∫ v' e^{-iωt} dt = iω ∫ v e^{-iωt} dt + v(T) e^{-iωT}.

The last term is nonzero for a free body, which still moves when the record ends at T. By summation
by parts, both terms together are the transform of the differences of v.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base import ComplexArray, FloatArray, InputError, choice, instance, warn, with_unit
from ..fem import FrequencyResponse
from ..fields import Probe
from ..results import Run
from .signal import RISEN, UNEVEN, Signal, contacts, force_at

# For each kind of response, the power of iω by which the accelerance is divided.
_KINDS = {"accelerance": 0, "mobility": 1, "receptance": 2}

# Smallest ratio of the force spectrum to its maximum in the excited range of frequencies: usually
# -10 to -20 dB.
_EXCITED = 0.1

# Ratio of the contributions of a record's second half and of the whole record at a resonance, if
# the vibration decays by the factor q = 1/2 in each half: q (1 - q)/(1 - q²).
_SECOND_HALF = 1.0 / 3.0

# Probability that the error due to noise exceeds its bound: one minus the confidence level.
_OUTSIDE = 0.05


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class MeasuredResponse(FrequencyResponse):
    """A frequency response function from measured or simulated hits; see `frf`.

    Attributes
    ----------
    frequencies : ndarray, shape (n,)
        Frequencies, Hz: multiples of 1 / (length of the record), up to half of the sampling rate.
    values : ndarray of complex, shape (n,)
        Ratio of response to force, as given by `kind`, for the time factor e^{iωt}.
    error : ndarray, shape (n,)
        Estimated error of the values, in their unit; infinite above a quarter of the sampling rate.
    kind : str
        "accelerance" (m/(s² N)), "mobility" (m/(s N)) or "receptance" (m/N).
    coherence : ndarray, shape (n,)
        Coherence of force and response; 1 if all hits agree, and for a single hit.
    force : ndarray, shape (n,)
        Spectrum of the force, root mean square over the hits, N s. Where it is less than a tenth of
        its maximum, `values` are mostly noise.
    """

    coherence: FloatArray
    force: FloatArray


def frf(
    force: Any, response: Any, *, kind: str = "accelerance", estimator: str = "H1"
) -> MeasuredResponse:
    """Return the frequency response function of an impact hammer test, measured or simulated.

    Parameters
    ----------
    force : Signal, Result or Run; or a list of them, one for each hit
        The hammer's force, N. The force of a result is taken at the times of the response; for a
        scene's run, it is that of the first contact.
    response : Signal or Probe; or a list of them, one for each hit
        Velocity (unit "m/s") or acceleration (unit "m/s²") of the measured point, at rest before
        the hit, at the same even times as the force. The mean of a velocity before the force rises
        is subtracted from it. A probe along a direction gives its velocity.
    kind : {"accelerance", "mobility", "receptance"}, optional
        Ratio of acceleration, velocity or displacement to force.
    estimator : {"H1", "H2"}, optional
        H1 averages out noise of the response, H2 noise of the force. For one hit both are A/F.

    Returns
    -------
    MeasuredResponse
        Its ``error`` is the sum of four parts: the contribution of the second half of the record,
        which exceeds that of the time after the record if the vibration at least halves in the
        second half; the difference between the results from every second sample and from all
        samples; the error of a probe's model, estimated by a finer model; and, for several hits,
        the bound of the error due to their scatter, with 95 % confidence if the noise is in the
        response.

    Raises
    ------
    InputError, InputTypeError
        If force and response are not sampled at the same even times or differ in number, or a
        record ends in contact.

    Warns
    -----
    AOImpactWarning
        If a hammer struck more than once, or the vibration lasts too long for the record.

    Examples
    --------
    A free mass of 2 kg:

    >>> import numpy as np
    >>> t = np.arange(2000) / 20e3
    >>> pulse = np.where(t < 1e-3, 100.0 * np.sin(np.pi * t / 1e-3) ** 2, 0.0)
    >>> speed = np.cumsum(pulse) / 20e3 / 2.0
    >>> found = frf(Signal(t, pulse), Signal(t, speed, unit="m/s", name="velocity"))
    >>> round(float(np.abs(found.values[0])), 4)  # 1/kg
    0.5
    """
    power = _KINDS[choice("kind", kind, tuple(_KINDS))]
    which = ("H1", "H2").index(choice("estimator", estimator, ("H1", "H2")))
    hits = _hits(force, response)
    motion = hits[0][1]
    velocity, step, samples = motion.unit == "m/s", 1.0 / motion.rate, len(motion.t)
    rows = [[load.values, motion.values, lack] for load, motion, lack in hits]
    struck, moved, doubt = np.swapaxes(rows, 0, 1)
    count = samples + samples % 2  # even: every second sample gives the same frequencies
    f = np.arange(1, count // 2 + 1) / (count * step)

    loaded, answered = _spectra(struck, step, count), _spectra(moved, step, count, velocity)
    stopped = moved.copy()
    stopped[:, samples // 2 :] = moved[:, [samples // 2]] if velocity else 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        both = _estimates(loaded, answered)
        values, coherence = both[which], np.minimum(np.abs(both[0] / both[1]), 1.0)
        shorter = _estimates(loaded, _spectra(stopped, step, count, velocity))[which]
        coarser = np.full_like(values, np.inf)
        coarser[: count // 4] = _estimates(
            _spectra(struck[:, ::2], 2.0 * step, count // 2),
            _spectra(moved[:, ::2], 2.0 * step, count // 2, velocity),
        )[which]
        rest = np.abs(values - shorter)
        lacking = _estimates(loaded, _spectra(doubt, step, count, velocity))[0]
        error = rest + np.abs(values - coarser) + np.abs(lacking)
        if len(hits) > 1:
            # The ratio of |error|² to (1/γ² - 1)|H|²/(n - 1) has the F distribution of 2 and
            # 2(n - 1) degrees of freedom; `quantile` is its 95 % quantile divided by n - 1.
            quantile = _OUTSIDE ** (-1.0 / (len(hits) - 1)) - 1.0
            error += np.abs(values) * np.sqrt(quantile * (1.0 / coherence - 1.0))

    strength = np.sqrt(np.mean(np.abs(loaded) ** 2, axis=0))
    shown = np.where(strength > _EXCITED * strength.max(), np.abs(values), 0.0)
    late = (shown > _EXCITED * shown.max()) & (rest > _SECOND_HALF * shown)
    if late.any():
        warn(
            f"the record of {with_unit(samples * step, 's')} is too short: at {f[late][0]:.4g} Hz "
            "the vibration does not halve in its second half. Record for longer"
        )
    scale = (2j * np.pi * f) ** power
    return MeasuredResponse(
        f, values / scale, error / np.abs(scale), kind, coherence=coherence, force=strength
    )


def _hits(force: Any, response: Any) -> list[tuple[Signal, Signal, FloatArray]]:
    """Return force, motion and error of the motion for each hit, at equal times since its start.

    The error of a simulated motion (`Probe`) is known; a measured motion (`Signal`) has error 0.
    """
    forces, responses = (of if isinstance(of, list) else [of] for of in (force, response))
    if len(forces) != len(responses) or not forces:
        raise InputError(
            "force and response must have one entry for each hit, got "
            f"{len(forces)} and {len(responses)}"
        )
    hits: list[tuple[Signal, Signal, FloatArray]] = []
    for hit, (struck, moved) in enumerate(zip(forces, responses, strict=True)):
        instance("force", struck, Signal, Run)
        instance("response", moved, Signal, Probe)
        motion, lack = moved, np.zeros(len(moved.t))
        if isinstance(moved, Probe):
            motion, lack = Signal(moved.t, moved.velocity, "m/s", "velocity"), moved.doubt
        load = struck
        if isinstance(struck, Run):
            load = Signal(motion.t, force_at(struck, 0, motion.t))
        first, start = hits[0][1] if hits else motion, motion.t[0]
        known = load.unit == "N" and motion.unit in ("m/s", "m/s²")
        if not known or motion.unit != first.unit:
            raise InputError(
                f"force and response of hit {hit} must be in N, and m/s or m/s² as of all hits, "
                f"got {load.unit} and {motion.unit}; give Signal(t, values, unit='m/s')"
            )
        # Hits may begin at any time; force and response of one hit begin together.
        wanted = first.t - first.t[0]
        for name, times in (("response", motion.t - start), ("force", load.t - start)):
            if len(times) != len(wanted) or np.abs(times - wanted).max() * first.rate > UNEVEN:
                raise InputError(f"{name} of hit {hit} must have the times of the other signals")
        touched = contacts(load, f"force of hit {hit}")
        if load.values[-1] > RISEN * load.values.max():
            raise InputError(f"force of hit {hit}: the record ends in contact; give a longer one")
        if moved is motion and motion.unit == "m/s" and (before := touched[0][0]):
            motion = replace(motion, values=motion.values - motion.values[:before].mean())
        if len(touched) > 1:
            last = with_unit(float(load.t[touched[-1][0]]), "s")
            warn(
                f"hit {hit}: the hammer struck {len(touched)} times, last at {last}. Its force has "
                "gaps in its spectrum: strike again, with a lighter hammer or a softer tip"
            )
        hits.append((load, motion, lack))
    return hits


def _spectra(values: FloatArray, step: float, count: int, velocity: bool = False) -> ComplexArray:
    """Return Fourier transforms of rows of samples at k/(count step), k from 1 to count/2.

    For velocities, return the transforms of the accelerations. Velocities need not be 0 at the end.
    """
    if not velocity:
        return step * np.fft.rfft(values, count)[:, 1:]
    turns = np.arange(1, count // 2 + 1) / count
    # The motion before the first sample is 0: due to residual compliance, a model may move at once.
    steps = np.fft.rfft(np.diff(values, prepend=0.0), count)[:, 1:]
    # Division by sinc gives iω times the transform of the sampled velocity. Sampling then affects
    # force and response alike.
    return np.asarray(np.exp(1j * np.pi * turns) / np.sinc(turns) * steps)


def _estimates(loaded: ComplexArray, moved: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the estimates H1 and H2 from the spectra of all hits, shape (hits, n)."""
    both = np.sum(loaded.conj() * moved, axis=0)
    force, motion = (np.sum(np.abs(of) ** 2, axis=0) for of in (loaded, moved))
    return both / force, motion / both.conj()
