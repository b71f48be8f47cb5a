"""Time against error of each method, on impacts of AO models.

    python benchmarks/work_precision.py [--scene pair] [--scipy] [--out FOLDER]

`work_precision` measures any such impact. The program measures two: two spheres of one
anti-oscillator each, and a rigid sphere on a beam of 28 anti-oscillators over 20 ms. It writes a
table (CSV) and a figure (PNG) of each, in some seconds, or with SciPy's solvers in a minute or two.
"""

from __future__ import annotations

import math
import time
import warnings
from argparse import ArgumentParser
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from impacts import SCENES
from precision_table import Measurement, Reference, WorkPrecision
from scipy_solvers import METHODS, OdeScene, Outcome, centre_weights, ode_scene

from aoimpact import (
    Adaptive,
    AOImpactError,
    AOImpactWarning,
    AOModel,
    Body,
    ContactLaw,
    InputError,
    InputTypeError,
    Newmark,
    Result,
    simulate,
)
from aoimpact.base import choice, instance, integer, positive, sequence, with_unit
from aoimpact.impact import plan_impact
from aoimpact.integrate import rigid_contact_time
from aoimpact.reduction import body_model

# Steps of Newmark's rule by scene, s: the longest of these runs takes a second or two.
_STEPS = {
    "pair": (1e-6, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9, 3e-10, 1e-10),
    "beam": (2e-6, 1e-6, 3e-7, 1e-7, 3e-8),
}

# Default tolerances, from coarse to rounding. `_SCIPY` has fewer, since runs by SciPy take seconds.
_ADAPTIVE = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
_SCIPY = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)

# Largest accepted value of `repeats`; a larger one is probably a mistake.
_MOST_REPEATS = 10_000

# `_NEWMARK`: default ratios of Newmark's step to the contact time. `_MOST_STEPS`: maximum number of
# steps of a run.
_NEWMARK, _MOST_STEPS = (1e-2, 1e-3, 1e-4, 1e-5), 1e6

# Times, s. `_AT_LEAST`: minimum total time of a short run's repeats. `_ENOUGH`: maximum total time
# of a long run's repeats. `_LONGEST`: time after which a run of SciPy is stopped.
_AT_LEAST, _ENOUGH, _LONGEST = 0.02, 3.0, 60.0

# SciPy's method and tolerance for the independent reference; rounding errors accumulate to some
# 1e-12.
_INDEPENDENT = "DOP853", 3e-14


def work_precision(
    *,
    projectile: Any,
    target: Any,
    law: ContactLaw,
    velocity: float,
    duration: float,
    gap: float = 0.0,
    newmark: Iterable[float] | None = None,
    adaptive: Iterable[float] | None = None,
    scipy: Iterable[str] = (),
    reference: Result | Reference | None = None,
    repeats: int = 5,
) -> WorkPrecision:
    """Measure time and error of several solvers on one impact.

    All times are those of the whole call from Python, with the curves of the result.

    Parameters
    ----------
    projectile, target, law, velocity, duration, gap
        As in `simulate`; both bodies must be AOModels or modal models.
    newmark : iterable of float, optional
        Steps dt, s; by default from a hundredth of the contact time down.
    adaptive : iterable of float, optional
        Tolerances; by default from 1e-3 to 1e-11.
    scipy : iterable of str, optional
        Methods of ``scipy.integrate.solve_ivp``, each run at tolerances from 1e-4 to 1e-12 on
        separate equations of motion, with every touch, release and peak as an event.
    reference : Result or Reference, optional
        Reference in place of ``Adaptive(1e-12)``.
    repeats : int, optional
        Number of runs of which the shortest time counts; short runs are repeated more often, long
        ones less. With 1 each setting is run once.

    Returns
    -------
    WorkPrecision

    Raises
    ------
    InputError, InputTypeError
        As in `simulate`, and for a finite-element model, an unknown method or a law that is not
        written out for SciPy.
    ConvergenceError
        If the reference cannot be computed.
    """
    count = integer("repeats", repeats, low=1, high=_MOST_REPEATS)
    instance("law", law, ContactLaw)
    duration = positive("duration", duration, unit="s")
    names = _methods(scipy)
    bodies = _star("projectile", projectile), _star("target", target)
    scene = {
        "projectile": projectile,
        "target": target,
        "law": law,
        "velocity": velocity,
        "duration": duration,
        "gap": gap,
        "energies": False,
    }
    exact = _given(reference) if reference is not None else _reference(scene)
    models = [body.modal for body in bodies]
    plan = plan_impact(*models, law, velocity=velocity, duration=duration)
    between = plan.contacts[0].law
    contact_time = rigid_contact_time(between, plan.reduced_mass(plan.contacts[0]), abs(velocity))
    ode = None
    if names:
        ode = ode_scene(
            bodies,
            between,
            velocity=velocity,
            duration=duration,
            gap=gap,
            length=abs(velocity) * contact_time,
        )
        exact = _with_independent(exact, ode, bodies[0], velocity)
    runs = [
        *_newmark_runs(scene, newmark, contact_time),
        *(
            _Run("Adaptive", f"rtol={rtol:.3g}", _simulation(scene, Adaptive(rtol=rtol)))
            for rtol in _settings("adaptive", adaptive, _ADAPTIVE)
        ),
        *(_scipy_run(ode, bodies[0], velocity, name, rtol) for name in names for rtol in _SCIPY),
    ]
    rows = tuple(_measure(run, exact.outcome, velocity, count) for run in runs)
    labels = f"{bodies[0].label} on {bodies[1].label}"
    title = f"{labels}, {law}, {velocity:g} m/s, {with_unit(duration, 's')}"
    return WorkPrecision(title, exact, rows)


