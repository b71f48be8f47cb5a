"""A file of finished cases, from which a sweep that was stopped resumes.

The file is text, with a line of JSON for each case: its digest, its numbers and its warnings.
Nothing in it is executed. Cases are identified by a digest of their content, without caches and the
same in every process, so that cases may be changed, added or reordered. Lines are only added, each
by a single write: sweeps may share a file, and a process that is killed leaves at most its last
line incomplete, which is ignored. Cases that failed are not kept: they are run again.
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

# Outcome of a case: the value kept of it, or its exception; and its warnings.
Outcome = tuple[Any, tuple[str, ...]]

_HEAD = b'{"aoimpact": "checkpoint"}\n'

# Length of a digest, bytes: two of 10¹² cases have the same digest with a probability of 1e-15.
_SIZE = 16

# Number of bodies whose digests are kept; the cases of a sweep share a handful of bodies.
_MOST_REMEMBERED = 16


class Checkpoint:
    """Finished cases by their digests, on disk.

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
        If lines are damaged: they are ignored.
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
                        raise InputError(f"{name} is a file of another kind; give another path")
                    if not line.endswith(b"\n"):  # the process was killed as it wrote
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
        self._written = open(self._name, "ab", buffering=0)  # each line is written at once
        return self

    def __exit__(self, *_: object) -> None:
        """Wait until everything is on the disk, and release the file."""
        os.fsync(self._written.fileno())
        self._written.close()

    def get(self, digest: str) -> Outcome:
        """Return the outcome under a digest."""
        return self._known[digest]

    def put(self, digest: str, outcome: Outcome) -> None:
        """Write the outcome of a case that has not failed; it survives if the process is killed.

        `get` returns the outcome after the file has been opened again.
        """
        value, messages = outcome
        if not isinstance(value, Exception):
            record = {"case": digest, "warnings": messages, "value": value}
            self._written.write(f"{json.dumps(record)}\n".encode())


def as_json(value: Any) -> Any:
    """Return a value as a checkpoint restores it: made of numbers, strings, lists and dicts.

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
    """Digests of cases; bodies that many cases share are digested once.

    Parameters
    ----------
    key : str or None
        Text that stands for the code of functions, of which only the names enter a digest; None
        refuses functions.
    shared : optional
        Value that enters the digest of every case.
    """

    def __init__(self, key: str | None, shared: Any = None) -> None:
        self.key, self._shared = key, shared
        self.once = lru_cache(_MOST_REMEMBERED)(lambda value: self._digest(_parts(value)))

    def of(self, value: Any, name: str = "case") -> str:
        """Return the digest of a value; the order of its keywords does not count.

        Raises
        ------
        InputTypeError
            If the value has a function and there is no key, or has an object whose content cannot
            be read.
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
    """Pickles the content of values without caches and code; equal values give equal bytes."""

    def __init__(self, file: io.BytesIO, digests: Digests) -> None:
        super().__init__(file, protocol=5)
        self.fast = True  # no memo: equal parts give the same bytes even if one object is shared
        self._digests = digests

    def reducer_override(self, value: Any) -> Any:
        """Return how pickle rebuilds a value: as a tuple of its class and of its parts."""
        kind: Any = type(value)
        parts: Any = None
        if isinstance(value, type):
            return NotImplemented
        if sp.issparse(value):
            csr = value.tocsr()
            parts = csr.shape, csr.indptr, csr.indices, csr.data
        elif isinstance(value, np.ndarray):
            content = value.tolist() if value.dtype.hasobject else value.tobytes()
            parts = value.dtype.str, value.shape, content
        elif dataclasses.is_dataclass(kind) or (hasattr(value, "__dict__") and not callable(value)):
            model = isinstance(value, FEModel)  # does not change after it is made, unlike a scene
            parts = self._digests.once(value) if model else _parts(value)
        elif callable(value):
            if self._digests.key is None:
                raise TypeError("of functions give key=, a text that you change with them")
            parts = getattr(value, "__module__", ""), getattr(value, "__qualname__", "")
        else:
            return NotImplemented
        return tuple, (f"{kind.__module__}.{kind.__qualname__}", parts)


def _parts(value: Any) -> list[Any]:
    """Return the attributes of an object, without attributes that are computed when first read."""
    if dataclasses.is_dataclass(value):
        fields = dataclasses.fields(value)
        return [getattr(value, of.name) for of in fields if not of.metadata.get("identity")]
    kept, kind = sorted(vars(value)), type(value)
    kept = [name for name in kept if not isinstance(getattr(kind, name, None), cached_property)]
    return [(name, getattr(value, name)) for name in kept]
