"""What the compliance of a contact point leaves out, against finer meshes and closed forms."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt
import pytest
from bodies import ball_of_octants

from aoimpact.accuracy import ComplianceError, best_radius, compliance_error
from aoimpact.base.errors import InputError, InputTypeError
from aoimpact.fem.contact import contact_at
from aoimpact.fem.material import Material
from aoimpact.fem.model import FEModel
from aoimpact.fields import energy_error, missing_energy
from aoimpact.mesh import KINDS
from aoimpact.mesh.generate import box_mesh, sphere_mesh
from aoimpact.reduction.interface import InterfaceSpace
from aoimpact.reduction.reduction import antioscillators
from aoimpact.reduction.star import rigid

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
POLE, TIME, SHIFT2 = (0.01, 0.0, 0.0), 60e-6, (10.0 / 60e-6) ** 2


@cache
def ball(size: float = 0.0045) -> FEModel:
    return FEModel.from_mesh(sphere_mesh(0.01, size), STEEL)


@cache
def small_ball() -> FEModel:
    return FEModel.from_mesh(ball_of_octants(0.01, 4), STEEL)


@cache
def estimated(size: float, radius: float) -> ComplianceError:
    found = compliance_error(ball(size).contact(point=POLE, radius=radius), contact_time=TIME)
    assert found is not None
    return found


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.003, 0.004])
def test_the_error_of_the_mesh_is_seen(radius: float) -> None:
    coarse, fine = estimated(0.0045, radius), estimated(0.0030, radius)
    true = fine.compliance - coarse.compliance
    assert true < coarse.mesh < 4.0 * true


@pytest.mark.parametrize("kind", KINDS)
def test_uniform_stress_has_no_error_beside_its_load(kind: str) -> None:
    body = FEModel.from_mesh(box_mesh((1.0, 0.8, 0.6), (2, 2, 2), kind=kind), STEEL)
    assert body.mesh is not None
    nodes = body.mesh.nodes
    pulled = (nodes * [1.0, -STEEL.nu, -STEEL.nu]).reshape(-1)
    ends = (nodes[:, 0] == 0.0) | (nodes[:, 0] == 1.0)
    assert energy_error(body, pulled, ends)[0].max() < 1e-20 * STEEL.E
    # Without the load's traction on its ends, all of their stress is wrong.
    assert energy_error(body, pulled, np.zeros(len(nodes), bool))[0].sum() > 0.02 * STEEL.E


def bent(kind: str, layers: int) -> tuple[FEModel, npt.NDArray[np.float64], float]:
    """A plate of linear elements bent both ways, and twice its energy by plate theory, J."""
    plate = FEModel.from_mesh(box_mesh((0.2, 0.2, 0.01), (20, 20, layers), kind=kind), STEEL)
    assert plate.mesh is not None
    x, y, z = plate.mesh.nodes.T
    moved = np.stack([-x * (z - 0.005), -y * (z - 0.005), 0.5 * (x**2 + y**2)], axis=1)
    right = 0.2**2 * 2.0 * STEEL.E / (1.0 - STEEL.nu) * 0.01**3 / 12.0  # plane stress, curvature 1
    return plate, moved.reshape(-1), right


def test_false_stress_of_a_plate_of_one_layer_is_seen() -> None:
    """Bent both ways linear elements shear, and lack the strain across; of that all are alike."""
    plate, moved, right = bent("hexahedron", 1)
    true = float(moved @ (plate.K @ moved)) - right
    none, every = np.zeros(plate.n_dofs // 3, bool), np.ones(plate.n_dofs // 3, bool)
    difference, own = energy_error(plate, moved, none)
    assert own.sum() == pytest.approx(moved @ (plate.K @ moved))
    assert 0.8 * true < difference.sum() < 1.6 * true
    assert energy_error(plate, moved, every)[0].sum() < 0.5 * true  # without the free surfaces


@pytest.mark.parametrize(("kind", "layers"), [("hexahedron", 2), ("tetra", 1), ("tetra", 2)])
def test_elements_that_lock_lack_more_energy_than_they_have(kind: str, layers: int) -> None:
    """A moment that bends a plate L times too stiff misses L - 1 times what energy it finds."""
    plate, moved, right = bent(kind, layers)
    own = float(moved @ (plate.K @ moved))
    true = own * (own / right - 1.0)
    found = missing_energy(*energy_error(plate, moved, np.zeros(plate.n_dofs // 3, bool)))
    assert 0.7 * true < found < 2.0 * true


def test_a_model_of_few_oscillators_knows_its_own_deflection() -> None:
    tip = small_ball().contact(point=POLE, radius=0.004)
    model = antioscillators(tip, n=4, method="krylov", contact_time=TIME)
    for slower, rel in ((1.0, 1e-6), (2.0, 0.02)):
        of_model = compliance_error(model, contact_time=slower * TIME)
        solved = compliance_error(tip, contact_time=slower * TIME)
        assert of_model is not None
        assert solved is not None
        assert of_model.mesh == pytest.approx(solved.mesh, rel=rel)
        assert of_model.strain == pytest.approx(solved.strain, rel=rel)


def test_each_place_of_a_model_of_several_knows_its_own_deflection() -> None:
    places = ((-0.01, 0.005), (0.01, 0.004))
    tips = [small_ball().contact(point=(x, 0.0, 0.0), radius=r) for x, r in places]
    model = InterfaceSpace(tips, contact_time=TIME).of_vectors(10)
    of_model = compliance_error(model, contact_time=TIME, port=1)
    solved = compliance_error(tips[1], contact_time=TIME)
    assert of_model is not None
    assert solved is not None
    assert of_model.mesh == pytest.approx(solved.mesh, rel=1e-6)


def test_a_point_s_own_indentation_is_its_error() -> None:
    node, patch = ball().contact(point=POLE, radius=0), estimated(0.0030, 0.003)
    error = compliance_error(node, contact_time=TIME)
    assert error is not None
    right = patch.compliance - 0.6 / (0.003 * STEEL.plane_strain_modulus)
    assert error.contact == pytest.approx(error.compliance - right, rel=0.03)


def test_on_a_sharp_edge_nothing_is_known() -> None:
    cube = FEModel.from_mesh(box_mesh((0.01, 0.01, 0.01), (3, 3, 3)), STEEL)
    place = (0.01, 0.01 / 3.0, 0.01)
    tip = cube.contact(point=place, direction=(0.0, 0.0, -1.0), radius=0)
    assert compliance_error(tip, contact_time=TIME) is None


def test_what_has_no_mesh_is_not_known() -> None:
    assert compliance_error(rigid(1.0), contact_time=TIME) is None
    bare = FEModel(K=np.array([[2.0]]), M=np.array([[1.0]]))
    assert compliance_error(bare.contact(dof=0), contact_time=TIME) is None
    with pytest.raises(InputTypeError, match="must be a contact point"):
        compliance_error(3, contact_time=TIME)
    with pytest.raises(InputError, match="not on the surface of a mesh"):
        best_radius(bare.contact(dof=0), contact_time=TIME, contact_radius=1e-3)


def test_the_best_radius_is_between_contact_and_body() -> None:
    tip = small_ball().contact(point=POLE)
    found = best_radius(tip, contact_time=TIME, contact_radius=0.0003)
    assert 0.0003 < found < 0.008
    assert contact_at(tip, found).patch is not None
