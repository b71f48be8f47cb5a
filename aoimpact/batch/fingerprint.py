"""A digest of the content of a case: the same in every process, whatever has been cached since.

Pickles do not serve: the same content has many, depending on what is shared and what is cached. A
function is digested by its bytecode, constants and closure, and by what it looks up in its module.
By its name alone, a checkpoint would give the results of the old one after a change in a law or in
`keep`.
"""

from __future__ import annotations

import dataclasses
import hashlib
import pickle
import struct
import types
from collections.abc import Iterator, Mapping
from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import InputTypeError

__all__ = ["DIGEST_SIZE", "Fingerprints"]

# 16 bytes: among a million million cases two are taken for one with a chance of 1e-15.
DIGEST_SIZE = 16

# So many bodies, laws and solvers are remembered by identity; a sweep shares a handful.
_MOST_REMEMBERED = 256


class Fingerprints:
    """Digests of cases; frozen objects that many of them share are digested once."""

    def __init__(self) -> None:
        # The object is kept beside its digest, so that its id stays its own.
        self._remembered: dict[int, tuple[Any, bytes]] = {}

    def of(self, value: Any, name: str = "case") -> bytes:
        """Return the digest of a value, DIGEST_SIZE bytes.

        Raises
        ------
        InputTypeError
            If something in it cannot be looked into, such as a compiled function.
        """
        return self._digest(value, name, ())

    def _digest(self, value: Any, name: str, above: tuple[int, ...]) -> bytes:
        known = self._remembered.get(id(value))
        if known is not None:
            return known[1]
        if id(value) in above:  # a cycle: by how far up it leads
            return _hashed("cycle", str(above[::-1].index(id(value))).encode())
        parts = _atom(value)
        if parts is None:
            inside = (*above, id(value))
            parts = [
                part if isinstance(part, bytes) else self._digest(part[1], name + part[0], inside)
                for part in _inside(value, name)
            ]
            if isinstance(value, (set, frozenset)):  # their order says nothing
                parts.sort()
        digest = _hashed(_kind(value), *parts)
        if _is_frozen(value):
            if len(self._remembered) >= _MOST_REMEMBERED:
                self._remembered.clear()
            self._remembered[id(value)] = value, digest
        return digest


def _hashed(*parts: str | bytes) -> bytes:
    digest = hashlib.blake2b(digest_size=DIGEST_SIZE)
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        digest.update(struct.pack("<Q", len(data)))
        digest.update(data)
    return digest.digest()


def _kind(value: Any) -> str:
    return f"{type(value).__module__}.{type(value).__qualname__}"


def _is_frozen(value: Any) -> bool:
    return dataclasses.is_dataclass(value) and value.__dataclass_params__.frozen  # type: ignore[union-attr]


def _atom(value: Any) -> list[bytes] | None:
    """The bytes of a value that has nothing inside; None for others."""
    if value is None or value is Ellipsis:
        return []
    if isinstance(value, float):
        return [struct.pack("<d", value)]
    if isinstance(value, (bool, int, complex)):
        return [repr(value).encode()]
    if isinstance(value, str):
        return [value.encode("utf-8", "surrogatepass")]
    if isinstance(value, (bytes, bytearray)):
        return [bytes(value)]
    if isinstance(value, (np.ndarray, np.generic)) and not value.dtype.hasobject:
        array = np.asarray(value)
        return [array.dtype.str.encode(), repr(array.shape).encode(), array.tobytes()]
    if isinstance(value, (type, types.ModuleType, types.BuiltinFunctionType)):
        return [f"{getattr(value, '__module__', '')}.{value.__name__}".encode()]
    return None


# A name for messages, ".law" or "[3]", and the value; or bytes.
_Part = bytes | tuple[str, Any]


def _inside(value: Any, name: str) -> list[_Part]:
    if isinstance(value, Mapping):
        items = sorted(value.items(), key=lambda item: repr(item[0]))
        return [part for key, entry in items for part in (("", key), (f"[{key!r}]", entry))]
    if isinstance(value, (set, frozenset)):
        return [("", entry) for entry in value]
    if isinstance(value, (tuple, list)):
        return [(f"[{i}]", entry) for i, entry in enumerate(value)]
    if isinstance(value, np.ndarray):  # of objects
        return [repr(value.shape).encode(), ("", value.ravel().tolist())]
    if sp.issparse(value):
        csr = value.tocsr()
        return [("", (csr.shape, csr.indptr, csr.indices, csr.data))]
    if isinstance(value, types.FunctionType):
        return [("", _of_function(value))]
    if isinstance(value, types.CodeType):
        return [value.co_code, ("", (value.co_consts, value.co_names, value.co_varnames))]
    if isinstance(value, types.MethodType):
        return [("", (value.__func__, value.__self__))]
    if isinstance(value, partial):
        return [("", (value.func, value.args, value.keywords))]
    if dataclasses.is_dataclass(value):
        return [
            *_methods(value),
            *(
                (f".{field.name}", getattr(value, field.name))
                for field in dataclasses.fields(value)
                if not field.metadata.get("identity")  # which of its like it is, not what
            ),
        ]
    if isinstance(value, BaseException):
        return [("", value.args)]
    if hasattr(value, "__dict__"):
        return [*_methods(value), *((f".{key}", state) for key, state in _state(value))]
    return [_pickled(value, name)]


# Of what a function looks up in its module: its data, and the module's own functions.
_DATA = (int, float, complex, str, bytes, tuple, list, dict, set, frozenset, np.ndarray)


def _of_function(function: types.FunctionType) -> tuple[Any, ...]:
    """Its code, and the data and functions of its own module that it looks up there."""
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


def _methods(value: Any) -> list[_Part]:
    """The functions of the class of an object that is called like one."""
    if not callable(value):
        return []
    members = (member for base in type(value).__mro__ for member in vars(base).values())
    return [("", member) for member in members if isinstance(member, types.FunctionType)]


def _state(value: Any) -> list[tuple[str, Any]]:
    """Attributes by name, without what was computed from the others and kept."""
    cls = type(value)
    return [
        (key, state)
        for key, state in sorted(vars(value).items())
        if not isinstance(getattr(cls, key, None), cached_property)
    ]


def _pickled(value: Any, name: str) -> bytes:
    try:
        return pickle.dumps(value, protocol=4)
    except Exception as error:
        raise InputTypeError(
            f"{name}, {type(value).__name__}: a checkpoint cannot tell whether it has changed "
            f"({error}); run without checkpoint, or make it of numbers, arrays and functions "
            "written in Python"
        ) from None
