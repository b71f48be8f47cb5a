"""A modal model under a contact: the law yields for the modes that it leaves out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import aoimpact as ao

from twelve import ALUMINIUM, ENDS, STEEL

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*off the normal"),
    pytest.mark.filterwarnings("ignore:.*the mesh makes an error"),
]

BALL = ao.ball(0.01, STEEL)


def struck(target: Any) -> Any:
    return ao.simulate(projectile=BALL, target=target, velocity=1.0, duration=2.5e-4)


def body(kind: str) -> tuple[ao.FEModel, tuple[float, ...]]:
    """A small body, and the middle of its upper face."""
    if kind == "sheet":
        mesh = ao.sheet_mesh((0.06, 0.05), (8, 7))
        rim = [("xmin", "xyz", "xyz"), ("xmax", "xyz", "xyz")]
        of = ao.Shell(thickness=5e-3, material=ALUMINIUM)
        return ao.FEModel.from_mesh(mesh, of, fixed=rim), (0.03, 0.025, 0.0)
    size, cells, fixed = (0.06, 0.06, 0.03), (3, 3, 2), None
    if kind == "plate":
        size, cells, fixed = (0.08, 0.06, 0.01), (5, 4, 1), ENDS
    mesh = ao.box_mesh(size, cells, kind="hexahedron20")
    made = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=fixed)
    return made, (0.5 * size[0], 0.5 * size[1], size[2])


@pytest.fixture(scope="module", params=["plate", "tilted", "sheet"])
def modes(request: pytest.FixtureRequest) -> ao.Body:
    """All natural modes of a body, which are its full model."""
    made, place = body(request.param)
    tilted = (0.6, 0.0, -0.8) if request.param == "tilted" else None
    tip = made.contact(point=place, direction=tilted)
    massless = made.n_dofs // 6 if request.param == "sheet" else 0  # turning about the normal
    return ao.modal(tip, made.n_dofs - massless)


def test_its_force_is_that_of_all_modes_within_its_error(modes: ao.Body) -> None:
    whole = struck(modes)
    for n in (20, 100):
        hit = struck(modes.truncated(n))
        error = hit.error["peak_force"]
        assert abs(hit.peak_force / whole.peak_force - 1.0) < min(error.mesh + error.contact, 3e-3)
        assert hit.contact_duration == pytest.approx(whole.contact_duration, rel=3e-3)


def test_it_yields_with_the_law_as_the_body_does(modes: ao.Body) -> None:
    """At the frequency s, where Σ r²/(ω² + s²) of all modes is the body's compliance."""
    whole = modes.tips[0].extraction
    terms = modes.participation[0] ** 2 / (modes.omega**2 + whole.s**2)
    for n in (8, 40, modes.n):
        own = modes.truncated(n).extraction_at()
        assert own.removed == pytest.approx(whole.removed - terms[n:].sum(), abs=1e-6 * terms.sum())
        assert own.varying >= whole.varying * (1.0 - 1e-6)


def test_oscillators_of_it_leave_as_much_to_the_law(modes: ao.Body) -> None:
    first = modes.truncated(20)
    one = first.star.truncated(1).modal
    assert one.extraction_at().removed == first.extraction_at().removed


@pytest.mark.slow
def test_the_surface_under_the_contact_moves_as_by_all_modes(modes: ao.Body) -> None:
    """Under patches about as wide as an element: the field of narrower ones takes more modes."""
    (tip,) = modes.tips
    if tip.patch is not None:
        wide = tip.body.contact(point=tip.point, direction=tip.direction, expected=0.01)
        modes = ao.modal(wide, modes.n)
    whole, hit = struck(modes), struck(modes.truncated(60))
    times = whole.peak_time * np.array([0.5, 1.0])
    moved = [of.target.probe(tip.point, times=times).displacement for of in (hit, whole)]
    np.testing.assert_allclose(*moved, atol=0.01 * np.abs(moved[1]).max())


def test_of_several_places_each_has_its_own() -> None:
    made, place = body("plate")
    tips = [made.contact(point=at) for at in (place, (0.03, 0.02, 0.01))]
    several = ao.modal(tips, 20)
    for port, tip in enumerate(tips):
        alone = ao.modal(tip, 20).extraction_at().removed
        assert several.extraction_at(port).removed == pytest.approx(alone, rel=1e-9)
