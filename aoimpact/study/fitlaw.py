"""Fit of a contact law to a measurement, with the uncertainty of its parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..accuracy import shared_models
from ..base import (
    HUGE,
    PRINTED,
    AOImpactError,
    ArrayPair,
    FloatArray,
    Frozen,
    InputError,
    InputTypeError,
    finite_array,
    held_warnings,
    positive,
    texts,
    warn,
    with_unit,
)
from ..impact import simulate
from ..integrate import Adaptive
from ..laws import ContactLaw
from ..reduction import rigid
from ..testrig import Signal

# Time integration with a tolerance far below measurement noise and errors of finite differences.
_SOLVER = Adaptive(rtol=1e-9)

# Largest relative standard error with which a parameter counts as determined.
_DETERMINED = 0.5

# First guess of a parameter if only the class of a law is given. _GUESSES: by the parameter's unit,
# the factor c and exponents of the guess c F^i δ^j v^k, with largest force F, largest indentation δ
# and velocity v. _NAMED: guess by the parameter's name.
_GUESSES: dict[str, tuple[float, float, float, float]] = {
    "N": (0.3, 1.0, 0.0, 0.0),
    "m": (0.3, 0.0, 1.0, 0.0),
    "s": (0.2, 0.0, 1.0, -1.0),
    "s/m": (0.2, 0.0, 0.0, -1.0),
    "N s/m": (0.2, 1.0, 0.0, -1.0),
}
_OF_THE_TEST = ("relative_radius", "mass", "velocity")
_NAMED = {"n": 1.5, "restitution": 0.7, "alpha": 0.1, "beta": 0.1}
_BOUNDS = {"n": (1.0, math.inf), "restitution": (0.0, 1.0), "beta": (0.0, 1.0)}

# Largest ratio of a parameter to its first guess, or of the guess to the parameter: beyond this
# ratio, the smaller is a rounding error of the larger.
_RANGE = 1.0 / np.finfo(float).eps

# _FOOT: largest ratio of the force at the start of a contact to the peak force. _EARLY: share of
# the largest indentation at which only a force with an initial jump exceeds _FOOT. _RISE: time from
# start to peak force with Hertz's law, in units of δ/v.
_FOOT, _EARLY, _RISE = 0.05, 0.01, 1.47

# Search for the start of a force with an initial jump. _SAMPLES: number of samples before and after
# the estimated start that bound the search. _APART: smallest distance between the start and a
# sample, in units of the samples' spacing.
_SAMPLES = 4
_APART = 1e-3

# A residual above _OFF times the noise and above _VISIBLE times the largest value is attributed to
# the law. The noise is estimated from second differences of at least _FEW values.
_OFF, _VISIBLE, _FEW = 3.0, 0.02, 8

# Smallest decrease of the sum of squares per parameter, in units of the residual variance, for a
# significant fit. A fit to pure noise decreases the sum by about one variance per parameter, and by
# a few if the contact may start at any of a thousand samples.
_EXPLAINED = 10.0

# A parameter counts as being at its bound if the logarithms of both differ by less than this.
_AT_BOUND = 1e-2


@dataclass(frozen=True, eq=False)
class LawFit(Frozen):
    """A contact law fitted to a measurement.

    Attributes
    ----------
    law : ContactLaw
        The law with the parameters that fit best.
    standard_errors : dict of str to float
        Standard error of each fitted parameter in the parameter's unit, and for a history also of
        `start_time`, s.
    correlation : ndarray
        Correlation matrix of the parameters, in the order of `standard_errors`.
    residual : float
        Standard deviation of the measured values from the law, in the unit of the measurement.
    start_time : float or None
        Start of the contact on the time axis of a force history, s; None for other measurements.
    undetermined : tuple of str
        Parameters that the data do not determine.

    Examples
    --------
    >>> depth = [0.0, 1e-5, 2e-5, 3e-5]
    >>> fit = ao.fit_law(ao.Hertz, indentation=depth, force=[0.0, 33.0, 88.0, 165.0])
    >>> print(fit)
    Hertz, k = 1 GN/m^1.5
      k = 1.001 GN/m^1.5 ± 6.4 MN/m^1.5
    """

    law: ContactLaw
    standard_errors: Mapping[str, float]
    correlation: FloatArray
    residual: float
    start_time: float | None
    undetermined: tuple[str, ...]

    def __str__(self) -> str:
        """Return a text with the law, and each parameter with its standard error."""
        lines = [str(self.law)]
        for name, error in self.standard_errors.items():
            of: Any = self if name == "start_time" else self.law
            value, unit = getattr(of, name), self.law.units.get(name, "s")
            lines.append(f"  {name} = {with_unit(value, unit)} ± {with_unit(error, unit, 2)}")
        return "\n".join(lines)


@dataclass(frozen=True)
class _Problem:
    """Misfit of a law to a measurement as a function of the logarithms of its free parameters.

    For a history, there is a last variable: the correction of the contact's start, in units of
    `time`. `shown` returns the values that a law predicts for a contact that begins at a given
    time, s. `force`, N, `depth`, m, `velocity`, m/s, and `start`, s, are estimates of the largest
    force, the largest indentation, the velocity and the start of the contact; `sample` is the
    spacing of the samples, s.
    """

    measured: FloatArray
    shown: Callable[[ContactLaw, float], FloatArray]
    force: float = 0.0
    depth: float = 0.0
    velocity: float = 1.0
    start: float | None = None
    sample: float = 0.0
    law: Any = None
    names: Sequence[str] = ()

    @property
    def time(self) -> float:
        """Time scale of the contact, s: ratio of largest indentation to velocity."""
        return self.depth / self.velocity

    @cached_property
    def first(self) -> FloatArray:
        """Initial values of the free parameters, shape (n,)."""
        return np.array([getattr(self.law, name) for name in self.names])

    @cached_property
    def bounds(self) -> FloatArray:
        """Lower and upper bounds of the variables, shape (2, n)."""
        bounds = np.array([_BOUNDS.get(name, (0.0, math.inf)) for name in self.names])
        bounds = np.clip(bounds / self.first[:, None], 1.0 / _RANGE, _RANGE)
        timed = [[-math.inf], [math.inf]] if self.start is not None else np.empty((2, 0))
        found = np.hstack([np.log(bounds).T, timed])
        if len(self.measured) <= found.shape[1]:
            raise InputError(
                f"{found.shape[1]} parameters need more than {len(self.measured)} measured values"
            )
        return found

    def parameters(self, x: FloatArray) -> FloatArray:
        """Return the free parameters from the variables; for a history, also the start, s."""
        values = self.first * np.exp(x[: len(self.names)])
        if self.start is None:
            return values
        return np.append(values, self.start + self.time * x[-1])

    def law_at(self, x: FloatArray) -> ContactLaw:
        values = dict(zip(self.names, self.parameters(x).tolist(), strict=False))
        return cast(ContactLaw, replace(self.law, **values))

    def misfit(self, x: FloatArray) -> FloatArray:
        """Return the difference of predicted and measured values."""
        return self.shown(self.law_at(x), float(self.parameters(x)[-1])) - self.measured

    def solved(self) -> Any:
        """Return SciPy's solution of the least-squares problem.

        If the force begins with a jump, or nearly so, the misfit has a local minimum with respect
        to the start between any two neighbouring samples.
        """
        first = np.zeros(self.bounds.shape[1])
        refused = 2.0 * self.misfit(first)

        def misfit(x: FloatArray) -> FloatArray:
            try:
                return self.misfit(x)
            except AOImpactError:  # invalid parameters: SciPy refuses the step, and shortens it
                return refused

        def within(x: FloatArray, bounds: FloatArray) -> Any:
            # The first step may change parameters by e^30: far from the answer, the misfit hardly
            # depends on them, and small steps would end the fit.
            return scipy.optimize.least_squares(
                misfit, x, "3-point", bounds, ftol=PRINTED, gtol=None, x_scale=30.0
            )

        found = within(first, self.bounds)
        if self.start is None:
            return found
        # A force that is large soon after the start of the contact is treated as a jump.
        early = self.law_at(found.x).force(_EARLY * self.depth, self.velocity)
        if not early > _FOOT * self.force:
            return found
        between = []
        for sample in range(-_SAMPLES, _SAMPLES):
            bounds, ends = self.bounds.copy(), np.array([sample + _APART, sample + 1.0 - _APART])
            bounds[:, -1] = ends * self.sample / self.time
            begin = np.append(found.x[:-1], bounds[:, -1].mean())
            between.append(within(begin, bounds))
        best = min(between, key=lambda one: one.cost)
        # Leave out the first sample in contact: its force varies with the start like a square root,
        # whose derivative is infinite.
        best.jac = np.delete(best.jac, np.argmax(best.fun + self.measured > 0.0), axis=0)
        return best


def fit_law(
    law: ContactLaw | type[ContactLaw],
    signal: Any = None,
    *,
    mass: float | None = None,
    velocity: ArrayLike | None = None,
    projectile: Any = None,
    target: Any = None,
    indentation: ArrayLike | None = None,
    force: ArrayLike | None = None,
    dent: ArrayLike | None = None,
    free: Iterable[str] | None = None,
) -> LawFit:
    """Fit a contact law to a measurement by least squares, and estimate its uncertainty.

    The measurement is one of three:

    - a force history, `signal`, of a mass that meets a wall, or of two models of bodies. The start
      of the contact is fitted as well;
    - a curve of `force` against `indentation` in the order of loading, unloading and reloading;
    - diameters of the dents that a mass left at several velocities, `dent`.

    Parameters
    ----------
    law : ContactLaw or type
        Initial law; its parameters that are not in `free` are kept. Or the class of the law, if the
        measurement (a history or a curve) allows a first guess.
    signal : Signal or (t, values), optional
        Contact force, N.
    mass : float, optional
        Mass of a rigid body that meets a wall, or reduced mass of a pair, kg.
    velocity : float or array_like, optional
        Approach velocity, m/s; in tests of dents, one for each dent.
    projectile, target : optional
        Models of the bodies, in place of `mass`, as `simulate` takes them.
    indentation, force : array_like, optional
        Points of a curve, m and N.
    dent : array_like, optional
        Diameters of dents, m; the law needs a radius.
    free : iterable of str, optional
        Names of the parameters to fit; by default all that the law requires, except its radius and
        the mass and velocity of the test.

    Returns
    -------
    LawFit
        The fitted law. Its standard errors presume independent errors of the same size in all
        points; for a filtered signal they are too small.

    Raises
    ------
    InputError, InputTypeError
        If the measurement is incomplete, or a name in `free` is not that of a parameter above 0.

    Warns
    -----
    AOImpactWarning
        If the data do not determine a parameter: its standard error exceeds half of its value. If
        the law does not describe the data: the residual exceeds both three times the noise and 2 %
        of the largest value, or a parameter is at a bound. If the data are hardly more than noise.

    Examples
    --------
    >>> from aoimpact.testrig import Signal
    >>> ball = ao.rigid(mass=0.1)
    >>> law = ao.HuntCrossley(k=1e9, damping=0.2)
    >>> hit = ao.simulate(ball, ao.rigid(mass=float("inf")), 1.0, law=law)
    >>> signal = Signal.of(hit, rate=1e6)
    >>> fit = ao.fit_law(ao.HuntCrossley, signal, mass=0.1, velocity=1.0)
    >>> round(fit.law.k / 1e9, 3), round(fit.law.damping, 3)
    (1.0, 0.2)
    """
    measured = [signal is not None, indentation is not None or force is not None, dent is not None]
    if sum(measured) > 1:
        raise InputError("give one measurement: signal=, or indentation= and force=, or dent=")
    bodies = [projectile is not None, target is not None]
    wanted = not all(bodies) or (isinstance(law, type) and "mass" in _needed(law))
    apart = bodies[0] != bodies[1] or (any(bodies) and signal is None)
    if apart or (mass is not None and any(bodies) and not wanted):
        raise InputError(
            f"give both projectile= and target= with a signal, or mass={mass or ''} alone, of a "
            "rigid body that meets a wall"
        )
    if signal is not None:
        data = _history(signal, mass, velocity, projectile, target)
    elif indentation is not None and force is not None:
        data = _curve(indentation, force)
    elif dent is not None:
        data = _dents(dent, mass, velocity)
    else:
        raise InputError("give a signal, or indentation= and force=, or dent= of several impacts")
    start = law if isinstance(law, ContactLaw) else _guess(law, data, mass)
    names = _free(start, free)
    problem = replace(data, law=start, names=names)
    # Forces of laws that are far from the measurement may overflow.
    with np.errstate(all="ignore"), shared_models():
        found = problem.solved()
        variance = 2.0 * float(found.cost) / (len(data.measured) - len(found.x))
        residual = math.sqrt(variance)
        errors, correlation = _uncertainty(found.jac, residual)
    values = problem.parameters(found.x)
    of_law = dict(zip(names, errors, strict=False))
    poor = {name: error for name, error in of_law.items() if not error <= _DETERMINED}
    if poor:
        said = [f"{of} ({f'± {by:.0%}' if by < math.inf else 'at all'})" for of, by in poor.items()]
        warn(f"the data do not determine {', '.join(said)}: fix them, or measure where they matter")
    _warn_of_a_poor_fit(problem, found.x, residual, poor)
    sizes = np.append(values[: len(names)], [data.time] * (len(values) - len(names)))
    return LawFit(
        problem.law_at(found.x),
        dict(zip([*names, "start_time"], (errors * sizes).tolist(), strict=False)),
        correlation,
        residual,
        float(values[-1]) if data.start is not None else None,
        tuple(poor),
    )


def _warn_of_a_poor_fit(
    problem: _Problem, x: FloatArray, residual: float, poor: Mapping[str, float]
) -> None:
    """Warn if the law does not describe the measurement, with the size of the misfit."""
    largest = float(np.abs(problem.measured).max())
    noise = 0.0
    if (
        problem.force and len(problem.measured) >= _FEW
    ):  # if errors have deviation σ, second differences have √6 σ
        second = np.abs(np.diff(problem.measured, 2))
        noise = float(np.median(second)) / (0.6745 * math.sqrt(6.0))
    if residual > max(_OFF * noise, _VISIBLE * largest):
        warn(
            f"{type(problem.law).__name__} is off by {residual / largest:.1%} of the largest value "
            f"with noise of {noise / largest:.1%}: take another law, or check mass and velocity"
        )
    misfit = problem.misfit(x)
    explained = problem.measured @ problem.measured - misfit @ misfit
    if explained < _EXPLAINED * len(x) * residual**2:
        warn(
            f"the measurement is hardly more than noise, {residual / largest:.0%} of the largest "
            "value: the fit means nothing; measure with more gain, or check start and units"
        )
    near = np.abs(problem.bounds - x).min(axis=0) < _AT_BOUND
    bound = [name for name, at in zip(problem.names, near, strict=False) if at and name not in poor]
    if bound:
        warn(f"{', '.join(bound)}: the best fit is at the bound of the range; take another law")


def _uncertainty(jacobian: FloatArray, residual: float) -> ArrayPair:
    """Return the standard errors and the correlation matrix of the variables."""
    size = np.linalg.norm(jacobian, axis=0)
    size = np.where(size > 0.0, size, np.finfo(float).tiny ** 0.5)
    _, strength, turn = np.linalg.svd(jacobian / size, full_matrices=False)
    strength = np.maximum(strength, PRINTED * strength[0])  # smaller ones are rounding errors
    spread = turn.T / strength
    covariance = spread @ spread.T
    errors = np.sqrt(np.diag(covariance))
    share = errors * residual / size
    share[~(errors <= 0.1 / PRINTED)] = math.inf  # NaN: no variable has influence
    return share, covariance / np.outer(errors, errors)


def _needed(law: Any) -> list[str]:
    """Return the names of the parameters of a law, or of its class, that have no default."""
    return [entry.name for entry in fields(law) if entry.default is MISSING]


def _free(law: ContactLaw, free: Iterable[str] | None) -> list[str]:
    """Return the names of the parameters to fit."""
    if free is None:
        chosen = [name for name in _needed(law) if name not in _OF_THE_TEST]
    else:
        chosen = list(texts("free", [free] if isinstance(free, str) else free))
    values = {entry.name: getattr(law, entry.name) for entry in fields(cast(Any, law))}
    for name in chosen:
        value = values.get(name)
        if not isinstance(value, float) or not value > 0.0:
            raise InputError(
                f"free: {name!r} is no parameter above 0 of {law!r}; begin with a law that has one"
            )
    if not chosen or len(set(chosen)) < len(chosen):
        raise InputError(f"free must name parameters of {law!r} to fit, each once, got {chosen}")
    return chosen


def _guess(cls: Any, data: _Problem, mass: float | None) -> ContactLaw:
    """Return an initial law of the class `cls`, estimated from the size of the measured values."""
    if not (isinstance(cls, type) and issubclass(cls, ContactLaw)):
        raise InputTypeError(f"law must be a contact law or its class, got {cls!r}")
    known, needed = {"mass": mass, "velocity": data.velocity}, _needed(cls)
    given: dict[str, Any] = {}
    for of in fields(cast(Any, cls)):
        name, unit = of.name, of.metadata.get("unit", "")
        if name in known:
            given[name] = known[name]
        elif name not in needed:
            continue
        elif name == "k":
            given[name] = data.force / data.depth**cls.power
        elif name in _NAMED:
            given[name] = _NAMED[name]
        elif unit in _GUESSES and data.force > 0.0:
            share, force, depth, velocity = _GUESSES[unit]
            given[name] = share * data.force**force * data.depth**depth * data.velocity**velocity
        else:
            raise InputError(
                f"law={cls.__name__} has no first guess of {name} from this measurement; give a "
                f"law to begin with, {cls.__name__}(...)"
            )
    return cls(**given)


# ------------------------------------------------------------------- measurements


def _curve(indentation: ArrayLike, force: ArrayLike) -> _Problem:
    depth = finite_array("indentation", indentation, shape=(None,), unit="m", most=HUGE)
    push = finite_array("force", force, shape=depth.shape, unit="N", most=HUGE)

    def shown(law: ContactLaw, _: float) -> FloatArray:
        if law.depends_on_rate:
            raise InputError(f"a curve has no rates, on which {law!r} depends; give a history")
        return np.asarray(law.force(depth, along=True))

    return _Problem(push, shown, _largest("force", push), _largest("indentation", depth))


def _dents(dent: ArrayLike, mass: float | None, velocity: Any) -> _Problem:
    wide = finite_array("dent", dent, shape=(None,), unit="m", most=HUGE)
    _largest("dent", wide)
    if wide.min() < 0.0:
        raise InputError(f"dent must be diameters, none negative, got {dent!r} m")
    speeds = finite_array("velocity", velocity, shape=wide.shape, unit="m/s")
    energies = 0.5 * positive("mass", mass, unit="kg") * speeds**2
    return _Problem(
        wide, lambda law, _: np.array([law.dent(law.stroke(e)).diameter for e in energies])
    )


def _history(
    signal: Any, mass: float | None, velocity: Any, projectile: Any, target: Any
) -> _Problem:
    channel = Signal.of(signal)
    speed = positive("velocity", velocity, unit="m/s")
    if projectile is None:
        projectile = rigid(mass=positive("mass", mass, unit="kg"))
        target = rigid(mass=math.inf)
    peak = int(np.argmax(channel.values))
    top = _largest("signal", channel.values)
    foot = np.flatnonzero(channel.values[:peak] <= _FOOT * top)
    start = float(channel.t[foot.max(initial=0)])
    sample = 1.0 / channel.mean_rate
    depth = max(float(channel.t[peak]) - start, sample) * speed / _RISE

    def shown(law: ContactLaw, begin: float) -> FloatArray:
        force, until = np.zeros(channel.t.shape), float(channel.t[-1]) - begin
        if until > 0.0:
            with held_warnings():
                hit = simulate(projectile, target, speed, law=law, duration=until, solver=_SOLVER)
                within = channel.t > begin
                force[within] = hit.at(channel.t[within] - begin).force
        return force

    return _Problem(channel.values, shown, top, depth, speed, start, sample)


def _largest(name: str, values: FloatArray) -> float:
    """Return the largest of the values; refuse it unless it is above 0."""
    top = float(values.max(initial=0.0))
    if not top > 0.0:
        raise InputError(f"{name} must have a value above 0")
    return top
