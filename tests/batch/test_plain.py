"""Plain impacts made together have the numbers of `simulate`, to the last bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from every_law import LAWS, law_of
from impacts import beam_star, pair

import aoimpact as ao
from aoimpact import _core
from aoimpact.batch import PLAIN_NUMBERS, plain_numbers
from aoimpact.results import COLUMNS

NAMES = tuple(sorted(PLAIN_NUMBERS))

SPHERE = pair()["projectile"]
BALL = ao.rigid(mass=0.03)
HERTZ = ao.Hertz(k=1e10)


def case(**changes: Any) -> dict[str, Any]:
    return {
        "projectile": BALL,
        "target": SPHERE,
        "law": HERTZ,
        "velocity": 1.0,
        "duration": 1e-3,
    } | changes


def numbers_of(result: ao.Result) -> dict[str, float]:
    own = {name: result.value(name) for name in NAMES if name != "error.time"}
    assert result.error.time is not None
    return own | {"error.time": result.error.time}


def bits(numbers: dict[str, float] | None) -> dict[str, str]:
    assert numbers is not None
    return {name: value.hex() for name, value in numbers.items()}


PLAIN = [
    case(),
    case(velocity=2.0, solver=ao.Adaptive(rtol=1e-6)),
    case(target=ao.rigid(mass=math.inf), duration=2e-4),
    case(projectile=SPHERE, target=BALL, gap=1e-5),
    case(gap=-0.0),
    case(gap=1e-310),
    case(projectile=ao.rigid(mass=math.inf), target=BALL),
    case(target=ao.AOModel(m0=0.0, k0=1e6, m=[0.2], k=[1e8]), duration=1e-4),
    case(target=beam_star(), duration=2e-4),
    case(law=ao.HuntCrossley(k=1e10, damping=0.3)),
    case(law=ao.Thornton(k=1e10, yield_force=100.0)),
    case(law=ao.Tabulated([1e-6, 1e-4], [10.0, 2e4])),
    case(law=ao.KelvinVoigt(k=1e8, c=100.0)),
    case(velocity=2, duration=np.float64(1e-3)),
]


BAR = ao.FEModel.from_mesh(
    ao.box_mesh((0.1, 0.01, 0.01), (6, 1, 1)), ao.Material(E=70e9, nu=0.3, rho=2700)
)
# A free bar hit off its centre turns: its models leave some of its motion out.
ENDS = [BAR.contact(point=(x, 0, 0), direction=(0, 0, 1), radius=0) for x in (0.1, 0.0)]
STAR, MODES = ao.antioscillators(ENDS[0], n=3), ao.modal(ENDS[1], n=12)
PLAIN += [case(projectile=STAR, target=BALL, duration=8e-5)]
PLAIN += [case(projectile=MODES, target=STAR, duration=8e-5)]
PLAIN += [case(target=ao.rigid(mass=math.inf), law=law_of(name)) for name in sorted(LAWS)]
# What is not plain, or no case, and changes nothing for those beside it.
CHANGES: list[dict[str, Any]] = [
    {"solver": ao.Newmark(dt=1e-6)},
    {"target": beam_star(), "duration": 20e-3, "projectile": ao.rigid(mass=0.5)},  # meets twice
    {"duration": 1e-5},  # ends in contact
    {"gap": 1.0},  # ends before it
    {"law": ao.UserLaw(lambda depth, rate: 1e8 * depth)},
    {"law": ao.UserLaw(lambda depth, rate: 1e8 * depth).within_patch(1e-10)},
    {"velocity": 0.0},
    {"velocity": -2.0},
    {"velocity": math.nan},
    {"velocity": "1"},
    {"velocity": 10**400},
    {"velocity": True},
    {"duration": 0.0},
    {"duration": math.inf},
    {"gap": -1.0},
    {"law": None},
    {"target": None},
    {"energies": "no"},
    {"speed": 1.0},
    {"solver": ao.Adaptive(rtol=1e-13), "law": ao.PowerLaw(k=1e300, n=42.0)},
]


def alone(one: dict[str, Any]) -> Any:
    try:
        return bits(numbers_of(ao.simulate(**one)))
    except ao.AOImpactError as error:
        return type(error)


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
def test_impacts_made_together_have_the_numbers_of_each_alone() -> None:
    cases = [*PLAIN, *(case(**change) for change in CHANGES)]
    for one, found in zip(cases, ao.simulate_many(cases, keep=NAMES), strict=True):
        assert (type(found) if isinstance(found, Exception) else bits(found)) == alone(one), one


def test_plain_impacts_are_made_together() -> None:
    assert all(plain_numbers(PLAIN[:16], NAMES))


def test_sweeps_that_are_not_told_what_to_keep_are_plain() -> None:
    slow = set(COLUMNS) - PLAIN_NUMBERS
    assert not slow, f"leave column=True out: {slow} take each impact of a sweep off the fast path"


def test_the_core_takes_no_places_that_are_not_there() -> None:
    ball = BALL.modal
    given = (ball.for_core(),), (ball.whole.moving,), (HERTZ.for_core(),)
    numbers, answers = np.array([[1.0, 0.0, 1e-3, 1e-6]]), np.empty((1, 10))
    for which in ([0, 1, 0], [0, 0, 1], [-1, 0, 0]):
        with pytest.raises(ao.InputError):
            _core.briefs(*given, np.array([which], dtype=np.int32), numbers, answers)
    with pytest.raises(ValueError, match="which"):
        _core.briefs(*given, np.zeros(2, dtype=np.int32), numbers, answers)
    with pytest.raises(TypeError):
        _core.briefs(given[0], (), given[2], np.zeros(3, dtype=np.int32), numbers, answers)
