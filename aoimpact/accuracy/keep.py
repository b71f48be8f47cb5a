"""What is kept of a result: numbers by their names, or what the caller's function makes of it."""

from __future__ import annotations

import numbers
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import InputError, InputTypeError, nearest, sequence
from ..integrate import Eventful
from ..results import Result
from .quantities import QUANTITIES

__all__ = ["CONTROLLED", "Keep", "Named", "keeper"]

# Ends the name of a column that says which numbers of another were controlled.
CONTROLLED = "_controlled"

_NAME = re.compile(r"[A-Za-z_]\w*(\.\w+)*")


@dataclass(frozen=True)
class Named:
    """Keeps quantities by name: attributes, dotted, with numbers for places in lists."""

    names: tuple[str, ...]

    def __call__(self, result: Any) -> dict[str, float]:
        """Return them; where models were chosen, with their errors and what was controlled.

        These are called name + "_error", by all that is known (`ErrorEstimate.of`), and name +
        "_controlled": 1 if the error by the models is below the tolerance, else 0.
        """
        kept = {}
        for name in self.names:
            kept[name] = _number(name, _look_up(result, name))
            if name in result.error.numbers:
                kept[f"{name}_error"] = result.error.of(name)
                kept[f"{name}{CONTROLLED}"] = float(result.error.controls(name))
        return kept


Keep = Named | Callable[[Any], Any]


def keeper(keep: Any) -> Keep | None:
    """Return what a caller's `keep` means; None keeps whole results.

    Raises
    ------
    InputError, InputTypeError
        If it is neither a function nor names, or a name is misspelt.
    """
    if keep is None or callable(keep):
        return keep  # type: ignore[no-any-return]
    names = (keep,) if isinstance(keep, str) else keep
    try:
        names = tuple(sequence("keep", names))
    except InputTypeError:
        raise InputTypeError(
            f"keep must be names such as ('peak_force', 'impulse') or a function, got {keep!r}"
        ) from None
    if not names:
        raise InputError("keep has no names: give some, such as ('peak_force', 'impulse')")
    for name in names:
        if not isinstance(name, str):
            raise InputTypeError(f"keep must hold names, got {name!r}")
        if not _NAME.fullmatch(name):
            raise InputError(f"keep: {name!r} is no name of a quantity, such as 'peak_force'")
        if (first := name.partition(".")[0]) not in _KNOWN:
            raise InputError(f"keep: results have no {first!r}{nearest(first, _KNOWN)}")
    return Named(names)


def _look_up(result: Any, name: str) -> Any:
    found = result
    for part in name.split("."):
        try:
            found = found[int(part)] if part.isdigit() else _member(found, part)
        except (AttributeError, IndexError, TypeError):
            raise InputError(
                f"keep: {name!r}: {type(found).__name__} has no {part!r}"
                f"{nearest(part, _public(found))}"
            ) from None
    return found


def _member(found: Any, name: str) -> Any:
    """A quantity of an impact or a contact, or any attribute."""
    quantity = QUANTITIES.get(name)
    if quantity is not None and quantity.number is not None and isinstance(found, Eventful):
        return quantity.number(found)
    return getattr(found, name)


def _public(thing: Any) -> list[str]:
    fields = getattr(thing, "__dataclass_fields__", {})
    return [name for name in {*dir(thing), *fields} if not name.startswith("_")]


# What the first part of a name may be.
_KNOWN = frozenset(
    (*_public(Result), *(one.name for one in QUANTITIES.values() if one.number is not None))
)


def _number(name: str, value: Any) -> float:
    if value is None:  # an error estimate where nothing is known
        return float("nan")
    if isinstance(value, (numbers.Real, np.bool_)):
        return float(value)
    raise InputTypeError(f"keep: {name!r} is no number but {type(value).__name__}; keep=function")
