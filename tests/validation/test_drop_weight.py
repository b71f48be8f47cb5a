"""Drop-weight tests of thin laminates and stiffened panels, on shells (ASTM D7136 and the like)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.sparse.linalg
from thinmeshes import grid

import aoimpact as ao

pytestmark = pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")  # of deep contacts

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
CARBON = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
RIM = [(side, "xyz", "xyz") for side in ("xmin", "xmax", "ymin", "ymax")]
DOWN = (0, 0, -1)


def middle(size: tuple[float, float], n: tuple[int, int], layers: Any) -> ao.ContactPoint:
    """The middle of a clamped sheet."""
    body = ao.FEModel.from_mesh(ao.sheet_mesh(size, n), layers, fixed=RIM)
    return body.contact(point=(size[0] / 2, size[1] / 2, 0.0), direction=DOWN)


def static_force(tip: ao.ContactPoint, mass: float, velocity: float) -> float:
    """V √(k m) of a mass on a spring, the panel's own stiffness under a patch of 2.6 mm.

    Plates of first order yield without bound under a point.
    """
    tip = tip.body.contact(point=tip.point, direction=DOWN, radius=2.6e-3)
    yields = float(tip.b @ scipy.sparse.linalg.spsolve(tip.body.K.tocsc(), tip.b))
    return velocity * math.sqrt(mass / yields)


@pytest.mark.parametrize("n", [(20, 12), pytest.param((30, 18), marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("energy", "solids"), [(3.0, 7307.7), pytest.param(5.0, 9583.1, marks=pytest.mark.slow)]
)
def test_a_contact_as_wide_as_half_the_laminate(
    energy: float, solids: float, n: tuple[int, int]
) -> None:
    """Quadratic bricks of the same 5 mm of carbon have these forces, ± 0.6 %."""
    E, t = 53e9, 5.11e-3
    ply = ao.Orthotropic((E, E, 9.5e9), (E / 2.6, 3.94e9, 3.94e9), (0.3, 0.32, 0.32), rho=1590)
    tip = middle((0.125, 0.075), n, ao.Laminate([ao.Ply(t, ply)], fibre_axis=(1, 0, 0)))
    tup = ao.ball(8e-3, STEEL, mass=5.0)
    hit = ao.simulate(tup, tip, math.sqrt(2 * energy / 5.0))
    error = hit.error["peak_force"].total
    assert hit.peak_force == pytest.approx(solids, rel=0.006 + error)
    assert error < 0.015


@pytest.mark.parametrize(
    "energy", [3.0, *(pytest.param(of, marks=pytest.mark.slow) for of in (0.2, 30.0))]
)
@pytest.mark.parametrize("n", [8, pytest.param(34, marks=pytest.mark.slow)])
def test_a_contact_wider_than_the_laminate_is_thick(energy: float, n: int) -> None:
    """2 mm of carbon bend like a spring under 5 kg; Yang and Sun's law loads as Hertz's does.

    The spring, under a patch in which plate theory does not hold, and the indentation take the
    energy. Vibration and the contact's width, up to the thickness, leave it 12 % uncertain; it goes
    as the square of the force, which is claimed.
    """
    half = (45, 0, -45, 90) * 2
    plies = [ao.Ply(0.125e-3, CARBON, angle) for angle in (*half, *half[::-1])]
    layers = ao.Laminate(plies, fibre_axis=(1, 0, 0))
    tup, velocity = ao.ball(8e-3, STEEL, mass=5.0), math.sqrt(2 * energy / 5.0)
    hertz = ao.Hertz.between(STEEL, 8e-3, layers, math.inf)
    yang = ao.YangSun(hertz.k, critical_indentation=8e-5, relative_radius=8e-3)
    tip, coarse = (middle((0.05, 0.05), (of, of), layers) for of in (n, 8))
    for law in (hertz, yang):
        hit = ao.simulate(tup, tip, velocity, law=law, quantity="peak_force")
        force = hit.peak_force
        bending = 0.5 * (force / static_force(coarse, 1.0, 1.0)) ** 2
        indentation = 0.4 * force * (force / hertz.k) ** (2 / 3)
        error = hit.error["peak_force"].total
        assert bending + indentation == pytest.approx(energy, rel=0.12 + 2.0 * error)
        assert error < 0.06


@pytest.mark.slow
def test_yang_and_sun_unload_from_beyond_their_critical_indentation() -> None:
    """The peak is that of Hertz's law, and the rebound slower."""
    ply = ao.Orthotropic((120e9, 7.9e9, 7.9e9), (5.5e9, 5.5e9, 2.7e9), (0.3, 0.3, 0.46), rho=1580)
    plies = [ao.Ply(0.269e-3, ply, a) for a in (0, 90, 0, 90, 0, 0, 90, 0, 90, 0)]
    tip = middle((0.1, 0.1), (20, 20), ao.Laminate(plies, fibre_axis=(1, 0, 0)))
    k = 4 / 3 * 7.9e9 * math.sqrt(6.35e-3)
    hertz = ao.Hertz(k, relative_radius=6.35e-3)
    yang = ao.YangSun(k, critical_indentation=8.03e-5, beta=0.094, relative_radius=6.35e-3)
    one, other = (
        ao.simulate(ao.ball(6.35e-3, STEEL), tip, 12.0, law=law, duration=2e-4)
        for law in (hertz, yang)
    )
    assert other.peak_force == pytest.approx(one.peak_force, rel=5e-3)
    assert other.energy.dissipated[-1] > 0.0


