"""Random damage to files, such as that by transfers, editors and faulty programs."""

from __future__ import annotations

import random
import re
import struct

# Replacements of a number in a text.
_WORDS = """
    0 1 -1 2
    99999999 1000000 1000000000 100000000000
    2147483647 2147483648
    4294967295 4294967296
    9223372036854775807 9223372036854775808 18446744073709551615
    3.5 -0.0 1e23
    1e308 -1e308 1e309
    5e-324 1e-300
    nan inf -inf
    1e 0x10 1_000 x
"""
NUMBERS = [*_WORDS.split(), "", "1 2", "1" + 400 * "0"]

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eEdD][-+]?\d+)?")

# Replacements of an integer in binary data.
_WHOLE = """
    0 1 2 255 65536
    1000000 100000000 1000000000 100000000000
    0x10000000 0x7fffffff 0x80000000 0xffffffff
    0x200000000 0x10000000000
    0x4000000000000000 0x7fffffffffffffff 0x8000000000000000 0xffffffffffffffff
"""
_INTEGERS = [int(word, 0) for word in _WHOLE.split()]


def damaged(rng: random.Random, content: bytes, other: bytes = b"") -> bytes:
    """Return bytes with one to three random kinds of damage."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        (way,) = rng.choices([*_WAYS], [*_WAYS.values()])
        content = way(rng, content) if way is not _splice else _splice(rng, content, other)
    return content


def _replaced(content: bytes, one: re.Match[bytes], new: str) -> bytes:
    return content[: one.start()] + new.encode() + content[one.end() :]


def _number(rng: random.Random, content: bytes) -> bytes:
    found = list(_NUMBER.finditer(content))
    if not found:
        return content
    # The first numbers are chosen more often: counts stand at the beginning of files.
    one = rng.choice(found[:40] if rng.random() < 0.4 else found)
    return _replaced(content, one, rng.choice(NUMBERS))


def _nudge(rng: random.Random, content: bytes) -> bytes:
    """Return content with an integer changed by one, in sign, or by a factor."""
    found = [one for one in _NUMBER.finditer(content) if re.fullmatch(rb"[-+]?\d{1,19}", one[0])]
    if not found:
        return content
    one = rng.choice(found)
    value = int(one[0])
    new = rng.choice((value + 1, value - 1, -value, 10 * value, value * 10**8, value // 2))
    return _replaced(content, one, str(new))


def _binary(rng: random.Random, content: bytes) -> bytes:
    if len(content) < 16:
        return content
    at, size = rng.randrange(len(content) - 8), rng.choice((1, 2, 4, 8))
    if rng.random() < 0.7:
        at -= at % 4
    value = rng.choice(_INTEGERS) % 2 ** (8 * size)
    raw = value.to_bytes(size, "big" if rng.random() < 0.5 else "little")
    if rng.random() < 0.2:
        raw = struct.pack("<d", rng.choice((float("nan"), float("inf"), 1e308, 5e-324, -1.0)))
    return content[:at] + raw + content[at + len(raw) :]


def _flip(rng: random.Random, content: bytes) -> bytes:
    changed = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 5, 20)) if changed else 0):
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _cut(rng: random.Random, content: bytes) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


def _moved(rng: random.Random, content: bytes) -> bytes:
    """Return content with some bytes missing, repeated, or inserted."""
    start, length = rng.randrange(len(content) + 1), rng.choice((1, 2, 4, 8, 50, 100, 1000))
    what = rng.choice([b"\xff\xfe", *(bytes([one]) for one in b'\x00\n\r \t,#*$"(]')])
    between = rng.choice((b"", content[start : start + length], what * rng.choice((1, 1, 3, 300))))
    return content[:start] + between + content[start + (0 if between else length) :]


def _lines(rng: random.Random, content: bytes) -> bytes:
    lines = content.splitlines(keepends=True)
    if len(lines) < 3:
        return content
    i, j = sorted(rng.sample(range(len(lines)), 2))
    way = rng.randrange(5)
    if way == 0:
        del lines[i : rng.choice((i + 1, j))]
    elif way <= 2:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines[j:j] = lines[i : rng.choice((i + 1, j))]
    return b"".join(lines)


def _splice(rng: random.Random, content: bytes, other: bytes = b"") -> bytes:
    return _cut(rng, content) + other[rng.randrange(len(other) + 1) :]


# Relative frequency of each kind of damage.
_WAYS = {
    **{_number: 3, _moved: 3, _nudge: 2, _binary: 2, _flip: 2, _lines: 2},
    **{_cut: 1, _splice: 1},
}
