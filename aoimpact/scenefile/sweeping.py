"""The [sweep] of a scene file: ranges of values, by the places in the file that they replace."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..base import InputError, choice, integer, nearest, positive, real
from .binding import Reader, Table
from .lines import Place

# More values of one place than these are a slip of the pen.
_MOST_VALUES = 1_000_000


def _range(start: float, to: float, count: int, spacing: str = "linear") -> list[Any]:
    """Return values from the first to the last; whole numbers where the steps are whole."""
    integer("count", count, low=1, high=_MOST_VALUES)
    log = choice("spacing", spacing, ("linear", "log")) == "log"
    for name, end in (("from", start), ("to", to)):
        (positive if log else real)(name, end)
    found = (np.geomspace if log else np.linspace)(start, to, count)
    whole = isinstance(start, int) and isinstance(to, int) and (found == np.rint(found)).all()
    return list((found.astype(int) if whole and not log else found).tolist())


_RANGE = Table(_range, {"from": "start"})


def _read_over(binder: Any, value: Any, place: Place) -> dict[str, Any]:
    """Values by the dotted name of their place, a list or the call of a range."""
    found: dict[str, Any] = {}
    for key, entry in value.items():
        at = (*place, key)
        name = ".".join(map(str, at[2:]))
        if isinstance(entry, dict) and "from" not in entry:
            found |= _read_over(binder, entry, at)
        elif isinstance(entry, dict):
            found[name], binder.swept[name] = binder.bind(_RANGE, entry, at), at
        elif isinstance(entry, list) and entry:
            found[name], binder.swept[name] = entry, at
        else:
            binder.say(at, "must be a list of values, or { from = 0.0, to = 1.0, count = 5 }")
    if not value:
        binder.say(place, "names nothing to sweep over, such as velocity = [0.5, 1.0]")
    return found


OVER = Reader("a table", (dict,), _read_over)


def place_of(data: Mapping[str, Any], kind: str, name: str) -> Place:
    """Return the place in a file of a dotted name; it starts in the impact or scene by default.

    Raises
    ------
    InputError
        If there is no such table.
    """
    parts = name.split(".")
    if parts[0] not in (kind, "title", "materials", "bodies"):
        parts.insert(0, kind)
    inside: Any = data
    place: list[str | int] = []
    for i, part in enumerate(parts):
        table = isinstance(inside, dict)
        known = {key: key for key in inside} if table else dict(_numbered(inside))
        if part not in known and not (table and i == len(parts) - 1):  # where a key may be new
            there = f"; there are {', '.join(known)}" if known else ""
            raise InputError(f"the file has no {part!r} there{nearest(part, known) or there}")
        place.append(known.get(part, part))
        inside = inside[place[-1]] if part in known else None
    return tuple(place)


def _numbered(entries: Any) -> Iterator[tuple[str, int]]:
    """Names of the entries of a list: their numbers, and of bodies in a scene their names."""
    entries = entries if isinstance(entries, list) else []
    for i, entry in enumerate(entries):
        yield str(i), i
        if isinstance(entry, dict) and isinstance(entry.get("body"), str):
            yield str(entry.get("name", entry["body"])), i
