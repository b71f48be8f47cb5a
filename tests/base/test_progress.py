"""Progress bars appear where somebody looks, after a second, and show what is done within."""

from __future__ import annotations

import time

import pytest

import aoimpact as ao
from aoimpact.base import advance, bar, progress

Captured = pytest.CaptureFixture[str]


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "_on_terminal", lambda: True)
    monkeypatch.setattr(progress, "_DELAY", 0.01)
    monkeypatch.setattr(progress, "_CLOCK", 0.02)


def wait_for(words: str, capsys: Captured) -> str:
    """What is written until the words are."""
    seen, end = "", time.perf_counter() + 10.0
    while words not in seen:
        assert time.perf_counter() < end, f"nobody said {words!r}"
        time.sleep(0.01)
        seen += capsys.readouterr().err
    return seen


def test_what_is_within_is_shown_below(terminal: None, capsys: Captured) -> None:
    with bar("models", unit="solution"), bar("multigrid", 4.0) as inner:
        for _ in range(4):
            time.sleep(0.15)
            inner.update()
            advance("solution")
            advance("cow")  # which it does not count
    seen = capsys.readouterr().err
    assert "models" in seen
    assert "multigrid:  50%" in seen
    assert "3 solution" in seen
    assert "cow" not in seen
    assert seen.endswith("\r")  # it is taken away


def test_the_clock_goes_on_while_nothing_is_counted(terminal: None, capsys: Captured) -> None:
    with bar("factors"):
        for _ in range(3):
            wait_for("factors", capsys)


def test_what_is_over_at_once_is_not_shown(
    terminal: None, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "_DELAY", 10.0)
    with bar("models") as shown:
        shown.update()
        time.sleep(0.1)
    assert "models" not in capsys.readouterr().err


def test_notebooks_show_bars_and_logs_do_not(
    capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "_DELAY", 0.01)
    for notebook in (False, True):
        monkeypatch.setattr(progress, "_in_notebook", lambda there=notebook: there)
        with bar("models") as shown:
            time.sleep(0.15)
            shown.update()
        assert ("models" in capsys.readouterr().err) is notebook


def test_building_a_model_counts_its_solutions(terminal: None) -> None:
    mesh = ao.box_mesh((0.2, 0.1, 0.01), (16, 8, 1), kind="hexahedron20")
    plate = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.33, 2700), fixed=[("xmin", "xyz")])
    tip = plate.contact(point=(0.1, 0.05, 0.01), radius=0)
    with bar("models", unit="solution") as shown:
        ao.antioscillators(tip, 12, method="krylov", contact_time=1e-4)
    assert shown.n >= 12


def test_a_failure_takes_the_bar_away(terminal: None, capsys: Captured) -> None:
    with pytest.raises(ZeroDivisionError), bar("models"):
        raise ZeroDivisionError
    capsys.readouterr()
    with bar("others") as shown:
        seen = wait_for("others", capsys)
    assert shown.n == 0.0
    assert "models" not in seen
