"""The line of every key and array entry of a TOML text, by tomllib, which gives none.

A place begins after the last line up to which the text does not hold it. A scanner took 105 lines
more, for columns as well; instead of them messages have the name of the place.
"""

from __future__ import annotations

import bisect
import tomllib
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

__all__ = ["Place", "holds", "line_of"]

# Names of tables and keys, and numbers of places in arrays.
Place = tuple[str | int, ...]

# What closes a text that ends inside an array, or inside one in another, as matrices are, or inside
# a string of several lines.
_CLOSINGS = ("", "]", "]]", '"""', "'''")

# Lines that are taken off a text to make it readable. Each is read again with all before it: over a
# string of 2000 lines, without its closing and this limit, 16 s.
_FAR = 10


def line_of(text: str, place: Place) -> int | None:
    """Return the line, from 1, where a place of a TOML text begins.

    That of the nearest table around a place that the text does not hold; None of the text as such,
    and where the text around the place is nested too deeply to tell.
    """
    lines = text.split("\n")
    with suppress(_UnreadableError):
        while place and not holds(_readable(lines)[1], place):
            place = place[:-1]
        ends = range(len(lines))
        before = bisect.bisect(ends, False, key=lambda n: holds(_readable(lines[:n])[1], place))
        return 1 + _readable(lines[: before - 1])[0] if place else None
    return None


def holds(data: Any, place: Place) -> bool:
    """Return whether there is such a place in what tomllib gives."""
    for part in place:
        try:
            data = data[part]
        except (LookupError, TypeError):
            return False
    return True


class _UnreadableError(Exception):
    """No text that ends near a line is TOML."""


def _readable(lines: Sequence[str]) -> tuple[int, Any]:
    """How many of the first lines of a text end a line of TOML or of an array, and their data.

    Raises
    ------
    _UnreadableError
        If none of the last `_FAR` lines ends one.
    """
    for end in range(len(lines), max(len(lines) - _FAR, -1), -1):
        for closing in _CLOSINGS:
            with suppress(tomllib.TOMLDecodeError):
                return end, tomllib.loads("\n".join((*lines[:end], closing)))
    raise _UnreadableError
