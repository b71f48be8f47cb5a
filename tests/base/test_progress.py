"""Progress bars appear where somebody looks, after a second, and show what is done within."""

from __future__ import annotations

import sys
import time

import pytest

import aoimpact as ao
from aoimpact.base import advance, bar

Captured = pytest.CaptureFixture[str]


def test_what_is_within_is_shown_below(capsys: Captured, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with bar("models", unit="solution"), bar("multigrid", 4.0) as inner:
        for _ in range(4):
            time.sleep(0.4)
            inner.update()
            advance("solution")
            advance("cow")  # which it does not count
    seen = capsys.readouterr().err
    assert "models" in seen
    assert "multigrid:  75%" in seen
    assert "3 solution" in seen
    assert "cow" not in seen
    assert seen.endswith("\r")  # it is taken away


def test_building_a_model_counts_its_solutions(
    capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    mesh = ao.box_mesh((0.2, 0.1, 0.01), (16, 8, 1), kind="hexahedron20")
    plate = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.33, 2700), fixed=[("xmin", "xyz")])
    tip = plate.contact(point=(0.1, 0.05, 0.01), radius=0)
    with bar("models", unit="solution") as shown:
        ao.antioscillators(tip, 12, method="krylov", contact_time=1e-4)
    assert shown.n >= 12
