"""Results derived from a body that are kept for the next impact on it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from threading import RLock
from typing import Any, TypeVar

T = TypeVar("T")

# Memory that the models of a body may take, bytes, if each is made of so many vectors; how many
# results are kept at most, and on large bodies at least: two models with their patches.
_BYTES, _VECTORS, _MOST, _LEAST = 2**30, 64, 32, 4


class Kept:
    """The results of a body of so many dofs that were last asked for, by their keys."""

    def __init__(self, dofs: int) -> None:
        self._most = max(_LEAST, min(_MOST, _BYTES // (8 * _VECTORS * dofs)))
        self._found: dict[Hashable, Any] = {}
        self._lock = RLock()

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what is kept under a key, or else what `make` returns."""
        with self._lock:
            found: T = self._found.pop(key) if key in self._found else make()
            self._found[key] = found
            while len(self._found) > self._most:
                del self._found[next(iter(self._found))]
        return found
