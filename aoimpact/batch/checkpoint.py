"""A file of finished cases, from which a sweep that was stopped resumes.

The file is text, with a line of JSON for each case: its digest, its numbers and its warnings.
Nothing in it is executed. Cases are identified by a digest of their content, which excludes caches
and is the same in every process. Cases may therefore be changed, added or reordered. Each line is
added by a single write. Sweeps may therefore share a file, and a process that is killed leaves at
most one incomplete line, which is ignored. Failed cases are not stored; they are run again.
"""

from __future__ import annotations

import dataclasses
import io
import json
import os
import pickle
from collections.abc import Mapping
from functools import cached_property, lru_cache
from hashlib import blake2b
from typing import Any

import numpy as np

from ..base import FilePath, InputError, InputTypeError, file_path, sp, warn
from ..fem import FEModel

# Outcome of a case: the kept value or the exception, and the warnings.
Outcome = tuple[Any, tuple[str, ...]]

_HEAD = b'{"aoimpact": "checkpoint"}\n'

# Length of a digest, bytes. With 10¹² cases, two digests are equal with a probability of 1e-15.
_SIZE = 16

# Largest number of bodies whose digests are cached; the cases of a sweep share a few bodies.
_MOST_REMEMBERED = 16


class Checkpoint:
    """Finished cases on disk, by their digests.

    Parameters
    ----------
    path : path
        The file, which is made if it does not exist.

    Raises
    ------
    InputError
        If the file is no checkpoint, or cannot be opened.

    Warns
    -----
    AOImpactWarning
        If the file has damaged lines, which are ignored.
    """

    def __init__(self, path: FilePath) -> None:
        self._name = str(file_path("checkpoint", path))
        self._known: dict[str, Outcome] = {}
        name, place, damaged = f"checkpoint {self._name!r}", 0, 0
        try:
            with open(self._name, "a+b") as file:
                file.seek(0)
                for line in file:
                    if not place and not _HEAD.startswith(line):
                        raise InputError(f"{name} is not a checkpoint file; give another path")
                    if not line.endswith(b"\n"):  # the process was killed while writing
                        break
                    place += len(line)
                    try:
                        record = json.loads(line)
                        told = tuple(map(str, record["warnings"]))
                        self._known[record["case"]] = record["value"], told
                    except (ValueError, TypeError, LookupError, RecursionError):
                        damaged += line != _HEAD
                file.truncate(place)
                file.write(b"" if place else _HEAD)
        except OSError as error:
            raise InputError(
                f"{name} cannot be opened: {error.strerror}; give another path"
            ) from None
        if damaged:
            warn(f"{name} is damaged in {damaged} lines: their cases are run again")

    def __contains__(self, digest: str) -> bool:
        return digest in self._known

    def __enter__(self) -> Checkpoint:
        self._written = open(self._name, "ab", buffering=0)  # each line is one write
        return self

    def __exit__(self, *_: object) -> None:
        """Write all data to the disk, and close the file."""
        os.fsync(self._written.fileno())
        self._written.close()

    def get(self, digest: str) -> Outcome:
        """Return the stored outcome of the case with the given digest."""
        return self._known[digest]

    def put(self, digest: str, outcome: Outcome) -> None:
        """Write the outcome of a case unless the case failed; a written outcome survives a kill.

        `get` returns the outcome only after the file has been opened again.
        """
        value, messages = outcome
        if not isinstance(value, Exception):
            record = {"case": digest, "warnings": messages, "value": value}
            self._written.write(f"{json.dumps(record)}\n".encode())


def as_json(value: Any) -> Any:
    """Return a value in the form that a checkpoint restores: numbers, strings, lists and dicts.

    Raises
    ------
    InputTypeError
        If JSON cannot hold it.
    """
    try:
        return json.loads(json.dumps(value, default=lambda array: array.tolist()))
    except Exception:
        raise InputTypeError(
            f"keep must return what JSON holds for a checkpoint, got {type(value).__name__}"
        ) from None


class Digests:
    """Computes digests of cases; the digest of a body that many cases share is computed once.

    Parameters
    ----------
    key : str or None
        Text that represents the code of functions, since only the names of functions enter a
        digest. With None, functions are refused.
    shared : optional
        Value that enters the digest of every case.
    """

    def __init__(self, key: str | None, shared: Any = None) -> None:
        self.key, self._shared = key, shared
        self.once = lru_cache(_MOST_REMEMBERED)(lambda value: self._digest(_parts(value)))

    def of(self, value: Any, name: str = "case") -> str:
        """Return the digest of a value, which does not depend on the order of its keywords.

        Raises
        ------
        InputTypeError
            If the value contains a function and there is no key, or contains an object whose
            content cannot be read.
        """
        if isinstance(value, Mapping):
            value = dict(sorted(value.items(), key=repr))
        try:
            return self._digest((self.key, self._shared, value)).hex()
        except (TypeError, ValueError, RecursionError, pickle.PicklingError) as error:
            raise InputTypeError(
                f"{name}: a checkpoint cannot tell whether it has changed: {error}"
            ) from None

    def _digest(self, value: Any) -> bytes:
        content = io.BytesIO()
        _Content(content, self).dump(value)
        return blake2b(content.getbuffer(), digest_size=_SIZE).digest()


class _Content(pickle.Pickler):
    """Pickler of the content of values, without caches and code; equal values give equal bytes."""

    def __init__(self, file: io.BytesIO, digests: Digests) -> None:
        super().__init__(file, protocol=5)
        self.fast = True  # no memo: bytes do not depend on which parts are shared
        self._digests = digests

    def reducer_override(self, value: Any) -> Any:
        """Return what pickle stores for a value: a tuple of the name of its class and its parts."""
        kind: Any = type(value)
        parts: Any = None
        if isinstance(value, type):
            return NotImplemented
        if sp.issparse(value):
            csr = value.tocsr()
            parts = csr.shape, csr.indptr, csr.indices, csr.data
        elif isinstance(value, np.ndarray | np.generic):
            content = value.tolist() if value.dtype.hasobject else value.tobytes()
            parts = value.dtype.str, value.shape, content
        elif dataclasses.is_dataclass(kind) or (hasattr(value, "__dict__") and not callable(value)):
            model = isinstance(value, FEModel)  # immutable: its digest is cached
            parts = self._digests.once(value) if model else _parts(value)
        elif callable(value):
            if self._digests.key is None:
                raise TypeError("for functions give key=, a text that you change with them")
            parts = getattr(value, "__module__", ""), getattr(value, "__qualname__", "")
        else:
            return NotImplemented
        return tuple, (f"{kind.__module__}.{kind.__qualname__}", parts)


def _parts(value: Any) -> list[Any]:
    """Return the attributes of an object, except those that are computed when first read."""
    if dataclasses.is_dataclass(value):
        fields = dataclasses.fields(value)
        return [getattr(value, of.name) for of in fields if not of.metadata.get("identity")]
    kept, kind = sorted(vars(value)), type(value)
    kept = [name for name in kept if not isinstance(getattr(kind, name, None), cached_property)]
    return [(name, getattr(value, name)) for name in kept]
