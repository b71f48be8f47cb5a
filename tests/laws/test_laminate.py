"""Yang and Sun's law: closed forms, the dent, and cycles."""

import math

import numpy as np
import pytest
from rigid_pair import on_a_wall

import aoimpact as ao

K, CRITICAL = 1e9, 80e-6
BOTH = [ao.YangSun(K, CRITICAL), ao.YangSun(K, CRITICAL, 0.1)]


def test_the_dent_begins_at_the_critical_indentation():
    for law, deep in zip(BOTH, (3e-4 * (1 - (80 / 300) ** 0.4), 0.1 * 220e-6), strict=True):
        assert law.dent(CRITICAL * (1 - 1e-9)) == (0.0, 0.0)
        assert law.dent(3e-4).depth == pytest.approx(deep, rel=1e-12)
    assert math.isnan(BOTH[0].dent(3e-4).diameter)
    wide = ao.YangSun(K, CRITICAL, relative_radius=0.01).dent(3e-4).diameter
    assert wide == pytest.approx(2 * math.sqrt(0.01 * 3e-4))


@pytest.mark.parametrize("law", BOTH, ids=str)
def test_restitution_is_that_of_the_powers(law):
    """The way in takes F* δ*/2.5 and the way out gives F* (δ* - δ_p)/3.5."""
    deepest = 3e-4
    speed = math.sqrt(2 * 0.4 * K * deepest**2.5 / 0.02)
    wanted = math.sqrt(2.5 / 3.5 * (1 - law.dent(deepest).depth / deepest))
    assert ao.restitution(law, 0.02, speed) == pytest.approx(wanted, rel=1e-12)
    hit = on_a_wall(law, 0.02, speed, ao.Adaptive(rtol=1e-9), duration=2e-3)
    assert hit.restitution == pytest.approx(wanted, abs=1e-8)
    assert hit.dent.depth == pytest.approx(law.dent(deepest).depth, rel=1e-6)


@pytest.mark.parametrize("solver", [ao.Adaptive(rtol=1e-8), ao.Newmark(dt=1e-7)], ids=str)
@pytest.mark.parametrize("law", BOTH, ids=str)
def test_blows_and_ringing_never_give_energy(law, solver):
    """A ringing tup loads and unloads within a blow; a spring throws it back into its dent."""
    tup = ao.AOModel(m0=0.02, k0=0.0, m=[0.2], k=[0.02 * 2.5e4**2])
    plate = ao.AOModel(m0=0.05, k0=2e5, m=[0.05], k=[4e7])
    hit = ao.simulate(tup, plate, 3.0, law=law, duration=6e-3, solver=solver)
    total = hit.energy.total
    assert len(hit.contacts) >= 2
    assert total == pytest.approx(total[0], rel=2e-4 if hit.solver.startswith("N") else 1e-6)
    lost = hit.energy.dissipated
    assert np.diff(lost).min() > -1e-4 * lost[-1]
    assert lost[-1] > 0.05 * total[0]
