"""Trials of the cures that an error message names: a refusal is honest if one of them works."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import aoimpact as ao

from .case import Body, Case
from .compare import apart, from_newmark, largest_apart
from .outcome import Outcome
from .package import in_time, run

# Tolerances to try if a message names a larger rtol, and numbers of Newmark's steps to try.
_LARGER, _STEPS = (1e-6, 1e-4, 1e-2), (20_000, 200_000)

# Maximum time of a run, s.
_LONGEST = 6.0

# Small m0 over the body's other masses, and the largest error of an answer with this m0 or with a
# chosen step of Newmark's rule.
_SMALL, _ABOUT = 1e-6, 1e-2

# Largest error of an answer over its tolerance.
TIMES = 10.0


@dataclass(frozen=True)
class Cure:
    """Another run: its name, scene and solver, and the largest error of its answer.

    `within`: that error; None for a different scene, whose answer is not known.
    """

    name: str
    case: Case
    solver: Any = None
    within: float | None = None


def named(case: Case, message: str) -> dict[str, list[Cure]]:
    """Return the cures that a message names, each with the ways to try it."""
    larger = [rtol for rtol in _LARGER if rtol > case.rtol]
    steps = [case.duration / steps for steps in _STEPS]
    ways = {
        "larger rtol": [
            Cure(f"rtol={rtol:g}", case.with_tolerance(rtol), None, TIMES * rtol) for rtol in larger
        ],
        "m0": [Cure("another m0", _heavier(case), None, _ABOUT)],
        "dt": [Cure(f"dt={dt:g}", case, ao.Newmark(dt=dt), _ABOUT) for dt in steps],
        "softer law": [Cure("k/100", _softer(case))],
        "less load": [Cure("a hundredth of the load", _lighter(case))],
        "shorter duration": [Cure("a tenth", replace(case, duration=0.1 * case.duration))],
    }
    return {word: of for word, of in ways.items() if word in message}


def _heavier(case: Case) -> Case:
    bodies = [
        replace(body, m0=_SMALL * body.mass) if isinstance(body, Body) and body.massless else body
        for body in case.bodies
    ]
    return replace(case, bodies=tuple(bodies))


def _lighter(case: Case) -> Case:
    loads = tuple(replace(of, forces=tuple(0.01 * f for f in of.forces)) for of in case.loads)
    return replace(case, gravity=0.01 * case.gravity, loads=loads)


def _softer(case: Case) -> Case:
    contacts = []
    for contact in case.contacts:
        given = contact.law.arguments
        softer = {name: v / 100.0 if name == "k" else v for name, v in given.items()}
        contacts.append(replace(contact, law=replace(contact.law, arguments=softer)))
    return replace(case, contacts=tuple(contacts))


def tried(case: Case, message: str, true: Outcome | None) -> dict[str, str]:
    """Return the failure of each cure that a message names, or an empty text if it works.

    Parameters
    ----------
    true : Outcome or None
        True outcome of the scene, if it is known.
    """
    found = {}
    for name, ways in named(case, message).items():
        failures = []
        for failure in _failures(ways, true):
            failures.append(failure)
            if not failure:
                break
        found[name] = " and ".join(failures) if all(failures) else ""
    return found


def _failures(ways: list[Cure], true: Outcome | None) -> Iterator[str]:
    for cure in ways:
        answer = in_time(partial(run, cure.case, cure.solver), _LONGEST)
        if answer is None:
            yield f"{cure.name} does not end in {_LONGEST:g} s"
        elif answer.outcome is None:
            yield f"{cure.name} is refused"
        elif cure.within is None or true is None:
            yield ""
        elif cure.solver is not None:
            off = from_newmark(cure.case, answer.outcome, true)
            yield "" if off <= cure.within else f"{cure.name} is off by {off:.2g}"
        else:
            worst = largest_apart(apart(cure.case, answer.outcome, true, cure.within))
            yield "" if worst.off <= cure.within or answer.warned else f"{cure.name}: {worst}"
