"""Static stiffness of bodies that are held in part, or hardly at all, against beam and lever."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)


@pytest.mark.parametrize("solver", ["superlu", pytest.param("multigrid", marks=pytest.mark.slow)])
def test_a_thin_beam_on_two_supports_that_is_free_to_slide_sideways(solver: str) -> None:
    """48 EI/L³, whatever slow bending there is beside the motion that nothing resists."""
    h = 0.002
    beam = ao.FEModel.from_mesh(
        ao.box_mesh((1.0, h, h), (60, 1, 1), kind="hexahedron20"),
        STEEL,
        fixed=[
            (lambda x: (x[:, 0] == 0.0) & (x[:, 2] == 0.0), "xz"),
            (lambda x: (x[:, 0] == 1.0) & (x[:, 2] == 0.0), "z"),
        ],
    )
    assert beam.rigid_modes.shape[1] == 1
    tip = beam.contact(point=(0.5, h, h), direction=(0, 0, -1), radius=0)
    star = ao.antioscillators(tip, 2, method="krylov", contact_time=1e-3, solver=solver)
    assert star.k0 == pytest.approx(48.0 * STEEL.E * h**4 / 12.0, rel=2e-3)


@pytest.mark.parametrize("spring", [10.0, 1e4])
@pytest.mark.parametrize("method", ["krylov", "eigen"])
def test_a_block_on_soft_springs_is_a_lever(spring: float, method: str) -> None:
    """Struck beside the middle of four springs: 1/k = 1/(4 k_s) + e²/(4 k_s a²)."""
    mesh = ao.box_mesh((0.1, 0.08, 0.06), (4, 3, 3))
    block = ao.FEModel.from_mesh(mesh, STEEL)
    corner = np.isin(mesh.nodes[:, 0], (0.0, 0.1)) & np.isin(mesh.nodes[:, 1], (0.0, 0.08))
    below = 3 * np.flatnonzero(corner & (mesh.nodes[:, 2] == 0.0)) + 2
    springs = np.zeros(block.n_dofs)
    springs[below] = spring
    assert len(below) == 4
    body = ao.FEModel(K=block.K + sp.diags_array(springs), M=block.M, nodes=mesh.nodes)
    struck = (0.05, 0.08 / 3.0, 0.06)
    tip = body.contact(point=struck, direction=(0, 0, -1), radius=0)
    out_of_middle = 0.04 - struck[1]
    lever = 1.0 / (1.0 / (4.0 * spring) + out_of_middle**2 / (4.0 * spring * 0.04**2))
    assert ao.antioscillators(tip, 2, method=method).k0 == pytest.approx(lever, rel=1e-4)


@pytest.mark.parametrize("n", [3, 20])
def test_a_needle_under_a_blow_that_is_short_for_it_is_no_mechanism(n: int) -> None:
    """3 EI/L³, though its own motions span more than twelve decades of stiffness."""
    h = 0.002
    mesh = ao.box_mesh((1.0, h, h), (60, 1, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])
    tip = body.contact(point=(1.0, h, h), direction=(0, 0, -1), radius=0)
    star = ao.antioscillators(tip, n, method="krylov", contact_time=2e-5)
    assert star.k0 == pytest.approx(3.0 * STEEL.E * h**4 / 12.0, rel=5e-3)