@pytest.mark.parametrize("n", [(32, 6), pytest.param((80, 16), marks=pytest.mark.slow)])
def test_a_heavy_tup_on_a_thin_sheet(n: tuple[int, int]) -> None:
    """Bending sets the force and not the law, and so the claim is of a few per cent."""
    skin = ao.Shell(2e-3, ao.Material(E=50e9, nu=0.3, rho=1550))
    tip = middle((0.4, 0.075), n, skin)
    hit = ao.simulate(ao.ball(0.01, STEEL, mass=2.0), tip, 1.0, quantity="peak_force", rtol=2e-3)
    assert hit.peak_force == pytest.approx(static_force(tip, 2.0, 1.0), rel=0.03)
    assert hit.error["peak_force"].total < 0.06


@pytest.mark.slow
def test_a_stiffened_panel_over_bay_and_blade() -> None:
    """2 mm of carbon with three blades, clamped at two ends, 2 kg at 2 m/s: near V √(k m).

    Indentation takes 1 %. The blade's own inertia adds up to 8 % (its first 120 modes and the rest
    as a spring under Hertz's law).
    """
    parts = [grid(80, 60, lambda r, s: (0.4 * r, 0.3 * s, 0.0))]
    for y in (0.075, 0.15, 0.225):
        parts.append(grid(80, 5, lambda r, s, y=y: (0.4 * r, y, -0.025 * s)))
    first = np.cumsum([0, *(len(nodes) for nodes, *_ in parts)])
    nodes = np.vstack([nodes for nodes, *_ in parts])
    cells = np.vstack([part[1] + start for part, start in zip(parts, first, strict=False)])
    _, kept, back = np.unique(nodes.round(7), axis=0, return_index=True, return_inverse=True)
    half = (45, 0, -45, 90) * 2
    plies = [ao.Ply(0.125e-3, CARBON, angle) for angle in (*half, *half[::-1])]
    panel = ao.FEModel.from_mesh(
        ao.Mesh(nodes[kept], back.ravel()[cells], "quad"),
        ao.Laminate(plies, fibre_axis=(1, 0, 0)),
        fixed=[(lambda x: (x[:, 0] < 1e-9) | (x[:, 0] > 0.4 - 1e-9), "xyz", "xyz")],
        damping=ao.ModalDamping(0.01),
    )
    tup = ao.ball(0.01, STEEL, mass=2.0)
    for y, least, most in ((0.1125, 0.97, 1.01), (0.15, 1.0, 1.08)):
        tip = panel.contact(point=(0.2, y, 0.0), direction=DOWN)
        hit = ao.simulate(tup, tip, 2.0, quantity="peak_force", rtol=0.02)
        error = hit.error["peak_force"].total
        share = hit.peak_force / static_force(tip, 2.0, 2.0)
        assert least * (1 - error) < share < most * (1 + error)
        assert error < 0.1
