"""Published calculations: code_aster's SDNL32, and Shivakumar's ball on a clamped disc."""

from __future__ import annotations

import math

import numpy as np
import pytest

import aoimpact as ao

from slender import beam


def pinned_beam(elements: int) -> ao.FEModel:
    """Euler and Bernoulli's beam of SDNL32; the first node cannot deflect."""
    K, M = beam(elements, fixed=[0])
    length, side = 0.783, 14e-3
    bending, mass = 67e9 * side**4 / 12.0 / length**3, 2400.0 * side**2 * length
    return ao.FEModel(K=bending * K, M=mass * M, damping=ao.ModalDamping(0.01))


@pytest.mark.filterwarnings("ignore:.*the centre of mass")
@pytest.mark.filterwarnings("ignore:.*ends in contact")
@pytest.mark.parametrize(
    ("stiffness", "tip_mm", "when", "force"),
    [
        (
            18e3,
            "-2.66 -4.33 -4.92 -4.78 -3.82 -2.87 -2.71 -3.09 -3.41 -3.36 -2.64 -0.742",
            12e-3,
            13.369,
        ),
        (
            45e3,
            "-2.25 -2.66 -1.96 -1.15 -0.124 -0.364 -2.01 -2.74 -1.89 -0.352 1.70 4.99",
            10e-3,
            15.842,
        ),
    ],
)
def test_a_rotating_beam_meets_a_spring(
    stiffness: float, tip_mm: str, when: float, force: float
) -> None:
    """Tip within 1 % of its largest deflection, force within as much deflection times stiffness."""
    body = pinned_beam(20)
    hit = ao.simulate(
        projectile=ao.modal(body.contact(dof=body.n_dofs - 2), 10),
        target=ao.rigid(mass=math.inf),
        velocity=3.8 * 0.783,
        law=ao.Linear(k=stiffness),
        duration=12e-3,
    )
    known = np.array(tip_mm.split(), float)
    away = 0.01 * np.abs(known).max()
    found = -1e3 * hit.at(1e-3 * np.arange(1, 13)).projectile.displacement
    np.testing.assert_allclose(found, known, atol=away)
    assert hit.at([when]).force[0] == pytest.approx(force, abs=1e-3 * away * stiffness)


@pytest.mark.slow
def test_a_ball_on_a_clamped_disc() -> None:
    """NASA TM-85703, fig. 7: 0.607 ms, within what is said of the duration and 1 % of theirs."""
    radius, h = 0.038, 0.0032
    mesh = ao.box_mesh((2.0, 2.0, 1.0), (10, 10, 2), kind="hexahedron20")
    x, y, z = (mesh.nodes - [1.0, 1.0, 0.0]).T
    round_x, round_y = x * np.sqrt(1 - 0.5 * y * y), y * np.sqrt(1 - 0.5 * x * x)
    nodes = np.column_stack([radius * round_x, radius * round_y, h * z])
    rim = np.flatnonzero(np.maximum(abs(x), abs(y)) > 1 - 1e-9)
    disc = ao.FEModel.from_mesh(
        ao.Mesh(nodes, mesh.cells, mesh.kind, {"rim": rim}),
        ao.Material(E=68.95e9, nu=0.33, rho=2768),
        fixed=[("rim", "xyz")],
    )
    hit = ao.simulate(
        ao.ball(0.019, ao.Material(E=199.95e9, nu=0.3, rho=7971.8)),
        disc.contact(point=(0, 0, h)),
        2.54,
        quantity="contact_duration",
    )
    assert hit.error.total is not None
    assert abs(hit.contact_duration / 0.607e-3 - 1.0) < hit.error.total + 0.01
    assert abs(hit.contact_duration / 0.607e-3 - 1.0) < 0.03
