"""Movies: bodies where they meet, moved by their displacements, drawn as often as asked."""

from __future__ import annotations

import itertools
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.fields import Shown, enlargement
from aoimpact.results import shown_bodies

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
BLOCK = ao.FEModel.from_mesh(
    ao.box_mesh((0.1, 0.08, 0.02), (5, 4, 1), kind="hexahedron20"), STEEL, fixed=[("zmin", "xyz")]
)
TOP = BLOCK.contact(point=(0.05, 0.04, 0.02), radius=0)
BALL = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, 0.008), STEEL)
LAW = ao.Hertz(k=1e10)


def strike(projectile: Any, target: Any = None, **given: Any) -> ao.Result:
    return ao.simulate(
        projectile, ao.antioscillators(TOP, 3) if target is None else target, 1.0, law=LAW, **given
    )


@cache
def turned_ball() -> Any:
    """Struck along x: it has to be turned into the block's -z."""
    return ao.antioscillators(
        BALL.contact(point=(0.01, 0, 0), radius=0), 1, method="krylov", contact_time=1e-4
    )


def test_the_projectile_is_moved_to_where_it_touches() -> None:
    hit = strike(turned_ball(), gap=1e-4, duration=3e-4)
    bodies, down = shown_bodies(hit, np.array([0.0, 1.5e-4]))
    np.testing.assert_allclose(down, [0.0, 0.0, -1.0], atol=1e-12)
    block, ball = bodies
    np.testing.assert_allclose(block.points.max(axis=0), [0.1, 0.08, 0.02])
    lowest = ball.points[ball.points[:, 2].argmin()]
    np.testing.assert_allclose(lowest, [0.05, 0.04, 0.02 + 1e-4], atol=1e-9)
    middle = 0.5 * (ball.points.min(axis=0) + ball.points.max(axis=0))
    np.testing.assert_allclose(middle, [0.05, 0.04, 0.03 + 1e-4], atol=2e-4)
    # It has come down by the gap and more, as its centre of mass says.
    way = hit.at([1.5e-4]).projectile.centre_displacement[0]
    assert -ball.displacement[1, :, 2].mean() == pytest.approx(way, rel=0.05)
    np.testing.assert_allclose(ball.displacement[0], 0.0, atol=1e-12)


def test_a_rigid_ball_is_drawn_round() -> None:
    hit = strike(ao.ball(0.01, STEEL))
    bodies, _ = shown_bodies(hit, hit.t[[0, -1]])
    ball = bodies[1]
    centre = np.array([0.05, 0.04, 0.03])
    assert np.linalg.norm(ball.points - centre, axis=1).max() == pytest.approx(0.01, rel=1e-6)
    assert np.isnan(ball.von_mises).all()
    way = hit.projectile.centre_displacement[-1]
    np.testing.assert_allclose(ball.displacement[-1, :, 2], -way, rtol=1e-9)


def test_a_mass_without_a_shape_is_not_drawn() -> None:
    hit = strike(ao.rigid(mass=0.03))
    assert len(shown_bodies(hit, hit.t[:1])[0]) == 1
    with pytest.raises(ao.InputError, match="movie"):
        shown_bodies(strike(ao.rigid(mass=0.03), ao.rigid(mass=1.0)), hit.t[:1])


@pytest.mark.parametrize(("largest", "factor"), [(1e-5, 200.0), (3e-7, 5000.0), (0.0, 1.0)])
def test_the_enlargement_is_a_round_number_that_shows_them(largest: float, factor: float) -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.03, 0.0, 0.0]])
    moved = np.zeros((1, 2, 3))
    moved[0, 1, 2] = largest
    assert enlargement([Shown(BLOCK.mesh, points, moved, np.zeros(1))]) == pytest.approx(factor)


@pytest.mark.slow
def test_frames_are_drawn_and_differ(tmp_path: Path) -> None:
    pytest.importorskip("pyvista")
    from PIL import Image, ImageChops

    file = strike(ao.ball(0.01, STEEL)).movie(tmp_path / "impact.gif", frames=3, fps=5)
    with Image.open(file) as movie:
        assert movie.n_frames == 3  # type: ignore[attr-defined]
        assert movie.info["duration"] == 200
        pictures = []
        for i in range(3):
            movie.seek(i)
            pictures.append(movie.convert("RGB"))
    for one, other in itertools.pairwise(pictures):
        assert ImageChops.difference(one, other).getbbox() is not None
    # Neither empty nor cut off at the sides.
    shape = ImageChops.difference(pictures[1], Image.new("RGB", pictures[1].size, "white"))
    left, _, right, low = shape.getbbox() or (0, 0, 0, 0)
    assert 0 < left < 480 < right < 960
    assert low < 720


@pytest.mark.slow
def test_a_still_picture_shows_the_body_in_its_colours() -> None:
    pytest.importorskip("pyvista")
    hit = strike(ao.ball(0.01, STEEL))
    field = hit.target.field([hit.peak_time])
    grid = field.plot(scale=100.0).mesh
    moved = BLOCK.mesh.nodes + 100.0 * field.displacement[0]
    np.testing.assert_allclose(grid.points, moved, atol=1e-7)
    np.testing.assert_allclose(grid["stress"], field.stress().von_mises[0] / 1e6, rtol=1e-6)
