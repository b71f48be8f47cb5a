"""A reduced model's modes are those of its body: its matrices, weight, motion as a whole."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import aoimpact as ao

MESH = ao.box_mesh((0.2, 0.02, 0.02), (6, 1, 1), kind="hexahedron20")
MATERIAL = ao.Material(E=70e9, nu=0.3, rho=2700)


@cache
def reduced_models(held: bool = True) -> list[ao.Body]:
    body = ao.FEModel.from_mesh(MESH, MATERIAL, fixed=[("xmin", "xyz")] if held else None)
    both = [body.contact(point=(x, 0.01, 0.02), direction=(0, 0, -1), radius=0) for x in (0.2, 0.1)]
    end = both[0]
    return [
        ao.antioscillators(end, 5).modal,
        ao.antioscillators(end, 4, method="krylov", contact_time=1e-4).modal,
        ao.modal(end, 12),
        ao.interface(both, 8, contact_time=1e-4),
    ]


@pytest.mark.parametrize("which", range(4))
@pytest.mark.parametrize("held", [True, False])
def test_modes_are_orthonormal_in_mass_and_stiffness(held: bool, which: int) -> None:
    reduced = reduced_models(held)[which]
    body, size = reduced.body, np.maximum(reduced.omega, 1e-3 * reduced.omega.max())
    mass = reduced.modes.T @ (body.M @ reduced.modes)
    stiffness = reduced.modes.T @ (body.K @ reduced.modes) / np.outer(size, size)
    np.testing.assert_allclose(mass, np.eye(len(size)), atol=1e-6)
    np.testing.assert_allclose(stiffness, np.diag((reduced.omega / size) ** 2), atol=1e-6)


def test_gravity_pulls_at_every_node_with_its_share_of_the_weight() -> None:
    reduced = reduced_models()[0]
    whole = ao.FEModel.from_mesh(reduced.body.mesh, reduced.body.material)
    weight = 9.81 * (whole.M @ whole.translation((0, 0, -1)))
    np.testing.assert_allclose(reduced.loads(9.81)[:, 1], weight[reduced.body.free], atol=1e-12)


@pytest.mark.parametrize("which", range(4))
def test_modes_carry_the_whole_body(which: int) -> None:
    """Struck off its centre a free body also turns; its modes contain its translation."""
    reduced = reduced_models(held=False)[which]
    moved = reduced.expand(reduced.whole.moving)
    np.testing.assert_allclose(moved, reduced.body.translation((0, 0, -1)), atol=1e-9)
