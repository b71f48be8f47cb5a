"""Dataclasses whose arrays cannot be written to."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["Frozen"]


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
