"""A digest of the content of a case: the same in every process, whatever has been cached since."""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Mapping
from functools import cached_property
from hashlib import blake2b
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import InputTypeError

# Bytes: two among a million million cases are taken for one with a chance of 1e-15.
_SIZE = 16

# Bodies, laws and solvers that are remembered by identity; a sweep shares a handful.
_MOST_REMEMBERED = 256

_SINGLE = (bool, int, float, complex, str, bytes, types.NoneType, type)


class Digests:
    """Digests of cases; frozen objects that many of them share are digested once.

    Parameters
    ----------
    key : str or None
        Stands for the code of all functions, which count by their names then; None refuses them.
    """

    def __init__(self, key: str | None) -> None:
        self._key = key
        # The object is kept beside its digest, so that its id stays its own.
        self._remembered: dict[int, tuple[Any, bytes]] = {}

    def of(self, value: Any, name: str = "case") -> str:
        """Return the digest of a value.

        Raises
        ------
        InputTypeError
            If it has a function and there is no key, or something that cannot be looked into.
        """
        try:
            found = self._digest(self._key, "key") + self._digest(value, name)
            return blake2b(found, digest_size=_SIZE).hexdigest()
        except RecursionError:
            raise InputTypeError(
                f"{name}: a checkpoint takes no case that contains itself"
            ) from None

    def _digest(self, value: Any, name: str) -> bytes:
        if id(value) in self._remembered:
            return self._remembered[id(value)][1]
        if isinstance(value, _SINGLE):
            content = repr(value).encode()
        elif isinstance(value, np.ndarray | np.generic) and not value.dtype.hasobject:
            content = f"{value.dtype.str}{value.shape}".encode() + value.tobytes()
        else:
            parts = [
                self._digest(part, f"{name}{label}") for label, part in self._parts(value, name)
            ]
            content = b"".join(sorted(parts) if isinstance(value, set | frozenset) else parts)
        kind = f"{type(value).__module__}.{type(value).__qualname__}\0".encode()
        digest = blake2b(kind + content, digest_size=_SIZE).digest()
        if dataclasses.is_dataclass(value) and value.__dataclass_params__.frozen:  # type: ignore[union-attr]
            if len(self._remembered) >= _MOST_REMEMBERED:
                self._remembered.clear()
            self._remembered[id(value)] = value, digest
        return digest

    def _parts(self, value: Any, name: str) -> list[tuple[str, Any]]:
        """Return the parts of a value, each with a name for messages."""
        if isinstance(value, Mapping):
            keys = sorted(value, key=repr)
            return [("", keys), *((f"[{key!r}]", value[key]) for key in keys)]
        if sp.issparse(value):
            csr = value.tocsr()
            value = csr.shape, csr.indptr, csr.indices, csr.data
        elif isinstance(value, np.ndarray):  # of objects
            value = value.shape, value.ravel().tolist()
        if isinstance(value, tuple | list | set | frozenset):
            return [(f"[{i}]", entry) for i, entry in enumerate(value)]
        if dataclasses.is_dataclass(value):
            fields = dataclasses.fields(value)
            names = [of.name for of in fields if not of.metadata.get("identity")]
        elif callable(value) and self._key is not None:
            where = getattr(value, "__qualname__", type(value).__qualname__)
            return [("", f"{getattr(value, '__module__', '')}.{where}")]
        elif callable(value) or not hasattr(value, "__dict__"):
            raise InputTypeError(
                f"{name}: a checkpoint cannot tell whether a {type(value).__name__} has changed; "
                "of functions give key=, a text that you change with them"
            )
        else:
            cached, own = cached_property, type(value)
            names = [
                of for of in sorted(vars(value)) if not isinstance(getattr(own, of, None), cached)
            ]
        return [(f".{of}", getattr(value, of)) for of in names]
