"""Lines of keys, wherever TOML lets them stand."""

from __future__ import annotations

import tomllib
from itertools import accumulate

from hypothesis import given
from hypothesis import strategies as st
from rows import each

from aoimpact.scenefile import Place, line_of

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
ARRAY = ("bodies", "ball", "quoted name", "sub")
LINES: dict[Place, int | None] = {
    ("title",): 2,
    ("bodies",): 4,
    ("bodies", "ball"): 4,
    ("bodies", "ball", "mass"): 5,
    ARRAY: 6,
    (*ARRAY, 0): 7,
    (*ARRAY, 1): 7,
    (*ARRAY, 2): 8,
    (*ARRAY, 2, 0): 8,
    (*ARRAY, 2, 1): 9,
    (*ARRAY, 3, "b", "c"): 9,
    ("bodies", "ball", "date"): 12,
    ("bodies", "ball", "long"): 13,
    ("bodies", "ball", "literal"): 16,
    ("rows", 0): 17,
    ("rows", 1, "x"): 20,
    ("rows", 1, "below", "y"): 22,
    ("rows", 1, "inner", 0, "z"): 24,
    ("rows", 1, "inner", 0, "tab"): 27,
    # What is not there is in the table around it.
    ("bodies", "ball", "radius"): 4,
    ("rows", 1, "below", "y", 3): 22,
    ("no", "table"): None,
    (): None,
}


@each("ends", ["\n", "\r\n"])
@each("place", LINES)
def test_every_key_has_its_line(place: Place, ends: str) -> None:
    assert line_of(TEXT.replace("\n", ends), place) == LINES[place]


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
    entries = [f"key{i} = {value} # comment" for i, value in enumerate(values)]
    text = "\n".join(entries)
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError:  # a line break within braces
        return
    begins = accumulate((entry.count("\n") + 1 for entry in entries), initial=1)
    for i, line in zip(range(len(entries)), begins, strict=False):
        assert line_of(text, (f"key{i}",)) == line
