"""Binding of a file's tables to the signatures of the functions that they call.

A table of a file gives keywords of a public function. Binding checks the keys of the table, and the
types of its values against the function's annotations. It calls nothing: it returns a `Call`, and
lists all problems of the file. `SceneFile` then makes the objects.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from types import SimpleNamespace, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from .. import contact, fem
from ..base import nearest, record
from .lines import Place


class Numbers:
    """Annotation that replaces annotations of arrays: a number, or nested lists of numbers."""


# Objects for the names in annotations, including names that are imported only for type checkers.
_ARRAYS = SimpleNamespace(ArrayLike=Numbers, FloatArray=Numbers)
_STAND_INS = vars(fem) | vars(contact) | vars(_ARRAYS) | {"npt": _ARRAYS}


@record
class Call:
    """A call to be made: a function and its arguments, which may be calls themselves.

    `keep`: True if the returned object is reused for equal calls in the next runs of a sweep.
    """

    function: Callable[..., Any]
    arguments: dict[str, Any]
    place: Place = field(repr=False)
    keep: bool = field(default=False, repr=False)


@record
class Reader:
    """Function that checks a value in a file, and converts it to an argument.

    Attributes
    ----------
    wanted : str
        Description of valid values for messages, such as "a number".
    types : tuple of type
        Accepted types of the value that tomllib returns.
    read : callable
        Function that returns the argument, given the binder, the value and its place in the file.
    """

    wanted: str
    types: tuple[type, ...]
    read: Callable[[Any, Any, Place], Any] = lambda binder, value, place: value

    def fits(self, value: Any) -> bool:
        """Return whether a value has an accepted type; true and false do not count as numbers."""
        if isinstance(value, bool):
            return bool in self.types or object in self.types
        return isinstance(value, self.types)

    def __call__(self, binder: Binder, value: Any, place: Place) -> Any:
        """Return the argument for a value; for a wrong value, record a problem and return None."""
        if not self.fits(value):
            return binder.say(place, f"must be {self.wanted}, got {_shown(value)}")
        return self.read(binder, value, place)


def passes_on(target: Callable[..., Any], *but: str) -> Callable[[Any], Any]:
    """Return a decorator which declares that ``**more`` are parameters of `target` except `but`."""

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
        Parameter's name for each key in the file that differs from it.
    hints : dict
        Annotations, by parameter, that replace the function's own.
    owner : callable, optional
        Another function that is called with arguments from the table. Nested tables call methods of
        the object that this function returns.
    keep : bool
        True if the object takes long to make and is kept for the next runs of a sweep.
    """

    function: Callable[..., Any]
    keys: Mapping[str, str] = field(default_factory=dict)
    hints: Mapping[str, Any] = field(default_factory=dict)
    owner: Callable[..., Any] | None = None
    keep: bool = False

    @cached_property
    def parameters(self) -> dict[str, inspect.Parameter]:
        """Parameters by key in the file; their annotations are replaced by readers of values."""
        called = {name: key for key, name in self.keys.items()}
        found = (_parameters(self.owner) if self.owner else {}) | _parameters(self.function)
        return {
            called.get(name, name): of.replace(
                annotation=reader(self.hints.get(name, of.annotation))
            )
            for name, of in found.items()
            if name != "self"
        }


@cache
def _parameters(function: Any) -> dict[str, inspect.Parameter]:
    """Return the parameters of a function, with evaluated annotations, by name."""
    target = function.__init__ if isinstance(function, type) else function  # type: ignore[misc]
    hints = get_type_hints(target, None, _STAND_INS, include_extras=True)
    found = {
        name: of.replace(annotation=hints.get(name, Any))
        for name, of in inspect.signature(function).parameters.items()
        if of.kind is not of.VAR_KEYWORD
    }
    if hasattr(function, "passes_on"):
        onto, but = function.passes_on
        found |= {
            name: of
            for name, of in _parameters(onto).items()
            if name not in found and name not in but
        }
    return found


