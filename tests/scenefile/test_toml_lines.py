"""Lines and columns of keys, wherever TOML lets them stand."""

from __future__ import annotations

import tomllib
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from aoimpact.scenefile.toml_lines import spot_of, toml_spots

TEXT = '''\
# a comment with [brackets] and a = 1
title = "a # in text, a \\" and a ]"   # 2

[bodies.ball]          # 4
mass = 1e-3
"quoted name" . sub = [   # 6
    1, 2,
    [3,  # 8 ]
     4], { a = 5, b.c = "}" },

]
date = 1979-05-27 07:32:00
long = """
mass = 2
a \\""" quote"""""  # 15
literal = 'C:\\'
[[rows]]               # 17
x = 1
[[rows]]
x = 2
  [rows.below]         # 21
  y = true
[[rows.inner]]
z = \'\'\'
[no.table]
\'\'\'
"t\\u0061b" = 1        # 27
'''


def test_every_key_has_its_line() -> None:
    tomllib.loads(TEXT)
    spots = toml_spots(TEXT)
    lines = {place: spot.line for place, spot in spots.items()}
    assert lines[("title",)] == 2
    assert lines[("bodies",)] == lines[("bodies", "ball")] == 4
    assert lines[("bodies", "ball", "mass")] == 5
    array = ("bodies", "ball", "quoted name", "sub")
    assert [lines[(*array, i)] for i in range(4)] == [7, 7, 8, 9]
    assert lines[(*array, 2, 0)] == 8
    assert lines[(*array, 2, 1)] == 9
    assert lines[(*array, 3, "b", "c")] == 9
    assert lines[("bodies", "ball", "date")] == 12
    assert lines[("bodies", "ball", "long")] == 13
    assert lines[("bodies", "ball", "literal")] == 16
    assert lines[("rows", 0)] == 17
    assert lines[("rows", 1, "x")] == 20
    assert lines[("rows", 1, "below", "y")] == 22
    assert lines[("rows", 1, "inner", 0, "z")] == 24
    assert lines[("rows", 1, "inner", 0, "tab")] == 27
    assert ("no", "table") not in lines
    # Columns: counted off the text above.
    assert spots[("bodies", "ball")].column == 9
    assert spots[array].column == 17
    assert [spots[(*array, i)].column for i in range(4)] == [5, 8, 5, 10]
    assert spots[(*array, 3, "b")].column == 19
    assert spots[(*array, 3, "b", "c")].column == 21
    assert spots[("rows", 1, "below", "y")].column == 3
    for (*_, name), (line, column) in spots.items():
        if isinstance(name, str) and name.isalpha() and name != "tab":
            assert TEXT.splitlines()[line - 1][column - 1 :].startswith(name)


def test_an_unknown_place_is_in_the_table_around_it() -> None:
    lines = toml_spots(TEXT)
    assert spot_of(lines, ("bodies", "ball", "radius")) == (4, 9)
    assert spot_of(lines, ("nowhere",)) is None


def places(value: Any, place: tuple[str | int, ...] = ()) -> set[tuple[str | int, ...]]:
    """Every place in what tomllib gives."""
    if isinstance(value, dict):
        inside = value.items()
    elif isinstance(value, list):
        inside = enumerate(value)  # type: ignore[assignment]
    else:
        return set()
    return {
        found for key, entry in inside for found in {(*place, key)} | places(entry, (*place, key))
    }


def test_it_finds_what_tomllib_finds() -> None:
    assert set(toml_spots(TEXT)) >= places(tomllib.loads(TEXT))


VALUES = st.recursive(
    st.sampled_from(["1", "-2.5e3", "inf", "true", '"te#xt"', "'[a]'", '"""a\n"b"\n"""', '""']),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda v: "[" + ",\n ".join(v) + "\n]"),
        st.lists(inner, max_size=3).map(
            lambda v: "{" + ", ".join(f"k{i} = {x}" for i, x in enumerate(v)) + "}"
        ),
    ),
    max_leaves=6,
)


@given(values=st.lists(VALUES, max_size=4))
def test_nothing_valid_leads_it_astray(values: list[str]) -> None:
    lines, at = [], {}
    for i, value in enumerate(values):
        at[i] = sum(line.count("\n") + 1 for line in lines) + 1
        lines.append(f"key{i} = {value} # comment")
    text = "\n".join(lines)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError:  # a line break within braces
        return
    found = toml_spots(text)
    assert set(found) == places(data)
    assert all(found[(f"key{i}",)] == (line, 1) for i, line in at.items())
