#!/usr/bin/env python3
"""Count lines of code by folder and hold them to the limits of `tools/lines.toml`.

    python tools/lines.py      # a table; fails where a limit is exceeded, missing, stale or raised

Blank lines, comments and docstrings do not count. `tokens` is the number of Python's tokens without
layout, `marks` that of semicolons and opening braces in C: if lines fall and these do not, code was
packed into fewer lines.
"""

from __future__ import annotations

import ast
import io
import re
import subprocess
import tokenize
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
LIMITS = "tools/lines.toml"
LAYOUT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def python(text: str) -> tuple[int, int, int]:
    """Return the lines of code, tokens and marks (0) of a Python file."""
    docs, code, tokens = set[int](), set[int](), 0
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            docs.update(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in LAYOUT | {tokenize.ENDMARKER}:
            tokens += 1
            code.update(range(token.start[0], token.end[0] + 1))
    return len(code - docs), tokens, 0


def c(text: str) -> tuple[int, int, int]:
    """Return the lines of code, tokens (0) and marks of a C file."""
    comment = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
    text = comment.sub(lambda found: "\n" * found[0].count("\n"), text)
    return sum(map(bool, map(str.strip, text.splitlines()))), 0, len(re.findall("[;{]", text))


def git(*words: str) -> list[str]:
    return subprocess.check_output(["git", "-C", ROOT, *words], text=True).splitlines()


def counted() -> dict[str, list[int]]:
    """Return lines, tokens and marks of top-level folders, of the folders in them, and of stubs."""
    found: dict[str, list[int]] = {}
    for name in git("ls-files", "--cached", "--others", "--exclude-standard"):
        path = ROOT / name
        if path.suffix not in {".py", ".pyi", ".c", ".h", ".inc"} or not path.exists():
            continue
        numbers = (python if path.suffix[:3] == ".py" else c)(path.read_text(encoding="utf-8"))
        folders = {name.split("/")[0], "/".join(name.split("/")[:-1][:2])} - {""}
        for folder in {"stubs"} if path.suffix == ".pyi" else folders:
            found[folder] = [*map(sum, zip(found.get(folder, [0, 0, 0]), numbers, strict=True))]
    return found


def faults(found: dict[str, list[int]], limits: dict[str, Any]) -> list[str]:
    """Return a sentence for each limit that does not hold."""
    sums, rooms, start = limits["sums"], limits["rooms"], limits["start"]
    wanted = {key for key in found if "/" not in key or key.startswith(("aoimpact/", "csrc/"))}
    given = sums | rooms
    said = [f"{key} has no limit" for key in sorted(wanted - set(given))]
    said += [f"{key} has a limit, and no code" for key in sorted(set(given) - set(found))]
    for key, limit in given.items():
        if key in found and found[key][0] > limit:
            said.append(f"{key} has {found[key][0]} lines of code, above its limit {limit}")
    for key, before in start.items():
        if sum(found[key][1:]) / sum(before[1:]) > found[key][0] / before[0] + 0.05:
            said.append(f"{key} has more tokens or marks than its lines explain: they are packed")
    for key in sums:
        within = sum(limit for room, limit in rooms.items() if room.startswith(f"{key}/"))
        if within > sums[key]:
            said.append(f"rooms of {key} have limits of {within} lines, above its own {sums[key]}")
    commits = git("log", "--format=%H", "--", LIMITS)
    past = []
    for commit in commits:
        with suppress(tomllib.TOMLDecodeError):  # one commit has conflict markers in it
            past.append(tomllib.loads("\n".join(git("show", f"{commit}:{LIMITS}"))))
    said += ["[start] has changed: it stays"] * any(one["start"] != start for one in past)
    for key, limit in sums.items():
        lowest = min((one["sums"].get(key, limit) for one in past), default=limit)
        if limit > lowest:
            said.append(f"{key} has a limit of {limit}, above {lowest} of before: sums only fall")
    return said


def main() -> None:
    found = counted()
    limits = tomllib.loads((ROOT / LIMITS).read_text(encoding="utf-8"))
    given = limits["sums"] | limits["rooms"]
    print(f"{'folder':24}{'code':>8}{'limit':>8}{'tokens':>9}{'marks':>8}")
    for key, (lines, tokens, marks) in sorted(found.items()):
        print(f"{key:24}{lines:8}{given.get(key, ''):>8}{tokens or '':>9}{marks or '':>8}")
    if said := faults(found, limits):
        raise SystemExit("\n".join(["", *said, f"Limits are those of {LIMITS}."]))


if __name__ == "__main__":
    main()
