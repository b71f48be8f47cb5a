"""The error of a displacement field's stress, from its jumps between elements and free surfaces."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from aoimpact import FEModel, Material, box_mesh
from aoimpact.fem import energy_error, missing_energy
from aoimpact.mesh import KINDS

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)


@pytest.mark.parametrize("kind", KINDS)
def test_uniform_stress_has_no_error_beside_its_load(kind: str) -> None:
    body = FEModel.from_mesh(box_mesh((1.0, 0.8, 0.6), (2, 2, 2), kind=kind), STEEL)
    assert body.mesh is not None
    nodes = body.mesh.nodes
    pulled = nodes * [1.0, -STEEL.nu, -STEEL.nu]
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
    return plate, moved, right


def energy(plate: FEModel, moved: npt.NDArray[np.float64]) -> float:
    """Twice the strain energy, J."""
    x = moved.reshape(-1)
    return float(x @ (plate.K @ x))


def test_false_stress_of_a_plate_of_one_layer_is_seen() -> None:
    """Bent both ways linear elements shear, and lack the strain across; of that all are alike."""
    plate, moved, right = bent("hexahedron", 1)
    whole = energy(plate, moved)
    true = whole - right
    none, every = np.zeros(plate.n_dofs // 3, bool), np.ones(plate.n_dofs // 3, bool)
    difference, own = energy_error(plate, moved, none)
    assert own.sum() == pytest.approx(whole)
    assert 0.8 * true < difference.sum() < 1.6 * true
    assert energy_error(plate, moved, every)[0].sum() < 0.5 * true  # without the free surfaces


@pytest.mark.parametrize(("kind", "layers"), [("hexahedron", 2), ("tetra", 1), ("tetra", 2)])
def test_elements_that_lock_lack_more_energy_than_they_have(kind: str, layers: int) -> None:
    """A moment that bends a plate L times too stiff misses L - 1 times what energy it finds."""
    plate, moved, right = bent(kind, layers)
    own = energy(plate, moved)
    true = own * (own / right - 1.0)
    found = missing_energy(*energy_error(plate, moved, np.zeros(plate.n_dofs // 3, bool)))
    assert 0.7 * true < found < 2.0 * true
