"""Lines of numbers, parsed in bulk; a line that is none is found and shown."""

from __future__ import annotations

import os
import re
import warnings
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..base import InputError, warn
from .found import spoilt

NUMBER = rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"

_FORTRAN = re.compile(rb"(\d\.?)[dD](?=[-+]?\d)")


def columns(
    file: Path,
    stream: BinaryIO,
    integers: int,
    what: str,
    *,
    before: int = 0,
    comma: bool = False,
    comments: str | None = None,
) -> list[np.ndarray]:
    """Return the columns of the lines that follow: the integers and the value.

    Parameters
    ----------
    integers : int
        Number of integers before the value on each line.
    what : str
        Contents of a line, for messages.
    before : int, optional
        Lines of the file that have been read.
    comma : bool, optional
        True if commas separate numbers.
    comments : str, optional
        First character of comments.

    Raises
    ------
    InputError
        At the first line that is something else.
    """
    # Integers are parsed as such: that is twice as fast, and refuses other numbers.
    kind = np.dtype([*((f"i{i}", np.int64) for i in range(integers)), ("value", np.float64)])
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of no data
            table = np.loadtxt(
                stream,
                dtype=kind,
                comments=comments,
                delimiter="," if comma else None,
                ndmin=1,
                encoding="latin-1",
            )
    except (ValueError, OverflowError, RuntimeError) as error:
        raise _located(file, integers, what, before, comma, comments, str(error)) from None
    if not np.isfinite(table["value"]).all():
        raise _located(file, integers, what, before, comma, comments, "one is not finite")
    _warn_of_last_line(file)
    return [np.ascontiguousarray(table[name]) for name in kind.names or ()]


def _warn_of_last_line(file: Path) -> None:
    """Say that a last line has no end, so that its number may have lost digits of its exponent."""
    with file.open("rb") as stream:
        stream.seek(-1, os.SEEK_END)
        if stream.read(1) not in b"\n\r":
            warn(f"matrix file {str(file)!r} ends within a line: its last number may be cut short")


def _located(
    file: Path, integers: int, what: str, before: int, comma: bool, comments: str | None, why: str
) -> InputError:
    """The error at the first line that is wrong: slow, but of a file that is refused."""
    between = rb"\s*,\s*" if comma else rb"\s+"
    entry = re.compile(
        rb"\s*" + between.join([*integers * [rb"[-+]?\d{1,15}"], NUMBER]) + rb"\s*,?\s*$"
    )
    with file.open("rb") as stream:
        for number, line in enumerate(stream, 1):
            if number <= before or not line.strip():
                continue
            if comments and line.lstrip().startswith(comments.encode()):
                continue
            if not entry.match(line) or not np.isfinite(
                float(line.replace(b",", b" ").split()[-1])
            ):
                cause = "is the file cut short, or of another format?"
                if entry.match(_FORTRAN.sub(rb"\1E", line)):
                    cause = "write exponents with E, not Fortran's D"
                return spoilt(file, f"{what} should stand here, got {shown(line)}: {cause}", number)
    return spoilt(file, f"{what} should stand on each line: {why}")


def shown(line: bytes) -> str:
    """A line as messages quote it."""
    text = line.decode("latin-1").strip()
    return repr(text if len(text) < 60 else text[:57] + "...") if text else "an empty line"
