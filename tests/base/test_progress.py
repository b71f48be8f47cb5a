"""Progress bars appear where somebody looks, after a second, and show what is done within."""

from __future__ import annotations

import sys
import time

import pytest

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
