"""What a table of names and values may contain, as data: kinds of values, and their problems.

Problems are pairs of a place, a tuple of names and numbers from the top, and a message.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..base import nearest
from .toml_lines import Place

__all__ = [
    "Anything",
    "Choice",
    "Either",
    "Entries",
    "Field",
    "Flag",
    "Integer",
    "Listed",
    "Number",
    "Problem",
    "Reference",
    "Table",
    "Tagged",
    "Text",
    "Tree",
    "Variants",
    "needed",
    "optional",
]

Problem = tuple[Place, str]
Root = Mapping[str, Any]


class Kind:
    """A kind of value."""

    @property
    def wanted(self) -> str:
        """What it is called in messages."""
        raise NotImplementedError

    def fits(self, value: Any) -> bool:
        """Whether a value is of this kind's type, whatever may be wrong inside."""
        raise NotImplementedError

    def problems(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        """Yield what is wrong with a value; `root` is the whole file."""
        if self.fits(value):
            yield from self.inside(value, place, root)
        else:
            yield place, f"must be {self.wanted}, got {_shown(value)}"

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        """Yield what is wrong with a value that fits."""
        return iter(())


@dataclass(frozen=True)
class Field:
    """A key of a table."""

    kind: Kind
    needed: bool


def needed(kind: Kind) -> Field:
    """Return a key that must be there."""
    return Field(kind, True)


def optional(kind: Kind) -> Field:
    """Return a key that may be left out."""
    return Field(kind, False)


@dataclass(frozen=True)
class Number(Kind):
    """A number, integers included, of a unit."""

    unit: str = ""

    @property
    def wanted(self) -> str:
        return f"a number ({self.unit})" if self.unit else "a number"

    def fits(self, value: Any) -> bool:
        return isinstance(value, (int, float)) and not isinstance(value, bool)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        try:
            float(value)
        except OverflowError:
            yield place, "must be finite, got an integer beyond 1.8e308"


@dataclass(frozen=True)
class Integer(Kind):
    """A whole number."""

    @property
    def wanted(self) -> str:
        return "a whole number"

    def fits(self, value: Any) -> bool:
        return isinstance(value, int) and not isinstance(value, bool)


@dataclass(frozen=True)
class Flag(Kind):
    """True or false."""

    @property
    def wanted(self) -> str:
        return "true or false"

    def fits(self, value: Any) -> bool:
        return isinstance(value, bool)


@dataclass(frozen=True)
class Anything(Kind):
    """Whatever a place elsewhere in the file may hold."""

    @property
    def wanted(self) -> str:
        return "a value"

    def fits(self, value: Any) -> bool:
        return True


@dataclass(frozen=True)
class Text(Kind):
    """Any text."""

    @property
    def wanted(self) -> str:
        return "text"

    def fits(self, value: Any) -> bool:
        return isinstance(value, str)


@dataclass(frozen=True)
class Choice(Kind):
    """One of some words."""

    options: tuple[str, ...]

    @property
    def wanted(self) -> str:
        return "one of " + ", ".join(f'"{option}"' for option in self.options)

    def fits(self, value: Any) -> bool:
        return isinstance(value, str)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        if value not in self.options:
            hint = nearest(value, self.options)
            yield place, f"must be {self.wanted}, got {_shown(value)}{hint}"


@dataclass(frozen=True)
class Reference(Kind):
    """The name of an entry of a table at the top, such as a material."""

    table: str

    @property
    def wanted(self) -> str:
        return f"a name from [{self.table}]"

    def fits(self, value: Any) -> bool:
        return isinstance(value, str)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        known = root.get(self.table, {})
        names = list(known) if isinstance(known, Mapping) else []
        if value not in names:
            listed = ", ".join(names) or "nothing"
            yield place, f"[{self.table}] has no {value!r}{nearest(value, names)}; it has {listed}"


@dataclass(frozen=True)
class Listed(Kind):
    """A list of values of one kind, of any length or of `length`."""

    of: Kind
    length: int | None = None

    @property
    def wanted(self) -> str:
        each = "" if isinstance(self.of, Anything) else f", each {self.of.wanted}"
        return f"a list of {self.length or 'values'}{each}"

    def fits(self, value: Any) -> bool:
        return isinstance(value, list)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        if self.length is not None and len(value) != self.length:
            yield place, f"must have {self.length} entries, got {len(value)}"
        for i, entry in enumerate(value):
            yield from self.of.problems(entry, (*place, i), root)


@dataclass(frozen=True)
class Either(Kind):
    """A value of the first of several kinds whose type it has."""

    kinds: tuple[Kind, ...]

    @property
    def wanted(self) -> str:
        return ", or ".join(kind.wanted for kind in self.kinds)

    def fits(self, value: Any) -> bool:
        return any(kind.fits(value) for kind in self.kinds)

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        kind = next(kind for kind in self.kinds if kind.fits(value))
        return kind.inside(value, place, root)


class _OfTable(Kind):
    """Anything written as a table."""

    @property
    def wanted(self) -> str:
        return "a table"

    def fits(self, value: Any) -> bool:
        return isinstance(value, Mapping)


@dataclass(frozen=True)
class Table(_OfTable):
    """A table of known keys."""

    fields: Mapping[str, Field]
    called: str = "a table"

    @property
    def wanted(self) -> str:
        return self.called

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        yield from _unknown(value, self.fields, place)
        for name, entry in self.fields.items():
            if name in value:
                yield from entry.kind.problems(value[name], (*place, name), root)
            elif entry.needed:
                yield place, f"{name!r} is missing, {entry.kind.wanted}"


@dataclass(frozen=True)
class Variants(_OfTable):
    """A table of one of several sorts, distinguished by a key of which each has its own.

    `otherwise` is that without any of these keys.
    """

    tables: Mapping[str, Table]
    otherwise: Table | None = None

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


@dataclass(frozen=True)
class Tagged(_OfTable):
    """A table of one of several sorts, distinguished by the word under one key."""

    key: str
    tables: Mapping[str, Kind]

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        if self.key not in value:
            yield place, f"{self.key!r} is missing, {Choice(tuple(self.tables)).wanted}"
        elif not (isinstance(value[self.key], str) and value[self.key] in self.tables):
            choice = Choice(tuple(self.tables))
            yield from choice.problems(value[self.key], (*place, self.key), root)
        else:
            rest = {name: entry for name, entry in value.items() if name != self.key}
            yield from self.tables[value[self.key]].inside(rest, place, root)


@dataclass(frozen=True)
class Entries(_OfTable):
    """Entries under names of the user's choice."""

    of: Kind

    def inside(self, value: Any, place: Place, root: Root) -> Iterator[Problem]:
        for name, entry in value.items():
            yield from self.of.problems(entry, (*place, name), root)


@dataclass(frozen=True)
class Tree(_OfTable):
    """Entries of one kind in tables of any depth; a table that has `mark` is an entry itself."""

    of: Kind
    mark: str

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
