"""The paper's numbers, and the tables that set the recomputed ones beside them."""

from __future__ import annotations

import csv
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize

import aoimpact as ao
from aoimpact.base import writable_folder
from aoimpact.paper import beam as paper_beam
from aoimpact.paper import reproduce
from aoimpact.paper import sphere as paper_sphere


def by_name(rows: list[Any]) -> dict[str, Any]:
    return {row.quantity: row for row in rows}


# ----------------------------------------------------------------- the paper's beam


def test_beam_has_the_paper_s_matrices() -> None:
    rows = by_name(paper_beam.table_4())
    assert rows["free degrees of freedom"].computed == 1362
    assert rows["mass"].computed == pytest.approx(2400 * 1.0 * 0.02**2 * 1e3, rel=1e-12)
    assert rows["k_H, eq. (16)"].computed == pytest.approx(
        4 / 3 / ((1 - 0.09) / 70e9 + (1 - 0.09) / 210e9) * math.sqrt(0.01) / 1e10, rel=1e-12
    )


def test_beam_frequencies() -> None:
    """Vertical bending has the paper's, except for 315 Hz, and 915 Hz within 1.5 %."""
    rows = by_name(paper_beam.table_5())
    for name in ("58", "233", "520"):
        assert rows[f"{name} Hz, nearest vertical"].verdict in ("agrees", "close")
    assert abs(rows["915 Hz, nearest vertical"].computed / 915 - 1) < 0.015
    assert rows["315 Hz, nearest any mode"].verdict == "differs"
    quadratic = rows["f1, quadratic bricks"].computed
    assert quadratic == pytest.approx(paper_beam.bending_frequency(1), rel=5e-3)


@pytest.mark.slow
def test_beam_oscillators() -> None:
    rows = by_name(paper_beam.oscillators())
    assert rows["static mass"].verdict == "agrees"
    assert rows["first AO of the static mass"].verdict == "agrees"
    assert rows["28 AOs of lowest frequency"].verdict == "agrees"
    assert rows["28 AOs of largest mass"].computed >= 98.0


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*may be off by")  # by the paper's mesh, for 20 ms
def test_sphere_on_beam() -> None:
    """29 dofs for 1362 within 1 %; the rigid sphere moves the beam all the same (Fig. 11)."""
    force, moved = by_name(paper_beam.force()), by_name(paper_beam.displacement())
    assert force["29 or 1362 dofs"].computed < 1.0
    assert moved["29 or 1362 dofs, middle, 200 µs"].computed < 1.0
    assert moved["29 or 1362 dofs, centre of mass, 20 ms"].computed < 1.0
    assert moved["one-AO or rigid sphere, centre of mass, 20 ms"].computed < 2.0
    for name, larger in (("peak force", "rigid"), ("contact duration", "one-AO")):
        smaller = {"rigid": "one-AO", "one-AO": "rigid"}[larger]
        assert (
            force[f"{larger} sphere, {name}"].computed > force[f"{smaller} sphere, {name}"].computed
        )


# ---------------------------------------------------------------- the paper's sphere


def sphere_roots() -> tuple[float, float]:
    """First torsional and spheroidal frequencies of a free sphere for l = 2, as ωR/c_t (Lamb).

    Torsional: tan x = ... from the shear traction (l-1) j_l(x) = x j_{l+1}(x); spheroidal: the
    determinant of normal and shear traction, e.g. Eringen & Suhubi, Elastodynamics II, 8.14.
    """
    from scipy.special import spherical_jn as j

    order = 2
    torsional = scipy.optimize.brentq(
        lambda x: (order - 1) * j(order, x) - x * j(order + 1, x), 1.0, 4.0
    )
    ratio = math.sqrt((1 - 2 * 0.3) / (2 - 2 * 0.3))  # c_t / c_l

    def determinant(x: float) -> float:
        a, b, n = ratio * x, x, order
        t11 = (n * n - n - 0.5 * b * b) * j(n, a) + 2 * a * j(n + 1, a)
        t13 = n * (n + 1) * ((n - 1) * j(n, b) - b * j(n + 1, b))
        t41 = (n - 1) * j(n, a) - a * j(n + 1, a)
        t43 = (n * n - 1 - 0.5 * b * b) * j(n, b) + b * j(n + 1, b)
        return float(t11 * t43 - t13 * t41)

    return torsional, scipy.optimize.brentq(determinant, 2.0, 3.0)


def test_sphere_frequencies() -> None:
    """Table 2, and the exact sphere within the coarse mesh's error."""
    exact = np.array(sphere_roots())
    np.testing.assert_allclose(exact, [2.50113, 2.64622], atol=2e-5)
    rows = by_name(paper_sphere.table_2())
    for name in ("f2", "f3", "f4"):
        assert rows[name].verdict == "agrees"
    speed = paper_sphere.STEEL.shear_speed / (2 * math.pi * paper_sphere.RADIUS)
    computed = [1e6 * rows[name].computed / speed for name in ("f2", "f3")]
    np.testing.assert_allclose(computed, exact, rtol=5e-3)
    assert rows["rigid modes, f1"].computed < 1.0


def test_sphere_oscillator() -> None:
    """Table 3: all but 0.2 % of the mass in one oscillator, nothing on the ground."""
    model = paper_sphere.one_ao()
    assert model.k0 == 0.0
    assert model.m[0] >= 0.998 * model.mass
    assert model.m0 + model.m[0] == pytest.approx(model.mass, rel=1e-9)
    rows = by_name(paper_sphere.table_1())
    assert rows["mass of the finite elements"].computed == pytest.approx(
        1e3 * paper_sphere.BALL_MASS, rel=5e-3
    )


def test_residual_vibration_is_negligible() -> None:
    rows = by_name(paper_sphere.energy())
    assert rows["kinetic energy passed on"].computed == pytest.approx(100.0, abs=0.1)
    assert rows["nonlocal energy left in the target"].computed < 0.1


# --------------------------------------------------------------------- all of it


def test_folder_that_cannot_be_written_is_refused_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ao.InputError):
        reproduce(tmp_path / "file" / "below")
    with pytest.raises(ao.InputError):
        writable_folder("nul\0name" if os.name == "nt" else "/proc/aoimpact")


@pytest.mark.slow
def test_everything_is_written(tmp_path: Path) -> None:
    files = reproduce(tmp_path, progress=False)
    names = {file.name for file in files}
    assert {f"figure_{number:02d}.png" for number in range(3, 12)} <= names
    assert {"results.csv", "results.md"} <= names
    assert all(file.stat().st_size > 500 for file in files)
    with (tmp_path / "results.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 60
    assert all(math.isfinite(float(row["computed"])) for row in rows)
    for number in range(1, 6):
        assert any(f"Table {number}" in row["table"] for row in rows)


def test_printed_oscillator_recomputes_to_its_reference() -> None:
    """The paper's m0 and k1: 814.36921 N and separation at 70.74284 µs by high-order methods."""
    hit = paper_sphere.of_table_3(paper_sphere.BALL_MASS)
    assert hit.peak_force == pytest.approx(814.3692123467, rel=5e-6)
    assert hit.contact_duration == pytest.approx(70.7428420013e-6, rel=1e-5)