class _Run(NamedTuple):
    """Names of a method and of its setting in the table, and the function of the run."""

    method: str
    setting: str
    run: Callable[[], Outcome]


def _star(name: str, body: Any) -> AOModel:
    made = body_model(name, body)
    if not isinstance(made, Body) or made.ports > 1:
        raise InputTypeError(
            f"{name} must be an AOModel or a modal model, got {body!r}: reduce it by "
            "antioscillators(...) first"
        )
    return made.star


def _methods(scipy: Iterable[str]) -> tuple[str, ...]:
    names = (scipy,) if isinstance(scipy, str) else tuple(sequence("scipy", scipy))
    for name in names:
        choice("scipy", name, METHODS)
    return names


def _settings(
    name: str, values: Iterable[float] | None, default: Sequence[float]
) -> tuple[float, ...]:
    if values is None:
        return tuple(default)
    return tuple(positive(name, value) for value in sequence(name, values))


def _newmark_runs(
    scene: dict[str, Any], steps: Iterable[float] | None, contact_time: float
) -> list[_Run]:
    shortest = scene["duration"] / _MOST_STEPS
    default = [share * contact_time for share in _NEWMARK if share * contact_time >= shortest]
    return [
        _Run("Newmark", f"dt={dt:.3g} s", _simulation(scene, Newmark(dt=dt, estimate=False)))
        for dt in _settings("newmark", steps, default)
    ]


def _scipy_run(
    ode: OdeScene | None, projectile: AOModel, velocity: float, method: str, rtol: float
) -> _Run:
    assert ode is not None
    # The AO model of a body struck off its centre lacks a part of the rigid motion; its velocity is
    # constant.
    kept = 0.0 if projectile.constrained else velocity * (1.0 - centre_weights(projectile).sum())

    def run() -> Outcome:
        done = ode.run(method, rtol, _LONGEST)
        return Outcome(done.peak_force, done.contact_duration, done.rebound_velocity + kept)

    return _Run(f"SciPy {method}", f"rtol={rtol:.3g}", run)


def _outcome(result: Result) -> Outcome:
    return Outcome(result.peak_force, result.contact_duration, result.compared_velocities[0])


def _simulation(scene: dict[str, Any], solver: Newmark | Adaptive) -> Callable[[], Outcome]:
    return lambda: _outcome(simulate(**scene, solver=solver))


def _reference(scene: dict[str, Any]) -> Reference:
    outcome = _simulation(scene, Adaptive(rtol=1e-12))()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AOImpactWarning)
        looser = _simulation(scene, Adaptive(rtol=1e-11))()
    change = max(_errors(looser, outcome, scene["velocity"]))
    return Reference(outcome, "Adaptive(rtol=1e-12)", change)


def _given(reference: Result | Reference) -> Reference:
    if isinstance(reference, Reference):
        return reference
    if not isinstance(reference, Result):
        raise InputTypeError(f"reference must be a Result or a Reference, got {reference!r}")
    return Reference(_outcome(reference), reference.solver)


def _with_independent(
    reference: Reference, ode: OdeScene, projectile: AOModel, velocity: float
) -> Reference:
    """Return the reference with its difference from a SciPy run; unchanged if the run fails."""
    try:
        second = _scipy_run(ode, projectile, velocity, *_INDEPENDENT).run()
    except AOImpactError:
        return reference
    distance = max(_errors(second, reference.outcome, velocity))
    uncertainty = max(distance, reference.uncertainty or 0.0)
    return Reference(reference.outcome, reference.source, uncertainty, distance)


def _errors(outcome: Outcome, exact: Outcome, velocity: float) -> tuple[float, float, float]:
    return (
        _relative(outcome.peak_force, exact.peak_force),
        _relative(outcome.contact_duration, exact.contact_duration),
        abs(outcome.rebound_velocity - exact.rebound_velocity) / abs(velocity),
    )


def _relative(value: float, exact: float) -> float:
    if value == exact:
        return 0.0
    return abs(value - exact) / abs(exact) if exact else math.inf


def _measure(timed: _Run, exact: Outcome, velocity: float, repeats: int) -> Measurement:
    method, setting, run = timed
    best, spent, done = math.inf, 0.0, 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AOImpactWarning)  # the table shows the error
        while (repeats > 1 and spent < _AT_LEAST) or (done < repeats and spent < _ENOUGH):
            start = time.perf_counter()
            try:
                outcome = run()
            except InputError:
                raise
            except AOImpactError as error:
                return Measurement(method, setting, *(math.nan,) * 4, str(error))
            seconds = time.perf_counter() - start
            best, spent, done = min(best, seconds), spent + seconds, done + 1
    return Measurement(method, setting, best, *_errors(outcome, exact, velocity))


def main() -> None:
    parser = ArgumentParser(description="Speed against error of the solvers.")
    parser.add_argument("--scene", choices=SCENES, help="one of them (default: both)")
    parser.add_argument("--out", default="work-precision", type=Path, help="folder for the files")
    parser.add_argument("--scipy", action="store_true", help="measure SciPy's solvers as well")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    methods = ("DOP853", "LSODA") if options.scipy else ()
    for name in (options.scene,) if options.scene else SCENES:
        study = work_precision(**SCENES[name](), newmark=_STEPS[name], scipy=methods, repeats=3)
        study.to_csv(options.out / f"{name}.csv")
        study.plot().figure.savefig(options.out / f"{name}.png")
        print(f"{study}\n{name}.csv, {name}.png in {options.out}\n")


if __name__ == "__main__":
    main()