class Binder:
    """Binds tables to functions, and collects the problems of the file.

    Parameters
    ----------
    folder : Path
        Folder that paths in the file are relative to.

    Attributes
    ----------
    around : dict
        Arguments read so far from the enclosing table. The entry "self" is the call of the table's
        owner.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.problems: list[tuple[Place, str]] = []
        self.around: dict[str, Any] = {}

    def say(self, place: Place, message: str) -> None:
        """Record a problem at a place; return None."""
        self.problems.append((place, message))

    def find(self, known: Mapping[str, Any], where: str, name: str, place: Place) -> Any:
        """Return `known[name]`; for an unknown name, record a problem and return None."""
        if name not in known:
            listed = ", ".join(known) or "nothing"
            self.say(place, f"{where} has no {name!r}{nearest(name, known)}; it has {listed}")
        return known.get(name)

    def bind(
        self, tables: Table | Sequence[Table], value: Mapping[str, Any], place: Place, **given: Any
    ) -> Call:
        """Bind a table to the function whose keywords fit its keys best; the first if several do.

        For a method, `self` is the object made by the owner of the enclosing table.

        Parameters
        ----------
        given : optional
            Arguments that do not come from the table.
        """

        def fit(table: Table) -> tuple[Table, list[str], list[str], list[str]]:
            """Return the table, the keys it may have, its unknown keys and its missing keys."""
            known = {
                k: of for k, of in table.parameters.items() if of.annotation and k not in given
            }
            missing = [k for k, of in known.items() if of.default is of.empty and k not in value]
            return table, list(known), [key for key in value if key not in known], missing

        options = [tables] if isinstance(tables, Table) else tables
        table, known, unknown, missing = min(map(fit, options), key=lambda of: len(of[2] + of[3]))
        for key in unknown:
            hint = nearest(key, known) or f"; known are {', '.join(known)}"
            self.say((*place, key), f"unknown name {key!r}{hint}")
        for key in missing:
            self.say(place, f"{key!r} is missing, {table.parameters[key].annotation.wanted}")
        calls = [Call(of, {}, place, table.keep) for of in (table.function, table.owner) if of]
        around = self.around
        self.around = {"self": calls[-1] if table.owner else around.get("self"), **given}
        for key in known:
            if key in value:
                of = table.parameters[key]
                self.around[of.name] = of.annotation(self, value[key], (*place, key))
        for call in calls:
            names = _parameters(call.function)
            call.arguments.update({key: of for key, of in self.around.items() if key in names})
        self.around = around
        return calls[0]

    def tagged(
        self, value: Mapping[str, Any], place: Place, options: Mapping[str, Any]
    ) -> tuple[Any, dict[str, Any]]:
        """Return the option named by a table's key `type` (or None), and the table's other keys."""
        kind = value.get("type")
        if not (isinstance(kind, str) and kind in options):
            listed = ", ".join(f'"{option}"' for option in options)
            got = f"got {_shown(kind)}{nearest(str(kind), options)}" if "type" in value else ""
            self.say((*place, "type"), f"must be one of {listed}" + (got and f", {got}"))
            return None, {}
        return options[kind], {key: of for key, of in value.items() if key != "type"}


def table(*functions: Table | Callable[..., Any]) -> Reader:
    """Return the `Reader` of a table with the arguments of one of the given functions."""
    tables = [of if isinstance(of, Table) else Table(of) for of in functions]
    return Reader("a table", (dict,), lambda binder, *of: binder.bind(tables, *of))


def typed(*functions: Table | Callable[..., Any], **more: str) -> Reader:
    """Return the `Reader` of a table whose key `type` names one of the given functions.

    Parameters
    ----------
    **more : optional
        Arguments that come from the enclosing table, given as name=argument of that table.
    """
    tables = [of if isinstance(of, Table) else Table(of) for of in functions]
    options = {of.function.__name__: of for of in tables}

    def read(binder: Binder, value: Any, place: Place) -> Any:
        made, given = binder.tagged(value, place, options)
        around = {name: binder.around.get(key) for name, key in more.items()}
        return made and binder.bind(made, given, place, **around)

    return Reader("a table", (dict,), read)


def calls(node: Any) -> Iterator[Call]:
    """Yield all calls within a value; calls in the arguments of a call precede the call."""
    if isinstance(node, Call):
        yield from calls(node.arguments)
        yield node
    elif isinstance(node, Mapping | list | tuple):
        for value in node.values() if isinstance(node, Mapping) else node:
            yield from calls(value)


# --------------------------------------------------------------------------------- annotations


def reader(hint: Any) -> Reader | None:
    """Return the `Reader` of values for an annotation; None if a file cannot hold the values."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return next(of for of in inner if isinstance(of, Reader))
    if origin in (Union, UnionType):
        return _either(inner)
    if origin is tuple and Ellipsis not in inner:
        return _items(inner)
    if origin in (list, tuple, Sequence):
        return _items(inner[:1], endless=True)
    if origin is Mapping:
        return _entries(inner[1])
    if origin is os.PathLike:
        return PATH
    return READERS.get(hint)


