"""What comments and docstrings say can be followed: files that they name exist, examples run."""

from __future__ import annotations

import doctest
import fnmatch
import importlib
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
from rows import each

import aoimpact as ao

ROOT = Path(__file__).parents[2]
FOLDERS = ("aoimpact", "benchmarks", "csrc", "docs", "examples", "include", "paper-results")
FOLDERS += ("tests", "tools")
ENDS = (".py", ".pyi", ".c", ".h", ".md", ".toml")
FILES = [
    file
    for place in (*(ROOT.joinpath(folder).rglob("*") for folder in FOLDERS), ROOT.glob("*.*"))
    for file in place
    if file.suffix in ENDS and "build" not in file.parts
]
KNOWN = [f"/{file.relative_to(ROOT).as_posix()}" for file in FILES]
ENDINGS = {path[at + 1 :] for path in KNOWN for at, sign in enumerate(path) if sign == "/"}

# A file of the project: "csrc/law/law.c", "law.c", "tests/c/test_*.c"; "../" is left out.
NAMED = re.compile(r"(?<![\w./<-])(?:\.\./)*((?:[\w.*-]+/)*[\w*]+\.(?:py|pyi|c|h|md))\b(?![/\w])")
OTHERS = {"Python.h", "first.py"}  # the compiler's; a user's


def said(file: Path) -> Iterator[str]:
    """The comments and docstrings of a file that names files; all of a page."""
    text = file.read_text(encoding="utf-8")
    if not NAMED.search(text):
        return
    if file.suffix in (".py", ".pyi"):
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type == tokenize.COMMENT or token.string.startswith('"""'):
                yield token.string
    elif file.suffix in (".c", ".h"):
        yield from re.findall(r"/\*.*?\*/", text, re.DOTALL)
    elif file.suffix == ".md" and file.name != "CHANGELOG.md":  # which tells of the past
        yield text


def test_every_file_that_is_named_exists() -> None:
    named = {
        (file.relative_to(ROOT).as_posix(), name)
        for file in FILES
        for text in said(file)
        for name in NAMED.findall(text)
    }
    assert len(named) > 50
    stale = [
        f"{file} names {name}"
        for file, name in sorted(named)
        if not (name in OTHERS or name in ENDINGS or fnmatch.filter(KNOWN, f"*/{name}"))
    ]
    assert not stale, "\n".join(stale)


EXAMPLES = [
    file.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".").removesuffix(".__init__")
    for file in sorted(ROOT.joinpath("aoimpact").rglob("*.py"))
    if ">>> " in file.read_text(encoding="utf-8")
]


@each("name", EXAMPLES)
def test_examples_say_what_comes_out(name: str) -> None:
    module = importlib.import_module(name)
    public = {each: getattr(ao, each) for each in dir(ao) if not each.startswith("__")} | {"ao": ao}
    runner = doctest.DocTestRunner()
    # Examples of the package's public names are those of the modules that define them.
    finder = doctest.DocTestFinder(recurse=module is not ao)
    for test in finder.find(module, extraglobs=public | vars(module)):
        runner.run(test)
    plt.close("all")
    assert runner.tries > runner.failures == 0
