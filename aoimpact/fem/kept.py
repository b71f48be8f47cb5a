"""Results derived from a body that are kept for the next impact on it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from threading import RLock
from typing import Any, TypeVar

T = TypeVar("T")

# A body's patches and reduced models for this many different impacts.
_MOST = 32


class Kept:
    """The results that were last asked for, by their keys."""

    def __init__(self) -> None:
        self._found: dict[Hashable, Any] = {}
        self._lock = RLock()

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what is kept under a key, or else what `make` returns."""
        with self._lock:
            found: T = self._found.pop(key) if key in self._found else make()
            self._found[key] = found
            while len(self._found) > _MOST:
                del self._found[next(iter(self._found))]
        return found