def _either(hints: Sequence[Any]) -> Reader | None:
    """Return the `Reader` of a union, which reads a value by the first annotation that fits it."""
    path = any(get_origin(hint) is os.PathLike for hint in hints)
    found = (reader(hint) for hint in hints if not (path and hint in (str, Any)))
    kinds = list(dict.fromkeys(filter(None, found)))
    if len(kinds) < 2:
        return kinds[0] if kinds else None

    def read(binder: Binder, value: Any, place: Place) -> Any:
        return next(one for one in kinds if one.fits(value))(binder, value, place)

    types = tuple(of for one in kinds for of in one.types)
    return Reader(", or ".join(one.wanted for one in kinds), types, read)


def _items(hints: Sequence[Any], endless: bool = False) -> Reader | None:
    """Return the `Reader` of a list; None if an entry cannot be read.

    `hints` are the annotations of the entries or, if `endless`, the one of all entries.
    """
    each = [found for hint in hints if (found := reader(hint))]
    if len(each) < len(hints):
        return None

    def read(binder: Binder, value: Any, place: Place) -> Any:
        if not endless and len(value) != len(each):
            binder.say(place, f"must have {len(each)} entries, got {len(value)}")
        readers = each * len(value) if endless else each
        pairs = enumerate(zip(value, readers, strict=False))
        found = [one(binder, of, (*place, i)) for i, (of, one) in pairs]
        return found if endless else tuple(found)

    length = "" if endless else f"{len(each)} "
    return Reader(f"a list of {length}values, each {each[0].wanted}", (list,), read)


def _entries(hint: Any) -> Reader | None:
    """Return the `Reader` of a table with values of one kind under any keys."""
    each = reader(hint)
    if each is None:
        return None

    def read(binder: Binder, value: Any, place: Place) -> Any:
        return {key: each(binder, of, (*place, key)) for key, of in value.items()}

    return Reader(f"a table, each {each.wanted}", (dict,), read)


def _number(binder: Binder, value: Any, place: Place) -> Any:
    """Return a number or nested lists; record a problem for each entry that no double can hold."""
    if isinstance(value, list):
        return [_number(binder, of, (*place, i)) for i, of in enumerate(value)]
    if isinstance(value, bool) or not isinstance(value, int | float):
        binder.say(place, f"must be a number, got {_shown(value)}")
    elif isinstance(value, int) and abs(value) > 1.7976931348623157e308:
        binder.say(place, "must be finite, got an integer beyond 1.8e308")
    return value


PATH = Reader("a path", (str,), lambda binder, value, place: binder.folder / value)

# Readers of values by annotation; tables.py adds the readers for classes.
READERS: dict[Any, Reader] = {
    float: Reader("a number", (int, float), _number),
    Numbers: Reader("a list of numbers", (int, float, list), _number),
    int: Reader("a whole number", (int,)),
    bool: Reader("true or false", (bool,)),
    str: Reader("text", (str,)),
    Any: Reader("a value", (object,)),
}


def _shown(value: Any) -> str:
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, str | int | float) else f"a {type(value).__name__}"
