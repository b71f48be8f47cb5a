"""A digest of the content of a case: the same in every process, whatever has been cached since.

Functions count by their compiled code and what it looks up. Their names alone would give the
results of the old one after a change in a law or in `keep`; their source may have changed since.
"""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Iterator, Mapping
from functools import cached_property, partial
from hashlib import blake2b
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import InputTypeError

# Bytes: two among a million million cases are taken for one with a chance of 1e-15.
_SIZE = 16

# Bodies, laws and solvers that are remembered by identity; a sweep shares a handful.
_MOST_REMEMBERED = 256

# Variables of a module that count where a function of it names them, and single values.
_SINGLE = (bool, int, float, complex, str, bytes, bytearray, types.NoneType, types.EllipsisType)
_DATA = (*_SINGLE, tuple, list, dict, set, frozenset, np.ndarray)
_NAMED = (type, types.ModuleType, types.BuiltinFunctionType)


class Digests:
    """Digests of cases; frozen objects that many of them share are digested once."""

    def __init__(self) -> None:
        # The object is kept beside its digest, so that its id stays its own.
        self._remembered: dict[int, tuple[Any, bytes]] = {}

    def of(self, value: Any, name: str = "case") -> str:
        """Return the digest of a value.

        Raises
        ------
        InputTypeError
            If something in it cannot be looked into, such as a compiled function.
        """
        return self._digest(value, name, ()).hex()

    def _digest(self, value: Any, name: str, above: tuple[int, ...]) -> bytes:
        if id(value) in self._remembered:
            return self._remembered[id(value)][1]
        content: bytes
        if id(value) in above:  # a cycle, by how far up it leads
            content = b"cycle %d" % above[::-1].index(id(value))
        elif isinstance(found := _content(value, name), bytes):
            content = found
        else:
            inside = (*above, id(value))
            digests = [self._digest(part, name + label, inside) for label, part in found]
            unordered = isinstance(value, (set, frozenset))
            content = b"".join(sorted(digests) if unordered else digests)
        kind = f"{type(value).__module__}.{type(value).__qualname__}\0".encode()
        digest = blake2b(kind + content, digest_size=_SIZE).digest()
        if dataclasses.is_dataclass(value) and value.__dataclass_params__.frozen:  # type: ignore[union-attr]
            if len(self._remembered) >= _MOST_REMEMBERED:
                self._remembered.clear()
            self._remembered[id(value)] = value, digest
        return digest


def _content(value: Any, name: str) -> bytes | list[tuple[str, Any]]:
    """The bytes of a single value; of others what is inside, each with a name for messages."""
    if isinstance(value, _SINGLE):
        return repr(value).encode()
    if isinstance(value, (np.ndarray, np.generic)) and not value.dtype.hasobject:
        return f"{value.dtype.str}{value.shape}".encode() + value.tobytes()
    if isinstance(value, _NAMED):
        return f"{getattr(value, '__module__', '')}.{value.__name__}".encode()
    if isinstance(value, Mapping):
        items = [(key, value[key]) for key in sorted(value, key=repr)]
        return [part for key, entry in items for part in (("", key), (f"[{key!r}]", entry))]
    if isinstance(value, (set, frozenset)):
        return [("", entry) for entry in value]
    if isinstance(value, np.ndarray):  # of objects
        return [("", value.shape), ("", value.ravel().tolist())]
    if isinstance(value, (tuple, list)):
        return [(f"[{i}]", entry) for i, entry in enumerate(value)]
    if sp.issparse(value):
        csr = value.tocsr()
        return [("", part) for part in (csr.shape, csr.indptr, csr.indices, csr.data)]
    if isinstance(value, types.FunctionType):
        return [("", part) for part in _of_function(value)]
    if isinstance(value, types.CodeType):
        names = value.co_names, value.co_varnames
        return [("", value.co_code), ("", value.co_consts), ("", names)]
    if isinstance(value, types.MethodType):
        return [("", value.__func__), ("", value.__self__)]
    if isinstance(value, partial):
        return [("", part) for part in (value.func, value.args, value.keywords)]
    if isinstance(value, BaseException):
        return [("", value.args)]
    if not hasattr(value, "__dict__"):
        raise InputTypeError(
            f"{name}, {type(value).__name__}: a checkpoint cannot tell whether it has changed; run "
            "without checkpoint, or make it of numbers, arrays and functions written in Python"
        )
    return [(f".{key}", part) for key, part in _attributes(value)] + [
        ("", method) for method in _methods(value)
    ]


def _attributes(value: Any) -> Iterator[tuple[str, Any]]:
    """Fields of a dataclass, or attributes, but for those computed from others and kept."""
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            if not field.metadata.get("identity"):  # which of its like it is
                yield field.name, getattr(value, field.name)
        return
    for key, part in sorted(vars(value).items()):
        if not isinstance(getattr(type(value), key, None), cached_property):
            yield key, part


def _methods(value: Any) -> Iterator[types.FunctionType]:
    """The functions of the class of an object that is called like one."""
    for base in type(value).__mro__ if callable(value) else ():
        yield from (own for own in vars(base).values() if isinstance(own, types.FunctionType))


def _of_function(function: types.FunctionType) -> tuple[Any, ...]:
    """Code of a function, and the data and functions of its module that it looks up."""
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    looked_up = {
        name: found
        for name in _names(function.__code__)
        if isinstance(found := function.__globals__.get(name), _DATA)
        or (isinstance(found, types.FunctionType) and found.__module__ == function.__module__)
    }
    return function.__code__, function.__defaults__, function.__kwdefaults__, cells, looked_up


def _names(code: types.CodeType) -> Iterator[str]:
    """Names that code looks up, and the functions, generators and comprehensions in it."""
    yield from code.co_names
    for inner in code.co_consts:
        if isinstance(inner, types.CodeType):
            yield from _names(inner)
