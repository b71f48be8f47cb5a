"""Figures: right curves, right units, on the axes given."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from records import HalfSine
from rows import each

import aoimpact as ao

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    yield
    plt.close("all")


METHODS = ["plot_force", "plot_indentation", "plot_energy", "plot_displacement", "plot_interaction"]


@each("method", METHODS)
def test_draws_on_the_axes_given_and_returns_them(method: str) -> None:
    result = HalfSine().result()
    _, ax = plt.subplots()
    draw: Callable[..., Axes] = getattr(result, method)
    assert draw(ax) is ax
    assert draw() is not ax
    for label in (ax.get_xlabel(), ax.get_ylabel()):
        assert re.search(r"\(\S+\)$", label), "an axis without unit"
    getattr(result.at([]), method)()  # without times


@each("method", METHODS)
@each("ax", [3, "red", plt.Figure(), np.empty(2, dtype=object)])
def test_what_is_no_axes_is_refused(method: str, ax: Any) -> None:
    with pytest.raises(ao.InputTypeError, match=r"^ax"):
        getattr(HalfSine().result(), method)(ax)


def test_force_is_drawn_in_its_units() -> None:
    hit = HalfSine()  # 54.8 N over 31.4 ms
    result = hit.result()
    ax = result.plot_force(during="record", label="spring", color="red")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time (ms)", "contact force (N)")
    (line,) = ax.get_lines()
    t, force = 1e-3 * np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    half_sine = hit.peak * np.sin(np.minimum(hit.omega * t, np.pi))
    np.testing.assert_allclose(force, half_sine, atol=1e-6 * hit.peak)
    assert (line.get_label(), line.get_color()) == ("spring", "red")


def test_energies_of_one_body_or_all() -> None:
    result = HalfSine().result()
    whole = _curves(result.plot_energy())
    assert set(whole) == {"kinetic", "elastic (nonlocal)", "contact (local)", "total"}
    target = _curves(result.plot_energy(body="target"))
    assert target["kinetic"][-1] == pytest.approx(1e3 * result.energy.target.kinetic[-1])
    assert "total" not in target
    with pytest.raises(ao.InputError, match="projectile"):
        result.plot_energy(body="sphere")  # type: ignore[arg-type]


def test_interaction_of_rigid_bodies_is_the_law_itself() -> None:
    hit = HalfSine()
    curves = _curves(hit.result().plot_interaction())
    modified, law = curves["modified law"], curves["contact law"]
    assert modified.max() == pytest.approx(hit.peak, rel=1e-5)
    assert law.max() == pytest.approx(hit.k * hit.velocity / hit.omega, rel=1e-5)


def _curves(ax: Axes) -> dict[str, np.ndarray[Any, Any]]:
    return {str(line.get_label()): np.asarray(line.get_ydata()) for line in ax.get_lines()}


def test_four_panels_show_the_contact() -> None:
    hit = HalfSine(gap=0.01)
    axes = hit.result(end=4.0).plot()
    assert axes.shape == (2, 2)
    margin = 0.1 * hit.duration
    for ax in axes.flat:
        low, high = ax.get_xlim()
        assert low == pytest.approx(1e3 * (hit.start - margin), rel=2e-2)
        assert high == pytest.approx(1e3 * (hit.start + hit.duration + margin), rel=2e-2)
    assert [ax.get_ylabel().split(" (")[0] for ax in axes.flat] == [
        "contact force",
        "indentation",
        "displacement",
        "energy",
    ]


def test_panels_without_energies_leave_the_fourth_empty() -> None:
    axes = HalfSine().result(energies=False).plot()
    assert not axes[1, 1].get_lines()


def ringing() -> ao.Result:
    """A rigid ball on a light stiff oscillator, which rings at 159 kHz after the contact."""
    star = ao.AOModel(m0=0.1, k0=1e5, m=[1e-3], k=[1e9])
    law = ao.Hertz(1e9)
    ball = ao.rigid(mass=0.03)
    return ao.simulate(projectile=ball, target=star, law=law, velocity=1.0, duration=5e-3)


def test_no_indentation_is_drawn_while_the_bodies_are_apart() -> None:
    """The gap after parting is far larger, and would leave the indentation flat."""
    ball = ao.rigid(mass=0.03)
    hit = ao.simulate(ball, ball, 1.0, law=ao.Hertz(k=1e10), duration=1e-3)
    depth = hit.plot_indentation(during="record").get_lines()[0].get_ydata()
    assert hit.indentation.min() < -20 * hit.indentation.max()
    assert np.nanmin(depth) >= 0.0
    assert np.nanmax(depth) == pytest.approx(1e6 * hit.indentation.max(), rel=1e-3)  # µm


@each("during", ["contacts", (2e-3, 1e-3), (0.0, 1.0), (0.0,), 3])
def test_a_span_that_is_none_is_refused(during: Any) -> None:
    with pytest.raises(ao.AOImpactError, match="during"):
        ringing().plot_force(during=during)


def test_forty_curves_all_look_different() -> None:
    scene = ao.Scene()
    for i in range(40):
        scene.add(ao.rigid(mass=0.01), velocity=float(i))
    ax = scene.simulate(duration=1e-3).plot_displacement()
    looks = {(line.get_color(), repr(line._unscaled_dash_pattern)) for line in ax.get_lines()}  # type: ignore[attr-defined]
    assert len(looks) == 40
