"""Line numbers of keys and array entries in a TOML text; tomllib itself reports none.

A place begins in the first line for which the text up to the line's end contains the place. To
parse this text by tomllib, its open strings and brackets are closed.
"""

from __future__ import annotations

import bisect
import re
import tomllib
from typing import Any

# Path to a value in a file: names of tables and keys, and indices of array entries.
Place = tuple[str | int, ...]

# Pattern of tokens: multi-line strings, which may end with two more quotes; strings in one line;
# comments; brackets; ends of lines.
_TOKEN = re.compile(
    r'"""(?:[^"\\]|\\.|"{1,2}(?!"))*"{3,5}'
    r"|'''(?:[^']|'{1,2}(?!'))*'{3,5}"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'[^'\n]*'"
    r"|#[^\n]*"
    r"|[][{}\n]",
    re.DOTALL,
)


# Maximum length, characters, of a text in which lines are searched: the search parses some twenty
# beginnings of the text, which takes half a second at this length.
_LONGEST = 100_000


def line_of(text: str, place: Place) -> int | None:
    """Return the line, from 1, where a place of a TOML text begins.

    If the text does not contain the place, the line of the nearest enclosing table is returned. The
    result is None for the text as a whole, and if the text is too long to be searched.
    """
    if len(text) > _LONGEST:
        return None
    data = tomllib.loads(text)
    while not holds(data, place):
        place = place[:-1]
    if not place:
        return None
    lines = text.split("\n")
    # For each line, the characters that close the strings and brackets open at its end.
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
    """Return whether the data that tomllib returned contain a place."""
    for part in place:
        try:
            data = data[part]
        except (LookupError, TypeError):
            return False
    return True
