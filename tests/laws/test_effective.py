"""With the meshes' own compliance out of the law, the force between solids forgets the mesh."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from paperbodies import RESOLVED_DURATION, RESOLVED_FORCE

import aoimpact as ao
from aoimpact.base import LawLimitError
from aoimpact.results import QUANTITIES

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800.0)
LAW = ao.Hertz.between(STEEL, 0.01, STEEL, 0.01)
SCENE: dict[str, Any] = {"velocity": 1.0, "duration": 100e-6}


@cache
def ball(mesh: str) -> ao.FEModel:
    made = {"paper": ao.paper_sphere_mesh, "coarse": lambda: ao.sphere_mesh(0.01, 0.008)}[mesh]()
    return ao.FEModel.from_mesh(made, STEEL)


@cache
def tip(mesh: str, radius: float) -> ao.ContactPoint:
    return ball(mesh).contact(point=(0.01, 0, 0), direction=(1, 0, 0), radius=radius)


@cache
def sphere(mesh: str, radius: float) -> ao.AOModel:
    return ao.antioscillators(tip(mesh, radius), n=1, method="krylov", contact_time=60e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mesh", "radius"),
    [("coarse", 0.0), ("coarse", 0.0045), ("paper", 0.0), ("paper", 0.002), ("paper", 0.004)],
)
def test_two_spheres_meet_as_the_resolved_contact_does(mesh: str, radius: float) -> None:
    """Over a patch of any radius, and at a single node."""
    body = ao.antioscillators(tip(mesh, radius), n=4, method="krylov", contact_time=60e-6)
    hit = ao.simulate(projectile=body, target=body, law=LAW, **SCENE)
    assert hit.peak_force == pytest.approx(RESOLVED_FORCE, rel=3e-3)
    assert hit.contact_duration == pytest.approx(RESOLVED_DURATION, rel=3e-3)
    assert hit.restitution == pytest.approx(1.0, abs=3e-4)
    assert hit.error.energy == pytest.approx(0.0, abs=1e-7)


def test_a_single_node_under_a_law_that_leaves_out_its_indentation_is_a_sixth_off() -> None:
    """As the paper has it: the node's own compliance in series with Hertz's."""
    body, law = sphere("paper", 0.0), ao.PowerLaw(LAW.k, 1.5)
    hit = ao.simulate(projectile=body, target=body, law=law, **SCENE)
    assert hit.peak_force < 0.85 * RESOLVED_FORCE


@pytest.mark.parametrize(
    "law",
    [ao.PowerLaw(k=LAW.k, n=1.5), ao.HuntCrossley(k=LAW.k, damping=0.2), ao.PowerLaw(k=1e9, n=1.3)],
)
def test_any_law_forgets_the_mesh(law: ao.ContactLaw) -> None:
    peaks = []
    for mesh, radius in (("coarse", 0.0045), ("paper", 0.003)):
        body = sphere(mesh, radius)
        hit = ao.simulate(
            projectile=body, target=body, law=law, solver=ao.Newmark(dt=0.05e-6), **SCENE
        )
        peaks.append(hit.peak_force)
    assert np.ptp(peaks) < 5e-3 * min(peaks)


@pytest.mark.filterwarnings("ignore:.*an error of .* in the")  # of the mesh, which all models share
@pytest.mark.parametrize(
    "rtol", [1e-2, *(pytest.param(of, marks=pytest.mark.slow) for of in (1e-1, 1e-3))]
)
def test_models_chosen_for_a_tolerance_meet_as_the_whole_bodies_do(rtol: float) -> None:
    """Over the same patches; rigid ones have none, and theirs stays in the law."""
    ball = tip("coarse", 0.0045)
    every = ao.antioscillators(ball)
    whole = ao.simulate(projectile=every, target=every, law=LAW, **SCENE)
    for quantity in ("force", "target_displacement"):
        hit = ao.simulate(
            projectile=ball, target=ball, law=LAW, **SCENE, quantity=quantity, rtol=rtol
        )
        # The models given were fitted to the patch, these to the contact upon it.
        assert QUANTITIES[quantity].difference(hit, whole) <= rtol + hit.error.contact
        assert hit.error.model is not None
        assert hit.error.model <= rtol
        assert hit.models is not None
        for model in hit.models:
            touched = model.touched_at()
            assert (touched and touched.patch) is (None if model.label == "wall" else ball.patch)


# ------------------------------------------------------------------------- too wide a contact


BALL = ao.rigid(mass=0.1)


@cache
def block(divisions: tuple[int, int, int], radius: float) -> ao.AOModel:
    """A block of 100 by 100 by 50 mm, fitted to an impact in the middle of its top."""
    mesh = ao.box_mesh((0.1, 0.1, 0.05), divisions, kind="hexahedron20")
    place = ao.FEModel.from_mesh(mesh, STEEL).contact(point=(0.05, 0.05, 0.05), radius=radius)
    return ao.antioscillators(place, n=5, method="krylov", contact_time=30e-6)


@pytest.mark.parametrize("solver", [None, ao.Newmark(dt=2e-8)])
def test_a_contact_wider_than_its_patch_is_refused_with_a_radius_that_will_do(
    solver: ao.Newmark | None,
) -> None:
    law = ao.Hertz.between(STEEL, 0.5, STEEL, float("inf"))
    scene: dict[str, Any] = {"law": law, "velocity": 50.0, "duration": 40e-6, "solver": solver}

    def strike(radius: float) -> float:
        return ao.simulate(
            projectile=BALL, target=block((6, 6, 3), radius), **scene
        ).indentation.max()

    words = r"leaves nothing of the law; give .* radius=(\S+) m or more"
    with pytest.raises(LawLimitError, match=words) as says:
        strike(0.006)
    told = float(str(says.value).rpartition("radius=")[2].split(" ")[0])
    assert 0.006 < told < 0.015
    assert strike(told) > 0.0


def test_a_law_stiffer_than_the_meshes_is_refused() -> None:
    body = sphere("paper", 0.003)
    words = r"^law"
    with pytest.raises(ao.InputError, match=words):
        ao.simulate(projectile=body, target=body, law=ao.Linear(k=1e10), **SCENE)


def test_a_contact_that_yields_only_beyond_the_patch_is_hertzs():
    body = sphere("paper", 0.003)
    elastic = ao.simulate(projectile=body, target=body, law=LAW, **SCENE)
    for force in (1e5, 1e7, 1e9):
        plastic = ao.simulate(projectile=body, target=body, law=ao.Thornton(LAW.k, force), **SCENE)
        assert plastic.peak_force == pytest.approx(elastic.peak_force, rel=1e-9)


@pytest.mark.filterwarnings("ignore:.*too coarse")
@pytest.mark.parametrize("solver", [ao.Adaptive(rtol=1e-6), ao.Newmark(dt=1e-7)])
def test_a_damped_law_that_is_too_steep_for_its_patch_is_refused(solver):
    """Where c dF/dδ would pass 1 at the rate of the impact no law is left."""
    law = ao.HuntCrossley.from_restitution(LAW.k, 0.03, 1.0)
    body = sphere("paper", 0.0015)
    with pytest.raises(LawLimitError, match=r"^contact"):
        ao.simulate(projectile=body, target=body, law=law, **(SCENE | {"solver": solver}))
    patched = ao.KuwabaraKono(LAW.k, 1e-3).within_patch(1.7e-9)
    with pytest.raises(LawLimitError, match="beyond"):
        patched.force(1e-5, 20.0)


# ------------------------------------------------- what a law knows of its width is part of it

WIDTH = 0.005


def test_laws_of_surfaces_know_their_width() -> None:
    modulus = 105e9 / 0.91
    for law in (
        ao.Hertz.between(STEEL, 0.01, STEEL, 0.01),
        ao.Thornton.between(STEEL, 0.01, STEEL, 0.01, yield_pressure=2e9),
    ):
        assert law.relative_radius == pytest.approx(WIDTH, rel=1e-15)
        assert law.k == pytest.approx(4 / 3 * modulus * np.sqrt(WIDTH), rel=1e-14)
    assert ao.Hertz.between(STEEL, 0.01, STEEL, 0.01) != ao.Hertz(LAW.k)
