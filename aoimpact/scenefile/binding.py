"""Tables bound to the signatures of the functions that they call.

A table of a file gives keywords of a public function. Binding checks its keys and the types of its
values by the function's annotations, and calls nothing: what comes of it is a `Call`, with all
problems of the file on a list. `Maker` then makes the objects.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from types import NoneType, SimpleNamespace, UnionType
from typing import Annotated, Any, ClassVar, Union, get_args, get_origin, get_type_hints

from ..base import nearest
from .lines import Place

# Finished objects that the runs of a sweep share: those that are needed again, not every mesh.
_MOST_KEPT = 8


class Numbers:
    """Stands in annotations for arrays: a number, or lists of numbers of any depth."""


_STAND_INS = {"npt": SimpleNamespace(ArrayLike=Numbers), "FloatArray": Numbers}


@dataclass(frozen=True, eq=False)
class Call:
    """A function with its arguments, which may be calls themselves.

    `keep`: whether the object is kept for the next run of a sweep, by the text of the call.
    """

    function: Callable[..., Any]
    arguments: Mapping[str, Any]
    place: Place = field(repr=False)
    keep: bool = field(default=False, repr=False)


@dataclass
class Maker:
    """Makes objects of calls, each once.

    Attributes
    ----------
    located : callable
        Context for a place of the file, which adds its line to errors.
    kept : dict
        Objects of earlier runs; the oldest is dropped first.
    """

    located: Callable[..., AbstractContextManager[None]]
    kept: dict[str, Any]
    made: dict[int, Any] = field(default_factory=dict)

    def make(self, node: Any) -> Any:
        """Return a value with all calls in it made."""
        if isinstance(node, Mapping):
            return {key: self.make(value) for key, value in node.items()}
        if isinstance(node, list | tuple):
            return type(node)(self.make(value) for value in node)
        if not isinstance(node, Call):
            return node
        if id(node) in self.made:
            return self.made[id(node)]
        key = repr(node) if node.keep else ""
        if key not in self.kept:
            arguments = self.make(node.arguments)
            with self.located(*node.place):
                found = node.function(**arguments)
            if not key:
                return self.made.setdefault(id(node), found)
            if len(self.kept) >= _MOST_KEPT:
                del self.kept[next(iter(self.kept))]
            self.kept[key] = found
        return self.made.setdefault(id(node), self.kept[key])


@dataclass(frozen=True, eq=False)
class Reader:
    """Reads values of some types.

    Attributes
    ----------
    wanted : str
        Their name in messages.
    types : tuple of type
        Types that tomllib gives.
    read : callable
        Binder, value and place to what an argument is.
    """

    wanted: str
    types: tuple[type, ...]
    read: Callable[[Any, Any, Place], Any] = lambda binder, value, place: value

    def fits(self, value: Any) -> bool:
        """True if a value is of these types; true and false are no numbers."""
        if isinstance(value, bool):
            return bool in self.types or object in self.types
        return isinstance(value, self.types)


def passes_on(target: Callable[..., Any], *but: str) -> Callable[[Any], Any]:
    """Give a function with ``**more`` the other parameters of the one that it passes them to."""

    def marked(function: Any) -> Any:
        function.passes_on = target, but
        return function

    return marked


@dataclass(frozen=True)
class Table:
    """A function whose arguments a table gives.

    Attributes
    ----------
    function : callable
    keys : dict of str to str
        Names in the file of parameters that are called otherwise.
    hints : dict
        Annotations for parameters that the function leaves open.
    beside : tuple of str
        Keys of the table that are not for this function.
    """

    function: Callable[..., Any]
    keys: Mapping[str, str] = field(default_factory=dict)
    hints: Mapping[str, Any] = field(default_factory=dict)
    beside: tuple[str, ...] = ()

    @cached_property
    def parameters(self) -> dict[str, inspect.Parameter]:
        """Parameters that a file can give, by key."""
        called = {name: key for key, name in self.keys.items()}
        return {
            called.get(name, name): of.replace(annotation=self.hints.get(name, of.annotation))
            for name, of in _parameters(self.function).items()
        }

    @property
    def makes(self) -> Any:
        """The class of the object."""
        if isinstance(self.function, type):
            return self.function
        return get_type_hints(self.function, None, _STAND_INS)["return"]

    def known(self, given: Iterable[str]) -> set[str]:
        """Keys that the table may have, where some parameters are given."""
        return {*self.parameters, *self.beside}.difference(given)

    def faults(self, value: Mapping[str, Any], given: Iterable[str]) -> int:
        """Count unknown and missing keys."""
        needed = {key for key, of in self.parameters.items() if of.default is of.empty}
        return len(value.keys() - self.known(given)) + len(needed - {*value, *given})


@cache
def _parameters(function: Any) -> dict[str, inspect.Parameter]:
    """Parameters that can be read from a file, with their annotations."""
    target = function.__init__ if isinstance(function, type) else function  # type: ignore[misc]
    hints = get_type_hints(target, None, _STAND_INS, include_extras=True)
    found = {
        name: of.replace(annotation=hints.get(name, Any))
        for name, of in inspect.signature(function).parameters.items()
        if of.kind is not of.VAR_KEYWORD
    }
    if hasattr(function, "passes_on"):
        onto, but = function.passes_on
        others = _parameters(onto).items()
        found |= {name: of for name, of in others if name not in found and name not in but}
    return found


class Binder:
    """Binds tables to functions, and collects what is wrong.

    A subclass has `readers` of classes in annotations.

    Parameters
    ----------
    folder : Path
        That paths in the file start from.
    """

    readers: ClassVar[Mapping[Any, Reader]]
    _known: ClassVar[dict[Any, Reader | None]] = {}

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.problems: list[tuple[Place, str]] = []

    def say(self, place: Place, message: str) -> None:
        """Note a problem."""
        self.problems.append((place, message))

    def bind(
        self,
        tables: Table | Sequence[Table],
        value: Mapping[str, Any],
        place: Place,
        given: Mapping[str, Any] | None = None,
        keep: bool = False,
    ) -> Call:
        """Bind a table to the function whose keywords fit its keys best, the first of several.

        Parameters
        ----------
        given : dict, optional
            Arguments that do not come from the table.
        """
        given = given or {}
        options = [tables] if isinstance(tables, Table) else tables
        table = min(options, key=lambda one: one.faults(value, given))
        names = table.parameters
        readers = {key: self.reader(of.annotation) for key, of in names.items()}
        known = [
            key for key in [*names, *table.beside] if key not in given and readers.get(key, True)
        ]
        for key in value:
            if key not in known:
                hint = nearest(key, known) or f"; known are {', '.join(known)}"
                self.say((*place, key), f"unknown name {key!r}{hint}")
        arguments = {name: of for name, of in given.items() if name in names}
        for key, of in names.items():
            reader = readers[key]
            if key in given or reader is None:
                continue
            if key in value:
                arguments[of.name] = self._read(value[key], reader, (*place, key))
            elif of.default is of.empty:
                self.say(place, f"{key!r} is missing, {reader.wanted}")
        return Call(table.function, arguments, place, keep)

    def tagged(
        self, value: Mapping[str, Any], place: Place, options: Mapping[str, Any]
    ) -> tuple[Any, dict[str, Any]]:
        """Return what the key `type` of a table names, and its other keys; None for no such."""
        kind = value.get("type")
        if not (isinstance(kind, str) and kind in options):
            listed = ", ".join(f'"{option}"' for option in options)
            got = f"got {_shown(kind)}{nearest(str(kind), options)}" if "type" in value else ""
            self.say((*place, "type"), f"must be one of {listed}" + (got and f", {got}"))
            return None, {}
        return options[kind], {key: of for key, of in value.items() if key != "type"}

    def bind_typed(
        self, tables: Mapping[str, Table], value: Mapping[str, Any], place: Place, **more: Any
    ) -> Call | None:
        """Bind a table to the function that its key `type` names."""
        made, given = self.tagged(value, place, tables)
        return None if made is None else self.bind(made, given, place, **more)

    def _read(self, value: Any, reader: Reader, place: Place) -> Any:
        if reader.fits(value):
            return reader.read(self, value, place)
        self.say(place, f"must be {reader.wanted}, got {_shown(value)}")
        return None

    def reader(self, hint: Any) -> Reader | None:
        """Return what reads an annotation; None for one of which a file can say nothing."""
        try:
            if hint not in self._known:
                self._known[hint] = self._reader(hint)
            return self._known[hint]
        except TypeError:  # an annotation that has no hash is none of ours
            return None

    def _reader(self, hint: Any) -> Reader | None:
        origin, arguments = get_origin(hint), get_args(hint)
        if origin is Annotated:
            return next(of for of in arguments if isinstance(of, Reader))
        if origin in (Union, UnionType):
            return self._either(arguments)
        if origin is tuple and Ellipsis not in arguments:
            return self._items(arguments)
        if origin in (list, tuple, Sequence):
            return self._items(arguments[:1], endless=True)
        if origin is Mapping:
            return self._entries(arguments[1])
        if origin is os.PathLike:
            return PATH
        return self.readers.get(hint) or _LEAVES.get(hint)

    def _either(self, hints: Iterable[Any]) -> Reader | None:
        """The first of several readers whose types a value has."""
        found = {self.reader(hint): hint for hint in hints if hint is not NoneType}
        readers = [reader for reader in found if reader is not None]
        if PATH in readers:
            readers = [reader for reader in readers if reader is not TEXT]
        if len(readers) < 2:
            return readers[0] if readers else None

        def read(binder: Any, value: Any, place: Place) -> Any:
            return next(one for one in readers if one.fits(value)).read(binder, value, place)

        types = tuple(of for reader in readers for of in reader.types)
        return Reader(", or ".join(reader.wanted for reader in readers), types, read)

    def _items(self, hints: Sequence[Any], endless: bool = False) -> Reader | None:
        """A list of values of one kind, or of some kinds in their order."""
        each = [self.reader(hint) for hint in hints]
        if None in each:
            return None

        def read(binder: Any, value: Any, place: Place) -> Any:
            if endless:
                return [binder._read(of, each[0], (*place, i)) for i, of in enumerate(value)]
            if len(value) != len(each):
                binder.say(place, f"must have {len(each)} entries, got {len(value)}")
            pairs = zip(value, each, strict=False)
            return tuple(binder._read(of, one, (*place, i)) for i, (of, one) in enumerate(pairs))

        length = "" if endless else f"{len(each)} "
        return Reader(f"a list of {length}values, each {each[0].wanted}", (list,), read)  # type: ignore[union-attr]

    def _entries(self, hint: Any) -> Reader | None:
        """A table of values of one kind by names of the user's choice."""
        each = self.reader(hint)
        if each is None:
            return None

        def read(binder: Any, value: Any, place: Place) -> Any:
            return {key: binder._read(of, each, (*place, key)) for key, of in value.items()}

        return Reader(f"a table, each {each.wanted}", (dict,), read)


