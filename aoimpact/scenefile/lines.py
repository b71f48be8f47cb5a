"""Line of every key and array entry of a TOML text, by means of tomllib, which reports no lines.

A place begins in the first line at which the text up to there, with open strings and brackets
closed, contains the place.
"""

from __future__ import annotations

import bisect
import re
import tomllib
from typing import Any

# Path to a value: names of tables and keys, and indices in arrays.
Place = tuple[str | int, ...]

# Tokens: strings of several lines, which may end with two more quotes, and of one line; comments;
# brackets; ends of lines.
_TOKEN = re.compile(
    r'"""(?:[^"\\]|\\.|"{1,2}(?!"))*"{3,5}'
    r"|'''(?:[^']|'{1,2}(?!'))*'{3,5}"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'[^'\n]*'"
    r"|#[^\n]*"
    r"|[][{}\n]",
    re.DOTALL,
)


# Maximum length of a text in which lines are searched, characters: its parts are parsed some twenty
# times, which takes half a second at this length.
_LONGEST = 100_000


def line_of(text: str, place: Place) -> int | None:
    """Return the line, from 1, where a place of a TOML text begins.

    If the text does not contain the place, the line of the nearest enclosing table is returned. It
    is None for the text as a whole, and in long texts.
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
    """Return whether tomllib's data contain a place."""
    for part in place:
        try:
            data = data[part]
        except (LookupError, TypeError):
            return False
    return True
