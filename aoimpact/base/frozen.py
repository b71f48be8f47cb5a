"""Dataclasses that check what they are made of, and whose arrays cannot be written to."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .checks import instance

# Takes an argument's name and value, and returns the value in the form that is kept.
Check = Callable[[str, Any], Any]


def checked(record: Any, /, **checks: Check | tuple[type[Any], ...]) -> None:
    """Check fields of a frozen dataclass that is being made: by a function, or for classes."""
    for name, check in checks.items():
        value = getattr(record, name)
        if isinstance(check, tuple):
            instance(name, value, *check)
        else:
            object.__setattr__(record, name, check(name, value))


class Frozen:
    """Makes the arrays of a dataclass, and those in its tuples and mappings, read-only.

    Also when it is unpickled or copied: NumPy forgets it then. A class with a `__post_init__` of
    its own calls this one at its end.
    """

    def __post_init__(self) -> None:
        _freeze(vars(self))

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        Frozen.__post_init__(self)


def _freeze(items: tuple[Any, ...] | dict[Any, Any]) -> None:
    for item in items.values() if isinstance(items, dict) else items:
        if isinstance(item, np.ndarray):
            item.flags.writeable = False
        elif isinstance(item, tuple | dict):
            _freeze(item)
