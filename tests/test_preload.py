"""Bodies at rest on each other bear what is above them, and stay so."""

from __future__ import annotations

import math

import numpy as np
import pytest

import aoimpact as ao

GRAVITY, MASS = 9.81, 0.03


@pytest.mark.parametrize("law", [ao.Hertz(k=1e9), ao.Linear(k=1e5), ao.PowerLaw(k=1e12, n=2.5)])
def test_a_column_bears_its_weight(law: ao.ContactLaw) -> None:
    scene = ao.Scene(gravity=GRAVITY)
    column = [scene.add(ao.rigid(mass=MASS)) for _ in range(5)]
    floor = scene.add(ao.rigid(mass=math.inf))
    for above, below in zip(column, [*column[1:], floor], strict=True):
        scene.connect(above, below, law)
    run = scene.simulate(duration=5e-3, preload=True)
    for i, contact in enumerate(run.contacts):
        np.testing.assert_allclose(contact.force, (i + 1) * MASS * GRAVITY, rtol=1e-9)
    assert run[floor].displacement.max() == 0.0


def test_what_nothing_holds_falls_for_ever() -> None:
    scene = ao.Scene(gravity=GRAVITY)
    scene.add(ao.rigid(mass=MASS))
    with pytest.raises(ao.ConvergenceError, match="falls for ever"):
        scene.simulate(duration=1e-3, preload=True)
