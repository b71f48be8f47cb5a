"""A digest changes with the content and with nothing else."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from every_law import LAWS, law_of

import aoimpact as ao
from aoimpact.batch import Digests
from aoimpact.results import Handle

STAR = {"m0": 0.1, "k0": 1e5, "m": [0.2, 0.3], "k": [1e6, 2e6]}


def digest(value: Any) -> str:
    return Digests(None).of(value)


def case(**changes: Any) -> dict[str, Any]:
    return {
        "projectile": ao.rigid(mass=0.1),
        "target": ao.AOModel(**STAR),
        "law": ao.Hertz(k=1e9),
        "velocity": 1.0,
        "duration": 1e-3,
    } | changes


@pytest.mark.parametrize(
    "change",
    [
        {"velocity": math.nextafter(1.0, 2.0)},
        {"velocity": np.float64(-1.0)},
        {"law": ao.PowerLaw(k=1e9, n=1.5)},
        {"law": ao.Hertz(k=1.0000000001e9)},
        {"target": ao.AOModel(**STAR | {"m": [0.3, 0.2]})},
        {"solver": ao.Adaptive(rtol=1e-6)},
        {"gap": 0.0},
    ],
)
def test_any_change_shows(change: dict[str, Any]) -> None:
    assert digest(case(**change)) != digest(case())


def test_every_law_has_a_digest_of_its_own_which_changes_with_its_stiffness() -> None:
    names = [name for name in LAWS if name != "UserLaw"]
    laws = [law_of(name) for name in names] + [law_of(name, k=2e10) for name in names]
    own = set(map(digest, laws))
    assert len(own) == len(set(laws))
    assert set(map(digest, (law_of(name) for name in names))) <= own


def test_what_was_computed_and_kept_does_not_count() -> None:
    body = ao.FEModel.from_mesh(
        ao.box_mesh((0.1, 0.01, 0.01), (2, 1, 1)), ao.Material(E=70e9, nu=0.3, rho=2700)
    )
    before = digest(body)
    assert body.rigid_modes.shape[1] == 6
    assert digest(body) == before
    assert digest(pickle.loads(pickle.dumps(body))) == before


def test_neighbours_are_not_mixed_up() -> None:
    values = [("ab", "c"), ("a", "bc"), ["ab", "c"], 1, 1.0, True, "1", None, (), [], {}, b"1"]
    values += [np.zeros(2), np.zeros((2, 1)), np.zeros(2, np.float32), np.zeros(4), {1, 2}, {1, 3}]
    assert len({digest(value) for value in values}) == len(values)


def test_functions_count_by_their_names_and_the_key() -> None:
    value = {"law": ao.UserLaw(math.sin), "keep": math.cos}
    with pytest.raises(ao.InputTypeError, match="key="):
        digest(value)
    assert Digests("1").of(value) == Digests("1").of(dict(value))
    assert Digests("1").of(value) != Digests("2").of(value)
    assert Digests("1").of(math.sin) != Digests("1").of(math.cos)


def test_the_same_in_another_process_and_order() -> None:
    code = (
        "import aoimpact as ao; from aoimpact.batch import Digests;"
        "print(Digests(None).of({'b': 'x', 'a': ao.Hertz(k=2.0)}))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == digest({"a": ao.Hertz(k=2.0), "b": "x"})


def test_what_cannot_be_looked_into_is_refused_by_name() -> None:
    loop: list[Any] = [1]
    loop.append(loop)
    for value in (loop, {"law": (i for i in range(3))}):
        with pytest.raises(ao.InputTypeError, match=r"^case"):
            digest(value)


def test_scenes_built_anew_are_the_same() -> None:
    """Their handles belong to different ones, which says nothing of what is simulated."""

    def built(gap: float) -> tuple[ao.Scene, Handle]:
        scene = ao.Scene()
        ball, wall = scene.add(ao.rigid(mass=1.0), velocity=1.0), scene.add(ao.rigid(mass=math.inf))
        scene.connect(ball, wall, ao.Hertz(k=1e9), gap=gap)
        return scene, ball

    assert Digests(None).of(built(0.0)) == Digests(None).of(built(0.0))
    assert Digests(None).of(built(0.0)) != Digests(None).of(built(1e-3))
