"""Contents of a table of names and values, as data: kinds of values, and their problems.

Kinds are written short: a text is a number of that unit, a list ``[kind]`` or ``[kind, length]``
a list of values of one kind, a tuple one of several kinds, and a dict a table, in which names that
end in "?" may be left out. Problems are pairs of a place, a tuple of names and numbers from the
top, and a message.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from ..base import nearest
from .toml_lines import Place

Problem = tuple[Place, str]
Root = Mapping[str, Any]


class Kind:
    """A kind of value.

    Parameters
    ----------
    wanted : str
        Its name in messages.
    types : type
        Those of its values.
    """

    def __init__(self, wanted: str, *types: type) -> None:
        self.wanted, self.types = wanted, types

    def fits(self, value: Any) -> bool:
        """True if a value is of this kind's types, whatever may be wrong inside."""
        if isinstance(value, bool):  # which is an int for Python
            return bool in self.types or object in self.types
        return isinstance(value, self.types)

    def problems(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        """Yield what is wrong with a value; `root` is the whole file."""
        if self.fits(value):
            yield from self.inside(value, place, root)
        else:
            yield place, f"must be {self.wanted}, got {_shown(value)}"

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        """Yield what is wrong with a value that fits."""
        return iter(())


def _kind(written: Any) -> Kind:
    """The kind that is written short."""
    if isinstance(written, Kind):
        return written
    if isinstance(written, str):
        return Number(written)
    if isinstance(written, list):
        return Listed(*written)
    return Either(written) if isinstance(written, tuple) else Table(written)


class Number(Kind):
    """A number, integers included, of a unit."""

    def __init__(self, unit: str = "") -> None:
        super().__init__(f"a number ({unit})" if unit else "a number", int, float)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        try:
            float(value)
        except OverflowError:
            yield place, "must be finite, got an integer beyond 1.8e308"


ANYTHING = Kind("a value", object)
FLAG = Kind("true or false", bool)
INTEGER = Kind("a whole number", int)
NUMBER = Number()
TEXT = Kind("text", str)


class Choice(Kind):
    """One of some words."""

    def __init__(self, options: Iterable[str]) -> None:
        self.options = tuple(options)
        super().__init__("one of " + ", ".join(f'"{option}"' for option in self.options), str)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        if value not in self.options:
            hint = nearest(value, self.options)
            yield place, f"must be {self.wanted}, got {_shown(value)}{hint}"


class Reference(Kind):
    """The name of an entry of a table at the top, such as a material."""

    def __init__(self, table: str) -> None:
        self.table = table
        super().__init__(f"a name from [{table}]", str)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        known = root.get(self.table, {})
        names = list(known) if isinstance(known, Mapping) else []
        if value not in names:
            listed = ", ".join(names) or "nothing"
            yield place, f"[{self.table}] has no {value!r}{nearest(value, names)}; it has {listed}"


class Listed(Kind):
    """A list of values of one kind, of any length or of `length`."""

    def __init__(self, of: Any, length: int | None = None) -> None:
        self.of, self.length = _kind(of), length
        each = "" if self.of is ANYTHING else f", each {self.of.wanted}"
        super().__init__(f"a list of {length or 'values'}{each}", list)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        if self.length is not None and len(value) != self.length:
            yield place, f"must have {self.length} entries, got {len(value)}"
        for i, entry in enumerate(value):
            yield from self.of.problems(entry, (*place, i), root)


class Either(Kind):
    """A value of the first of several kinds whose type it has."""

    def __init__(self, kinds: Iterable[Any]) -> None:
        self.kinds = tuple(map(_kind, kinds))
        super().__init__(", or ".join(kind.wanted for kind in self.kinds))

    def fits(self, value: Any) -> bool:
        return any(kind.fits(value) for kind in self.kinds)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        kind = next(kind for kind in self.kinds if kind.fits(value))
        return kind.inside(value, place, root)


class Table(Kind):
    """A table of known keys."""

    def __init__(self, fields: Mapping[str, Any], called: str = "a table") -> None:
        super().__init__(called, Mapping)
        self.fields = {name.rstrip("?"): _kind(of) for name, of in fields.items()}
        self.needed = {name for name in fields if not name.endswith("?")}

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        yield from _unknown(value, self.fields, place)
        for name, kind in self.fields.items():
            if name in value:
                yield from kind.problems(value[name], (*place, name), root)
            elif name in self.needed:
                yield place, f"{name!r} is missing, {kind.wanted}"


class Variants(Kind):
    """A table of one of several sorts, distinguished by a key of which each has its own.

    `otherwise` is that without any of these keys.
    """

    def __init__(
        self, tables: Mapping[str, Any], otherwise: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__("a table", Mapping)
        self.tables = {mark: Table(fields) for mark, fields in tables.items()}
        self.otherwise = None if otherwise is None else Table(otherwise)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        marks = [mark for mark in self.tables if mark in value]
        if len(marks) == 1:
            yield from self.tables[marks[0]].inside(value, place, root)
        elif marks:
            yield place, f"{' and '.join(map(repr, marks))} exclude each other: keep one of them"
        elif self.otherwise is not None:
            yield from self.otherwise.inside(value, place, root)
        else:
            known = {name: None for table in self.tables.values() for name in table.fields}
            yield from _unknown(value, known, place)
            yield place, f"one of {', '.join(map(repr, self.tables))} is missing"


class Tagged(Kind):
    """A table of one of several sorts, distinguished by the word under one key.

    `otherwise` is that without this key.
    """

    def __init__(self, key: str, tables: Mapping[str, Any], otherwise: Kind | None = None) -> None:
        super().__init__("a table", Mapping)
        self.otherwise = otherwise
        self.key, self.tables = key, {word: _kind(table) for word, table in tables.items()}

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        choice, word = Choice(self.tables), value.get(self.key)
        if self.key not in value and self.otherwise is not None:
            yield from self.otherwise.inside(value, place, root)
        elif self.key not in value:
            yield place, f"{self.key!r} is missing, {choice.wanted}"
        elif not (isinstance(word, str) and word in self.tables):
            yield from choice.problems(word, (*place, self.key), root)
        else:
            rest = {name: entry for name, entry in value.items() if name != self.key}
            yield from self.tables[word].inside(rest, place, root)


class Entries(Kind):
    """Entries under names of the user's choice."""

    def __init__(self, of: Any) -> None:
        super().__init__("a table", Mapping)
        self.of = _kind(of)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        for name, entry in value.items():
            yield from self.of.problems(entry, (*place, name), root)


class Tree(Entries):
    """Entries of one kind in tables of any depth; a table that has `mark` is an entry itself."""

    def __init__(self, of: Any, mark: str) -> None:
        super().__init__(of)
        self.mark = mark

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        for name, entry in value.items():
            branches = isinstance(entry, Mapping) and self.mark not in entry
            kind = self if branches else self.of
            yield from kind.problems(entry, (*place, name), root)


def _unknown(value: Mapping[str, Any], known: Iterable[str], place: Place) -> Iterator[Problem]:
    names = list(known)
    for name in value:
        if name not in names:
            hint = nearest(name, names) or f"; known are {', '.join(names)}"
            yield (*place, name), f"unknown name {name!r}{hint}"


def _shown(value: Any) -> str:
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, (str, int, float)) else f"a {type(value).__name__}"
