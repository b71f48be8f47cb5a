"""Shells and beams that are probably not what is meant, and contacts beyond their laws."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from thinmeshes import bar

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
BALL = ao.ball(0.005, STEEL)


def clamped(section: Any) -> ao.FEModel:
    """A bar of 1 m, clamped at both ends."""
    return bar(section, STEEL, fixed=[([0, 20], "xyz", "xyz")])


@pytest.mark.parametrize(
    ("section", "warns"),
    [
        (ao.RectangularSection(0.02, 1e-4), True),
        (ao.CircularSection(0.015), False),
    ],
)
def test_a_contact_wider_than_a_beam_is_thick(section: Any, warns: bool) -> None:
    """a = √(δ R) of the law beyond half the thickness."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        tip = clamped(section).contact(point=(0.5, 0, 0), direction=(0, 0, -1))
        ao.simulate(BALL, tip, 1.0, quantity="peak_force")
    said = [each for each in caught if "more than half the thickness" in str(each.message)]
    assert bool(said) == warns


def test_a_force_along_a_beam_between_its_ends_is_questioned() -> None:
    body = clamped(ao.CircularSection(0.01))
    for point in ((0.5, 0, 0), (0.525, 0, 0)):
        with pytest.warns(ao.AOImpactWarning, match=r"^direction"):
            body.contact(point=point, direction=(1, 0, 0))
    body.contact(point=(0.5, 0, 0), direction=(0, 1, 0))


@pytest.mark.parametrize("law", [None, ao.Hertz(1e9)])
@pytest.mark.parametrize("direction", [(0, 0, -1), (0.6, 0, -0.8)])
def test_a_tube_of_beams_is_not_struck_across(law: Any, direction: Any) -> None:
    """Its wall would become oval, and the force be far too large."""
    tip = clamped(ao.TubularSection(0.015, 1e-3)).contact(point=(0.5, 0, 0), direction=direction)
    with pytest.raises(ao.InputError, match=r"^direction"):
        ao.simulate(BALL, tip, 1.0, law=law, duration=1e-4)


def test_a_spring_pushes_a_tube_of_beams_across() -> None:
    """Under a soft spring it moves as the beam of the same section by its numbers."""
    tube, peaks = ao.TubularSection(0.015, 1e-3), []
    for section in (tube, tube.with_nu(0.3)):
        tip = clamped(section).contact(point=(0.5, 0, 0), direction=(0, 0, -1))
        hit = ao.simulate(ao.rigid(0.1), tip, 1.0, law=ao.Linear(1e4), quantity="peak_force")
        peaks.append(hit.peak_force)
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-6)


@pytest.mark.parametrize("section", [ao.CircularSection(0.01), ao.TubularSection(0.01, 2e-3)])
def test_the_end_of_a_round_bar_is_flat(section: Any) -> None:
    tip = bar(section, STEEL, 0.3, 30).contact(node=0, direction=(1, 0, 0))
    hit = ao.simulate(BALL, tip, 0.1, duration=60e-6)
    assert hit.law.k == pytest.approx(ao.Hertz.between(STEEL, 0.005, STEEL, np.inf).k)


@pytest.mark.parametrize("z", [0.0, 4e-3])
def test_a_point_on_the_face_of_a_shell_is_that_of_its_nodes(z: float) -> None:
    """Nodes on the lower face: offset of half the thickness."""
    shell = ao.Shell(4e-3, STEEL, offset=2e-3)
    body = ao.FEModel.from_mesh(
        ao.sheet_mesh((0.1, 0.1), (20, 20)), shell, fixed=[("rim", "xyz", "xyz")]
    )
    assert body.contact(point=(0.05, 0.05, z)).point == pytest.approx([0.05, 0.05, 0.0])
    quantity = ao.StrainAt(body, (0.03, 0.05, z), "xx", layer="bottom")
    assert quantity.layer == "bottom"
    with pytest.raises(ao.InputError, match=r"^point"):
        body.contact(point=(0.05, 0.05, 0.01))


def test_a_point_on_the_side_of_a_beam_is_that_of_its_axis() -> None:
    body = clamped(ao.RectangularSection(0.02, 0.04))
    tip = body.contact(point=(0.5, 0.0, 0.02), direction=(0, 0, -1))
    assert tip.point == pytest.approx([0.5, 0.0, 0.0])
