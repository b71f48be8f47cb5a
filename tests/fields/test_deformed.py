"""The picture of a deformed body: its whole surface, in place, in its colours."""

from __future__ import annotations

from collections.abc import Iterator

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import pytest
from bodies import distorted_box

import aoimpact as ao
from aoimpact.fields import Field
from aoimpact.fields.deformed import outlines, plot_deformed
from aoimpact.mesh import KINDS

mpl.use("Agg")
import matplotlib.pyplot as plt

FloatArray = npt.NDArray[np.float64]


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    yield
    plt.close("all")


def area(polygon: FloatArray) -> FloatArray:
    """The vector area: its length is the area, its direction the normal."""
    arms = polygon - polygon.mean(axis=0)
    return 0.5 * np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)


@pytest.mark.parametrize("kind", KINDS)
def test_outlines_are_the_whole_surface_and_look_outward(kind: str) -> None:
    mesh = distorted_box(kind, (2.0, 1.5, 1.0))
    drawn = [mesh.nodes[face] for face in outlines(mesh)]
    areas = np.array([area(polygon) for polygon in drawn])
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(2 * (3.0 + 2.0 + 1.5), rel=1e-6)
    outward = np.array([polygon.mean(axis=0) for polygon in drawn]) - [1.0, 0.75, 0.5]
    assert (np.einsum("fi,fi->f", areas, outward) > 0.0).all()


@pytest.mark.parametrize(("scale", "top"), [(None, 1.2), (1e5, 1.2), (0.0, 1.0)])
def test_it_is_enlarged_to_a_tenth_or_as_told(scale: float | None, top: float) -> None:
    mesh = ao.box_mesh((2.0, 1.0, 1.0), (2, 1, 1))
    moved = np.zeros_like(mesh.nodes)
    moved[:, 2] = 1e-6 * mesh.nodes[:, 0]
    ax = plot_deformed(mesh, moved, np.ones(len(moved)), 0.0, scale=scale)
    assert ax.get_zlim() == pytest.approx((0.0, top))


def test_units_time_and_colours_are_said() -> None:
    mesh = ao.box_mesh((0.2, 0.1, 0.1), (2, 1, 1))
    von_mises = 1e8 * mesh.nodes[:, 0]
    ax = plot_deformed(mesh, np.zeros_like(mesh.nodes), von_mises, 25e-6, alpha=0.5)
    assert [axis.get_label_text() for axis in (ax.xaxis, ax.yaxis, ax.zaxis)] == [
        "x (mm)",
        "y (mm)",
        "z (mm)",
    ]
    assert "25 µs" in ax.get_title()
    (drawn,) = ax.collections
    assert drawn.get_alpha() == 0.5
    colours = drawn.get_array()
    assert (colours.min(), colours.max()) == (0.0, 20.0)  # MPa, at the two ends
    told = "von Mises stress (MPa), largest near\n(200, 50, 50) mm"  # the end x = 0.2 m
    assert drawn.colorbar.ax.get_ylabel() == told


def test_colours_mean_the_same_at_all_times() -> None:
    mesh = ao.box_mesh((0.2, 0.1, 0.1), (2, 1, 1))
    stresses = np.array([[1e6], [4e6]]) * np.ones(len(mesh.nodes))
    still = np.zeros_like(mesh.nodes)
    for one in stresses:
        ax = plot_deformed(mesh, still, one, 0.0, all_times=stresses)
        assert ax.collections[0].get_clim() == pytest.approx((0.0, 4.0))  # MPa


def test_labels_of_short_axes_stand_in_the_title() -> None:
    """Ticks of a bar's short sides would overlap."""
    mesh = ao.box_mesh((0.2, 0.02, 0.03), (2, 1, 1))
    ax = plot_deformed(mesh, np.zeros_like(mesh.nodes), np.ones(len(mesh.nodes)), 0.0)
    assert not len(ax.get_yticks()) + len(ax.get_zticks())
    assert ax.get_title().endswith("y from 0 to 20 mm, z from 0 to 30 mm")
    assert len(ax.get_xticks()) > 3


def test_it_draws_on_the_axes_given() -> None:
    mesh = ao.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    ax = plt.figure().add_subplot(projection="3d")
    assert plot_deformed(mesh, np.zeros((8, 3)), np.zeros(8), 0.0, ax) is ax
    with pytest.raises(ao.InputTypeError, match=r"three-dimensional axes, .* got Axes"):
        plot_deformed(mesh, np.zeros((8, 3)), np.zeros(8), 0.0, plt.subplots()[1])


def test_a_body_at_rest_is_drawn_at_rest() -> None:
    """What rounding leaves before the contact was enlarged until it filled the picture."""
    mesh = ao.box_mesh((2.0, 1.0, 1.0), (2, 1, 1))
    body = ao.FEModel.from_mesh(mesh, ao.Material(E=1e9, nu=0.3, rho=1000.0))
    moved = np.random.default_rng(0).standard_normal((2, *mesh.nodes.shape))
    moved[0] *= 1e-31
    moved[1] *= 1e-6
    field = Field(body, np.array([0.0, 1e-3]), moved, np.zeros_like(moved))
    ax = field.plot()
    assert ax.get_xlim() == pytest.approx((0.0, 2.0))
    assert "+ 1 × displacement" in ax.get_title()
    assert ax.collections[0].get_array().max() == 0.0
    assert field.plot(which=1).get_xlim()[1] > 2.01
