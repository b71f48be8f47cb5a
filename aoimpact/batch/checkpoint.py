"""A file of finished cases, from which a sweep that was stopped resumes.

It is text: a line of JSON for each case, with its digest, its numbers or its error, and its
warnings. Nothing in it is executed. Cases are found by their digests, so they may be changed, added
or reordered. Lines are only added, each by a single write: sweeps may share a file, and a process
that is killed leaves at most its last line incomplete, which is ignored.
"""

from __future__ import annotations

import json
import os
from contextlib import ExitStack
from typing import Any

from ..base import AOImpactError, InputError, InputTypeError, file_path, warn

# Value kept of a case, or its exception; and its warnings.
Outcome = tuple[Any, tuple[str, ...]]

_HEAD = b'{"aoimpact": "checkpoint"}\n'


class Checkpoint:
    """Finished cases by their digests, on disk.

    Parameters
    ----------
    path : path
        Made if it is not there.

    Raises
    ------
    InputError
        If the file is something else, or cannot be opened.

    Warns
    -----
    AOImpactWarning
        If lines are damaged: they are ignored.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        name = str(file_path("checkpoint", path))
        self._places: dict[str, int] = {}
        with ExitStack() as stack:
            try:
                # Without buffer: each line is written at once.
                self._written = stack.enter_context(open(name, "ab", buffering=0))
                self._read = stack.enter_context(open(name, "rb"))
            except OSError as error:
                raise InputError(
                    f"checkpoint {name!r} cannot be opened: {error.strerror}; give another path"
                ) from None
            self._read_all(name)
            self._files = stack.pop_all()

    def _read_all(self, name: str) -> None:
        """Find all lines; cut off an incomplete last one."""
        head = self._read.readline()
        if not _HEAD.startswith(head):
            raise InputError(f"checkpoint {name!r} is a file of another kind; give another path")
        if head != _HEAD:  # new, or killed during its first write
            self._written.truncate(0)
            self._written.write(_HEAD)
            return
        place, damaged = len(head), 0
        for line in self._read:
            if not line.endswith(b"\n"):
                self._written.truncate(place)
                break
            try:
                record = json.loads(line)
                _outcome(record)
                self._places[record["case"]] = place
            except (ValueError, TypeError, LookupError, AttributeError, RecursionError):
                damaged += line != _HEAD
            place += len(line)
        if damaged:
            warn(f"checkpoint {name!r} is damaged in {damaged} lines: their cases are run again")

    def __contains__(self, digest: str) -> bool:
        return digest in self._places

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, *_: object) -> None:
        """Wait until everything is on the disk, and release the file."""
        os.fsync(self._written.fileno())
        self._files.close()

    def get(self, digest: str) -> Outcome:
        """Return the outcome under a digest."""
        self._read.seek(self._places[digest])
        return _outcome(json.loads(self._read.readline()))

    def put(self, digest: str, outcome: Outcome) -> None:
        """Write a line; it survives if the process is killed after that.

        `get` has it when the file is opened again. Errors that are not this package's are left out.
        """
        value, messages = outcome
        record: dict[str, Any] = {"case": digest, "warnings": messages}
        if isinstance(value, AOImpactError):
            record["error"] = [type(value).__name__, value.args, vars(value)]
        elif isinstance(value, Exception):
            return  # it may not occur again
        else:
            record["value"] = value
        self._written.write(f"{json.dumps(record, default=str)}\n".encode())


def as_json(value: Any) -> Any:
    """Return what a function kept as a checkpoint gives it back: numbers, texts, lists and dicts.

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


def _outcome(record: Any) -> Outcome:
    messages = tuple(map(str, record["warnings"]))
    if "error" not in record:
        return record["value"], messages
    name, arguments, state = record["error"]
    kind = {kind.__name__: kind for kind in _kinds(AOImpactError)}[name]
    error = kind.__new__(kind, *arguments)  # their own __init__ takes other arguments
    error.args = tuple(arguments)
    vars(error).update(state)
    return error, messages


def _kinds(kind: type[AOImpactError]) -> list[type[AOImpactError]]:
    return [kind, *(lower for each in kind.__subclasses__() for lower in _kinds(each))]
