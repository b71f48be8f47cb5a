"""What is kept of a result: numbers by their names, or what the caller's function makes of it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..base import InputError, InputTypeError, nearest, sequence
from ..results import QUANTITIES, Result, Run, look_up

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

        These are called name + "_error", which is `ErrorParts.total`, and name + "_controlled":
        1 if the error by the models is below the tolerance, else 0.
        """
        kept = {}
        chosen = isinstance(result, Run) and result.chosen is not None
        error = result.error if chosen else None
        for name in self.names:
            kept[name] = look_up(result, name, "keep")
            if error is not None and name in error:
                kept[f"{name}_error"] = error[name].total
                kept[f"{name}{CONTROLLED}"] = float(error[name].model <= error.rtol)
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
    known = _KNOWN.union(one.name for one in QUANTITIES.values() if not one.is_history)
    for name in names:
        if not isinstance(name, str):
            raise InputTypeError(f"keep must hold names, got {name!r}")
        if not _NAME.fullmatch(name):
            raise InputError(f"keep: {name!r} is no name of a quantity, such as 'peak_force'")
        if (first := name.partition(".")[0]) not in known:
            raise InputError(f"keep: results have no {first!r}{nearest(first, known)}")
    return Named(names)


def _public(thing: Any) -> list[str]:
    fields = getattr(thing, "__dataclass_fields__", {})
    return [name for name in {*dir(thing), *fields} if not name.startswith("_")]


# What the first part of a name may be, beside a quantity.
_KNOWN = frozenset((*_public(Result), *_public(Run)))
