"""Mass that elements integrate at few points: the motions that it leaves without mass follow K."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import aoimpact as ao
from aoimpact.reduction import KrylovSpace

# Matrices without a mesh have the indentation of the half-space twice, which is no matter here.
pytestmark = pytest.mark.filterwarnings("ignore:.*with_mesh")


def rod_integrated_at_one_point(n: int) -> tuple[Any, Any]:
    """K and M of n bars in a row, free, of unit stiffness and mass: the zigzag has no mass."""
    ends = np.array([0.5, *[1.0] * (n - 1), 0.5])
    K = sp.diags_array([-1.0, 2.0 * ends, -1.0], offsets=[-1, 0, 1], shape=(n + 1, n + 1))
    M = sp.diags_array([0.25, 0.5 * ends, 0.25], offsets=[-1, 0, 1], shape=(n + 1, n + 1))
    return K.tocsr(), M.tocsr()


@pytest.mark.parametrize("n", [7, 300, 800, 3000, pytest.param(12_000, marks=pytest.mark.slow)])
def test_a_mass_integrated_at_one_point_has_the_frequencies_of_its_closed_form(n: int) -> None:
    """ω = 2 tan(jπ/2n), by a wave exp(i(jπx/n - ωt)) in both; the n-th is infinite."""
    K, M = rod_integrated_at_one_point(n)
    body = ao.FEModel(K=K, M=M)
    assert body.rigid_modes.shape[1] == 1
    exact = np.tan(np.arange(6) * np.pi / (2 * n)) / np.pi
    assert body.frequencies(6) == pytest.approx(exact, rel=1e-8, abs=1e-12)


@pytest.mark.filterwarnings("ignore:.*anti-oscillators carry mass")
def test_every_model_of_a_body_of_singular_mass_gives_its_force() -> None:
    """The star of all oscillators is exact, and Newmark's rule on K and M knows no star."""
    K, M = rod_integrated_at_one_point(60)
    end = ao.FEModel(K=K, M=M).contact(dof=60)
    krylov = ao.antioscillators(end, 59, method="krylov", contact_time=20.0)
    runs: list[tuple[Any, Any]] = [
        (ao.antioscillators(end), None),
        (krylov, None),
        (ao.full(end), ao.Newmark(dt=1e-2)),
    ]
    peaks = [
        ao.simulate(
            ao.rigid(10.0), model, 1.0, law=ao.Hertz(0.01), duration=400.0, solver=solver
        ).peak_force
        for model, solver in runs
    ]
    assert peaks == pytest.approx([peaks[0]] * 3, rel=1e-4)


def test_vectors_without_mass_end_a_krylov_space() -> None:
    """Once, their rounding put the modes before them out of place."""
    K, M = rod_integrated_at_one_point(60)
    space = KrylovSpace(ao.FEModel(K=K, M=M).contact(dof=60), contact_time=20.0)
    model = space.of_vectors(80)
    exact = np.tan(np.arange(6) * np.pi / 120) / np.pi
    assert model.frequencies[:6] == pytest.approx(exact, rel=1e-7, abs=1e-9)
