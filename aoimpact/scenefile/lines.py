"""The line of every key and array entry of a TOML text, by tomllib, which gives none.

A place begins in the first line up to which the text, with all closed that is open there, holds it.
"""

from __future__ import annotations

import bisect
import re
import tomllib
from typing import Any

# Names of tables and keys, and numbers of places in arrays.
Place = tuple[str | int, ...]

# Strings of several lines, which may end with two more quotes, and of one; comments; brackets; ends
# of lines.
_TOKEN = re.compile(
    r'"""(?:[^"\\]|\\.|"{1,2}(?!"))*"{3,5}'
    r"|'''(?:[^']|'{1,2}(?!'))*'{3,5}"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'[^'\n]*'"
    r"|#[^\n]*"
    r"|[][{}\n]",
    re.DOTALL,
)


# A text of more characters is searched for no lines: parts of it are read some twenty times, which
# takes half a second at this length.
_LONGEST = 100_000


def line_of(text: str, place: Place) -> int | None:
    """Return the line, from 1, where a place of a TOML text begins.

    That of the nearest table around a place that the text does not hold; None of the text as such,
    and of a long one.
    """
    if len(text) > _LONGEST:
        return None
    data = tomllib.loads(text)
    while not holds(data, place):
        place = place[:-1]
    if not place:
        return None
    lines = text.split("\n")
    # Characters that close the string, arrays and braces open at the end of each line.
    closings: list[str] = []
    brackets = ""
    for token in map(re.Match.group, _TOKEN.finditer(text)):
        if token in "[{":
            brackets = "]}"["[{".index(token)] + brackets
        elif token in "]}":
            brackets = brackets[1:]
        elif token == "\n":
            closings.append(brackets)
        else:
            closings += [token[:3] + brackets] * token.count("\n")

    def begun(line: int) -> bool:
        return holds(tomllib.loads("\n".join((*lines[:line], closings[line - 1]))), place)

    return 1 + bisect.bisect_left(range(1, len(lines)), True, key=begun)


def holds(data: Any, place: Place) -> bool:
    """Return whether there is such a place in what tomllib gives."""
    for part in place:
        try:
            data = data[part]
        except (LookupError, TypeError):
            return False
    return True