def table(*functions: Callable[..., Any], **keys: str) -> Reader:
    """Return what reads a table that gives the arguments of one of some functions."""
    tables = tuple(Table(function, keys) for function in functions)
    return Reader(
        "a table", (dict,), lambda binder, value, place: binder.bind(tables, value, place)
    )


def _number(binder: Binder, value: Any, place: Place) -> Any:
    """A number, or lists of numbers, that doubles can hold."""
    if isinstance(value, list):
        return [_number(binder, of, (*place, i)) for i, of in enumerate(value)]
    if isinstance(value, bool) or not isinstance(value, int | float):
        binder.say(place, f"must be a number, got {_shown(value)}")
    elif isinstance(value, int) and abs(value) > _LARGEST:
        binder.say(place, "must be finite, got an integer beyond 1.8e308")
    return value


_LARGEST = int(1.7976931348623157e308)

TEXT = Reader("text", (str,))
PATH = Reader("a path", (str,), lambda binder, value, place: binder.folder / value)
NUMBER = Reader("a number", (int, float), _number)

_LEAVES: dict[Any, Reader] = {
    float: NUMBER,
    Numbers: Reader("a list of numbers", (int, float, list), _number),
    int: Reader("a whole number", (int,)),
    bool: Reader("true or false", (bool,)),
    str: TEXT,
    Any: Reader("a value", (object,)),
}


def _shown(value: Any) -> str:
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, str | int | float) else f"a {type(value).__name__}"
