"""Bodies written as decks in many ways, and read again."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from types import ModuleType

import pytest
from campaign import abaqusdecks, nastrandecks


@pytest.mark.parametrize("kind", [abaqusdecks, nastrandecks])
@pytest.mark.parametrize(
    "numbers", [range(15), pytest.param(range(15, 300), marks=pytest.mark.slow)], ids=["15", "300"]
)
def test_decks_are_read_as_meant(kind: ModuleType, numbers: range, tmp_path: Path) -> None:
    tried = kind.trial(Namespace(seed=7), tmp_path)
    for number in numbers:
        assert tried(number).why == "", f"deck {number} of seed 7"
