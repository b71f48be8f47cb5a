"""The [sweep] of a scene file: ranges of values, by the places in the file that they replace."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..base import InputError, nearest, real
from .names import SCENE_FILE
from .schema import Problem
from .toml_lines import Place

# Tables of a file, beside its impact or scene.
_TABLES = ("title", "materials", "bodies")

# More values of one place than these are a slip of the pen.
_MOST_VALUES = 1_000_000


def grid_of(over: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Return the values of each place, by its dotted name as it is written.

    Raises
    ------
    InputError
        If a range or a list has no values.
    """
    return {".".join(place): _values(entry) for place, entry in _leaves(over)}


def sweep_problems(data: Mapping[str, Any], kind: str) -> Iterator[Problem]:
    """Yield what is wrong with the sweep of a file that is otherwise right."""
    over, workers = data["sweep"]["over"], data["sweep"].get("workers", 1)
    if workers < 1:
        yield ("sweep", "workers"), f"must be at least 1, got {workers}"
    if data["sweep"].get("keep") == []:
        yield ("sweep", "keep"), "names nothing: leave it out to keep what the file reports"
    if not over:
        yield ("sweep", "over"), "names nothing to sweep over, such as velocity = [0.5, 1.0]"
    base = {name: of for name, of in data.items() if name != "sweep"}
    names: list[tuple[str, ...]] = []
    for name, entry in _leaves(over):
        try:
            names.append(name)
            check_apart(base, kind, names)
            values = _values(entry)
            tried = values if isinstance(entry, list) else [values[0], values[-1]]
            problems = [problem for value in tried for problem in _tried(base, kind, name, value)]
        except InputError as error:
            problems = [str(error)]
        for problem in dict.fromkeys(problems):
            yield ("sweep", "over", *name), problem


def at_place(data: Any, kind: str, name: Sequence[str]) -> tuple[Any, Any]:
    """Return the table or list that holds a place, and its key or number there.

    Raises
    ------
    InputError
        If there is no such table.
    """
    parts = _from_the_top(kind, name)
    for part in parts[:-1]:
        inside = data[_key(data, part)] if _known(data, part) else None
        if not isinstance(inside, (dict, list)):
            names = _names(data)
            has = f"; there are {', '.join(names)}" if names else ""
            raise InputError(f"the file has no table {part!r} there{nearest(part, names) or has}")
        data = inside
    if isinstance(data, list) and not _known(data, parts[-1]):
        raise InputError(f"the list has no entry {parts[-1]!r}: it has {len(data)}, from 0")
    return data, _key(data, parts[-1])


def check_apart(data: Any, kind: str, names: Sequence[Sequence[str]]) -> None:
    """Refuse a last place that overlaps one before it.

    Raises
    ------
    InputError
        Since one would overwrite the other's values.
    """
    *before, last = ([*_resolved(data, kind, name)] for name in names)
    for other, name in zip(before, names, strict=False):
        if all(one == another for one, another in zip(last, other, strict=False)):
            raise InputError(f"is in the same place as {'.'.join(name)!r}: keep one of them")


def _from_the_top(kind: str, name: Sequence[str]) -> list[str]:
    return list(name) if name[0] in (kind, *_TABLES) else [kind, *name]


def _resolved(data: Any, kind: str, name: Sequence[str]) -> Iterator[Any]:
    """The keys and numbers of a place, whichever way it is written."""
    for part in _from_the_top(kind, name):
        known = isinstance(data, (dict, list)) and _known(data, part)
        yield _key(data, part) if known else part
        data = data[_key(data, part)] if known else None


def _leaves(over: Mapping[str, Any], above: tuple[str, ...] = ()) -> Iterator[tuple[Any, Any]]:
    for name, entry in over.items():
        if isinstance(entry, Mapping) and "from" not in entry:
            yield from _leaves(entry, (*above, name))
        else:
            yield (*above, *name.split(".")), entry


def _values(entry: Any) -> list[Any]:
    if isinstance(entry, list):
        if not entry:
            raise InputError("has no values: the sweep is empty")
        return list(entry)
    first, last, count = entry["from"], entry["to"], entry["count"]
    if not 1 <= count <= _MOST_VALUES:
        raise InputError(f"count: must be from 1 to {_MOST_VALUES}, got {count}")
    for end in ("from", "to"):
        real(end, entry[end])
    if entry.get("spacing", "linear") == "log":
        if not (first > 0.0 and last > 0.0):
            raise InputError(f"spacing: 'log' needs from and to above 0, got {first:g}, {last:g}")
        return list(np.geomspace(first, last, count).tolist())
    whole = isinstance(first, int) and isinstance(last, int)
    if whole and (count == 1 or (last - first) % (count - 1) == 0):
        step = (last - first) // (count - 1) if count > 1 else 0
        return [first + step * i for i in range(count)]
    found = np.linspace(first, last, count)
    return list(found.tolist())


def _tried(base: Mapping[str, Any], kind: str, name: Place, value: Any) -> list[str]:
    """Problems of the file that has the value there."""
    data = copy.deepcopy(dict(base))
    table, key = at_place(data, kind, [str(part) for part in name])
    table[key] = value
    return [message for _, message in SCENE_FILE.problems(data, (), data)]


def _known(data: Any, part: str) -> bool:
    if isinstance(data, dict):
        return part in data
    return part in _names(data)


def _names(data: Any) -> list[str]:
    """The keys of a table; of a list its numbers, and the names of its tables."""
    if isinstance(data, dict):
        return list(data)
    called = [_called(entry) for entry in data]
    return [*map(str, range(len(data))), *(name for name in called if name)]


def _key(data: Any, part: str) -> Any:
    if isinstance(data, dict):
        return part
    return int(part) if part.isdigit() else [_called(entry) for entry in data].index(part)


def _called(entry: Any) -> str:
    """The name of a body of a scene."""
    if not isinstance(entry, Mapping) or not isinstance(entry.get("body"), str):
        return ""
    return str(entry.get("name", entry["body"]))
