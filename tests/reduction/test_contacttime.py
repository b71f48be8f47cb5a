"""The default contact time, of any material: that of the body on the half-space at its contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact import box_mesh

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)


def struck(nu: float, kind: str = "hexahedron20", *, fixed: Any = None) -> ao.ContactPoint:
    mesh = box_mesh((0.03, 0.02, 0.02), (3, 2, 2), kind=kind)
    rubber = ao.Material(E=5e6, nu=nu, rho=1000)
    return ao.FEModel.from_mesh(mesh, rubber, fixed=fixed).contact(
        point=(0.03, 0.02 / 3, 0.02 / 3), direction=(-1, 0, 0), radius=0
    )


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
@pytest.mark.parametrize(
    "nu", [*(pytest.param(nu, marks=pytest.mark.slow) for nu in (0.3, 0.49)), 0.4999]
)
@pytest.mark.parametrize("fixed", [None, [("xmin", "xyz")]], ids=["free", "held"])
def test_six_antioscillators_give_the_force_on_any_material(nu: float, fixed: Any) -> None:
    """By the body's own contact time, against all constraint modes."""
    tip = struck(nu, fixed=fixed)
    assert tip.body.material is not None
    law = ao.Hertz.between(tip.body.material, 0.01, STEEL, 0.01)

    def force(target: ao.AOModel) -> Any:
        hit = ao.simulate(ao.rigid(mass=0.01), target, 1.0, law=law, duration=6e-3)
        return hit.at(np.linspace(0, 6e-3, 301)).force

    full = force(ao.antioscillators(tip))
    six = force(ao.antioscillators(tip, 6, method="krylov"))
    assert np.abs(six - full).max() <= 0.02 * full.max()
