"""Dataclasses that check what they are made of, and whose arrays cannot be written to."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .checks import instance

__all__ = ["Frozen", "checked"]

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
        for value in vars(self).values():
            _freeze(value)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        Frozen.__post_init__(self)


def _freeze(value: Any) -> None:
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, tuple | dict):
        for item in value.values() if isinstance(value, dict) else value:
            _freeze(item)
