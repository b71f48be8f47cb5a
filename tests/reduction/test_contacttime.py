"""The default contact time: by shear, where a material hardly compresses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.fem.contacttime import contact_stiffness
from aoimpact.mesh.generate import box_mesh

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)


def struck(nu: float, kind: str = "hexahedron20", *, fixed: Any = None) -> ao.ContactPoint:
    mesh = box_mesh((0.03, 0.02, 0.02), (3, 2, 2), kind=kind)
    rubber = ao.Material(E=5e6, nu=nu, rho=1000)
    return ao.FEModel.from_mesh(mesh, rubber, fixed=fixed).contact(
        point=(0.03, 0.02 / 3, 0.02 / 3), direction=(-1, 0, 0), radius=0
    )


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.45])
def test_it_is_that_of_the_struck_coordinate(nu: float) -> None:
    tip = struck(nu)
    moved = tip.b / (tip.b @ tip.b)
    assert contact_stiffness(tip) == pytest.approx(moved @ (tip.body.K @ moved), rel=1e-12)


@pytest.mark.filterwarnings("ignore:.*elements of first order")
@pytest.mark.parametrize(
    ("kind", "radius"), [("hexahedron", 0.0), ("tetra10", 0.0), ("hexahedron20", 0.0095)]
)
@pytest.mark.parametrize("fixed", [None, [("xmin", "xyz"), ("zmin", "z")]], ids=["free", "held"])
def test_beyond_that_it_grows_with_the_shear_modulus(kind: str, radius: float, fixed: Any) -> None:
    """By elements at the contact alone, however the body is held and its dofs are numbered."""
    reference = struck(0.45, kind, fixed=fixed).body.material
    assert reference is not None
    for nu in (0.4500001, 0.49999):
        tips = [
            struck(each, kind, fixed=fixed).body.contact(
                point=(0.03, 0.01, 0.01), direction=(-1, 0, 0), radius=radius
            )
            for each in (0.45, nu)
        ]
        material = tips[1].body.material
        assert material is not None
        ratio = material.shear_modulus / reference.shear_modulus
        one, other = map(contact_stiffness, tips)
        assert other == pytest.approx(ratio * one, rel=1e-12)


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
@pytest.mark.parametrize("nu", [0.3, 0.49, 0.4999])
@pytest.mark.parametrize("fixed", [None, [("xmin", "xyz")]], ids=["free", "held"])
def test_six_antioscillators_give_the_force_on_any_material(nu: float, fixed: Any) -> None:
    """By the body's own contact time, against all constraint modes."""
    tip = struck(nu, fixed=fixed)
    assert tip.body.material is not None
    law = ao.Hertz.between(tip.body.material, 0.01, STEEL, 0.01)

    def force(target: ao.AOModel) -> Any:
        hit = ao.simulate(
            projectile=ao.rigid(mass=0.01), target=target, law=law, velocity=1.0, duration=6e-3
        )
        return hit.at(np.linspace(0, 6e-3, 301)).force

    full = force(ao.antioscillators(tip))
    six = force(ao.antioscillators(tip, 6, method="krylov"))
    assert np.abs(six - full).max() <= 0.02 * full.max()
