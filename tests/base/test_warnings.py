"""Warnings point at the line of the caller that led to them."""

from __future__ import annotations

from typing import Any

import pytest

import aoimpact as ao
from aoimpact.base import warn

# Within the package by its name: through a cached property, and through a callback of NumPy's.
INSIDE = """
import functools
import numpy as np
class Cached:
    @functools.cached_property
    def value(self):
        warn("cached")
def mapped():
    np.apply_along_axis(lambda row: warn("mapped") or 0.0, 0, np.zeros((2, 1)))
"""


def test_standard_library_and_numpy_in_between_are_passed() -> None:
    inside: dict[str, Any] = {"__name__": "aoimpact.inside", "warn": warn}
    exec(INSIDE, inside)
    for use in (lambda: inside["Cached"]().value, lambda: inside["mapped"]()):
        with pytest.warns(ao.AOImpactWarning) as caught:
            use()
        assert (caught[0].filename, caught[0].lineno) == (__file__, use.__code__.co_firstlineno)
