"""What the compliance of a contact point leaves out, against finer meshes and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from aoimpact.accuracy import ComplianceError, best_radius, compliance_error
from aoimpact.base.errors import InputError, InputTypeError
from aoimpact.fem.contact import contact_at
from aoimpact.fem.material import Material
from aoimpact.fem.model import FEModel
from aoimpact.fields import energy_error
from aoimpact.mesh.generate import box_mesh, sphere_mesh
from aoimpact.reduction.reduction import antioscillators
from aoimpact.reduction.star import rigid

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
BALL = FEModel.from_mesh(sphere_mesh(0.01, 0.0045), STEEL)
FINE = FEModel.from_mesh(sphere_mesh(0.01, 0.0030), STEEL)
POLE, TIME, SHIFT2 = (0.01, 0.0, 0.0), 60e-6, (10.0 / 60e-6) ** 2


def estimated(body: FEModel, radius: float) -> ComplianceError:
    found = compliance_error(body.contact(point=POLE, radius=radius), contact_time=TIME)
    assert found is not None
    return found


@pytest.mark.parametrize("radius", [0.003, 0.004])
def test_the_error_of_the_mesh_is_seen(radius: float) -> None:
    coarse, fine = estimated(BALL, radius), estimated(FINE, radius)
    true = fine.compliance - coarse.compliance
    assert true < coarse.mesh < 4.0 * true


def test_a_linear_field_has_no_error() -> None:
    mesh = box_mesh((1.0, 1.0, 1.0), (2, 2, 2), kind="tetra10")
    gradient = np.random.default_rng(1).normal(size=(3, 3))
    scale = STEEL.E * (gradient**2).sum()
    assert energy_error(mesh, STEEL, mesh.nodes @ gradient).max() < 1e-20 * scale


def test_a_model_of_few_oscillators_knows_its_own_deflection() -> None:
    tip = BALL.contact(point=POLE, radius=0.003)
    model = antioscillators(tip, n=4, method="krylov", contact_time=TIME)
    of_model = compliance_error(model, contact_time=2.0 * TIME)
    assert of_model is not None
    assert of_model.mesh == pytest.approx(estimated(BALL, 0.003).mesh, rel=1e-6)


def test_what_has_no_mesh_is_not_known() -> None:
    assert compliance_error(rigid(1.0), contact_time=TIME) is None
    bare = FEModel(K=np.array([[2.0]]), M=np.array([[1.0]]))
    assert compliance_error(bare.contact(dof=0), contact_time=TIME) is None
    with pytest.raises(InputTypeError, match="must be a contact point"):
        compliance_error(3, contact_time=TIME)
    with pytest.raises(InputError, match="not on the surface of a mesh"):
        best_radius(bare.contact(dof=0), contact_time=TIME, contact_radius=1e-3)


def test_the_best_radius_is_between_contact_and_body() -> None:
    tip = BALL.contact(point=POLE)
    found = best_radius(tip, contact_time=TIME, contact_radius=0.0003)
    assert 0.0003 < found < 0.008
    assert contact_at(tip, found).patch is not None
