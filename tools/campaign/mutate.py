"""Damage to text and bytes, as files suffer it: by transfers, editors and programs that err."""

from __future__ import annotations

import random
import re
import struct
from collections.abc import Callable

# What a number in a text may be replaced by.
NUMBERS = (
    "0",
    "1",
    "-1",
    "2",
    "3.5",
    "-0.0",
    "1e308",
    "-1e308",
    "1e309",
    "5e-324",
    "1e-300",
    "1e23",
    "nan",
    "inf",
    "-inf",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551615",
    "100000000000",
    "1000000000",
    "99999999",
    "1000000",
    "1" + 400 * "0",
    "1e",
    "0x10",
    "1_000",
    "",
    "x",
    "1 2",
)

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eEdD][-+]?\d+)?")

# And a number in binary.
_INTEGERS = (
    0,
    1,
    2,
    255,
    2**16,
    10**6,
    10**8,
    10**9,
    2**28,
    2**31 - 1,
    2**31,
    2**32 - 1,
    2**33,
    10**11,
    2**40,
    2**62,
    2**63 - 1,
    2**63,
    2**64 - 1,
)


def damaged(rng: random.Random, content: bytes, other: bytes = b"") -> bytes:
    """Return bytes with some damage, one to three kinds of it."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        (way,) = rng.choices([*_WAYS], [*_WAYS.values()])
        content = way(rng, content, other)
    return content


def _number(rng: random.Random, content: bytes, other: bytes) -> bytes:
    found = list(_NUMBER.finditer(content))
    if not found:
        return content
    # Counts stand at the beginning of files and sections.
    one = rng.choice(found[:40] if rng.random() < 0.4 else found)
    return content[: one.start()] + rng.choice(NUMBERS).encode() + content[one.end() :]


def _nudge(rng: random.Random, content: bytes, other: bytes) -> bytes:
    """A whole number that is off by little, or by a digit."""
    found = [
        one
        for one in _NUMBER.finditer(content)
        if one.group().lstrip(b"-+").isdigit() and len(one.group()) < 20
    ]
    if not found:
        return content
    one = rng.choice(found)
    value = int(one.group())
    new = rng.choice((value + 1, value - 1, -value, 10 * value, value * 10**8, value // 2))
    return content[: one.start()] + str(new).encode() + content[one.end() :]


def _binary(rng: random.Random, content: bytes, other: bytes) -> bytes:
    if len(content) < 16:
        return content
    at = rng.randrange(len(content) - 8)
    if rng.random() < 0.7:
        at -= at % 4
    size = rng.choice((1, 2, 4, 8))
    order = rng.choice(("little", "big"))
    value = rng.choice(_INTEGERS) % 2 ** (8 * size)
    raw = value.to_bytes(size, order)  # type: ignore[arg-type]
    if rng.random() < 0.2:
        raw = struct.pack("<d", rng.choice((float("nan"), float("inf"), 1e308, 5e-324, -1.0)))
    return content[:at] + raw + content[at + len(raw) :]


def _flip(rng: random.Random, content: bytes, other: bytes) -> bytes:
    changed = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 5, 20))):
        if changed:
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _cut(rng: random.Random, content: bytes, other: bytes) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


def _remove(rng: random.Random, content: bytes, other: bytes) -> bytes:
    start = rng.randrange(len(content) + 1)
    return content[:start] + content[start + rng.choice((1, 2, 4, 8, 50, 1000)) :]


def _repeat(rng: random.Random, content: bytes, other: bytes) -> bytes:
    start = rng.randrange(len(content) + 1)
    part = content[start : start + rng.choice((1, 4, 8, 100, 1000))]
    return content[:start] + part + content[start:]


def _insert(rng: random.Random, content: bytes, other: bytes) -> bytes:
    start = rng.randrange(len(content) + 1)
    what = rng.choice(
        (b"\x00", b"\xff\xfe", b"\n", b"\r", b" ", b"\t", b",", b"#", b"*", b"$", b'"', b"(", b"]")
    )
    return content[:start] + what * rng.choice((1, 1, 3, 300)) + content[start:]


def _lines(rng: random.Random, content: bytes, other: bytes) -> bytes:
    lines = content.splitlines(keepends=True)
    if len(lines) < 3:
        return content
    i, j = sorted(rng.sample(range(len(lines)), 2))
    way = rng.randrange(5)
    if way == 0:
        del lines[i]
    elif way == 1:
        del lines[i:j]
    elif way == 2:
        lines[i], lines[j] = lines[j], lines[i]
    elif way == 3:
        lines.insert(j, lines[i])
    else:
        lines[j:j] = lines[i:j]
    return b"".join(lines)


def _splice(rng: random.Random, content: bytes, other: bytes) -> bytes:
    return content[: rng.randrange(len(content) + 1)] + other[rng.randrange(len(other) + 1) :]


# How often each is chosen.
_WAYS: dict[Callable[[random.Random, bytes, bytes], bytes], int] = {
    **{_number: 3, _nudge: 2, _binary: 2, _flip: 2, _lines: 2},
    **dict.fromkeys((_cut, _remove, _repeat, _insert, _splice), 1),
}
