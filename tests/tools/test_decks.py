"""Bodies written as decks in many ways, and read again."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest
from campaign import abaqusdecks, nastrandecks


@pytest.mark.parametrize("written", [abaqusdecks, nastrandecks])
@pytest.mark.parametrize(
    "numbers", [range(15), pytest.param(range(15, 300), marks=pytest.mark.slow)], ids=["15", "300"]
)
def test_decks_are_read_as_they_were_meant(
    written: ModuleType, numbers: range, tmp_path: Path
) -> None:
    for number in numbers:
        folder = tmp_path / str(number)
        folder.mkdir()
        assert written.tried(7, number, folder) == "", f"deck {number} of seed 7"
