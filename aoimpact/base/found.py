"""Values that are computed when they are read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any


class Found(Mapping[str, Any]):
    """Values by name, each of which is found when it is first read.

    Parameters
    ----------
    names : callable
        Returns the names.
    find : callable
        Returns the value of a name; raises KeyError where there is none.
    known : mapping, optional
        Values that have been found; their names come last.
    """

    def __init__(
        self,
        names: Callable[[], Iterable[str]],
        find: Callable[[str], Any],
        known: Mapping[str, Any] | None = None,
    ) -> None:
        self._names, self._find, self._found = names, find, dict(known or {})

    def __getitem__(self, name: str) -> Any:
        if name not in self._found:
            self._found[name] = self._find(name)
        return self._found[name]

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self._names(), *self._found]))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __reduce__(self) -> Any:
        return dict, (dict(self),)
