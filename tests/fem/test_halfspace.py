"""Whether the body about a patch is like a half-space, told by how its compliance moves with r."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import scipy.linalg as la
from bodies import no_solid

from aoimpact.base.errors import InputError
from aoimpact.fem.halfspace import PatchCheck, check_patch
from aoimpact.fem.material import Material
from aoimpact.fem.model import FEModel
from aoimpact.fem.statics import elastic_compliance
from aoimpact.fem.touch import room
from aoimpact.mesh.generate import box_mesh, paper_sphere_mesh, sphere_mesh

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
BALL = FEModel.from_mesh(paper_sphere_mesh(), STEEL)
PLATE = FEModel.from_mesh(box_mesh((0.04, 0.04, 0.008), (8, 8, 2), kind="hexahedron20"), STEEL)


def test_rigid_motion_of_a_free_body_does_not_count() -> None:
    # Its inertia holds a free ball; a hundred times the mass holds it no other way.
    mesh = sphere_mesh(0.01, 0.008)
    small = FEModel.from_mesh(mesh, STEEL)
    heavy = FEModel.from_mesh(mesh, no_solid(E=210e9, rho=780e3))
    tip, weighty = (body.contact(point=(0.01, 0, 0), radius=0.005) for body in (small, heavy))
    assert elastic_compliance(weighty) == pytest.approx(elastic_compliance(tip), rel=1e-9)
    # By all elastic modes, Σ r_j²/ω_j².
    omega2, modes = la.eigh(small.K.toarray(), small.M.toarray())
    share = (modes[:, 6:].T @ tip.b) ** 2 / omega2[6:]
    assert elastic_compliance(tip) == pytest.approx(share.sum(), rel=1e-9)


@pytest.fixture(scope="module")
def ball_check() -> PatchCheck:
    return check_patch(BALL.contact(point=(0.01, 0, 0), radius=0.004))


def test_a_ball_s_remaining_compliance_hardly_moves_with_the_radius(
    ball_check: PatchCheck,
) -> None:
    check = ball_check
    assert check.radii == (0.004, 0.005)
    here, there = check.remaining
    # It tends to -2.04e-10 m/N on fine meshes, by an independent prototype.
    assert here == pytest.approx(-2.04e-10, rel=0.04)
    assert there == pytest.approx(here, rel=0.05)
    assert check.share == pytest.approx(abs(here - there) * 4 * (210e9 / 0.91) * 0.002 / 3)
    assert check.share < 0.01


def test_the_share_is_of_the_contact_that_is_expected(ball_check: PatchCheck) -> None:
    tip = BALL.contact(point=(0.01, 0, 0), radius=0.004)
    assert check_patch(tip, expected=0.001).share == pytest.approx(0.5 * ball_check.share)


def test_a_smaller_patch_is_compared_where_there_is_no_room_for_a_larger() -> None:
    check = check_patch(PLATE.contact(point=(0.0051, 0.02, 0.008), radius=0.005))
    assert check.radii == (0.005, 0.004)


def test_a_contact_without_a_patch_cannot_be_checked() -> None:
    with pytest.raises(InputError, match=r"has no patch; make it with radius="):
        check_patch(BALL.contact(point=(0.01, 0, 0), radius=0))


def test_room_is_the_thickness_and_the_way_to_the_edge() -> None:
    assert PLATE.surface is not None
    about = room(PLATE.surface, np.array([0.007, 0.02, 0.008]), 0.01)
    assert about.depth == pytest.approx(0.008)
    assert about.free == pytest.approx(0.007, rel=0.05)
    assert room(PLATE.surface, np.array([0.02, 0.02, 0.008]), 0.01).free == np.inf
    assert BALL.surface is not None
    assert room(BALL.surface, np.array([0.01, 0, 0]), 0.002).depth == pytest.approx(0.02)


def test_automatic_radius_says_nothing_where_there_is_room() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tip = BALL.contact(point=(0.01, 0, 0), radius="auto", expected=0.0003)
    assert tip.patch is not None
    assert 0.002 < tip.patch.radius < 0.005
