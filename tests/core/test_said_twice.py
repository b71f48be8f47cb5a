"""What stands both in Python and in the core is the same: columns of tables, shares."""

from __future__ import annotations

import re
from pathlib import Path

from aoimpact.batch import ANSWERS
from aoimpact.integrate import settings
from aoimpact.laws import law

ROOT = Path(__file__).parents[2]
CSRC = ROOT / "csrc"


def enumerated(file: str, first: str) -> dict[str, int]:
    """Names and values of the enum in a file of the core that begins with a name."""
    (body,) = re.findall(
        rf"enum\s*\w*\s*{{\s*({first}\b[^}}]*)}}", (CSRC / file).read_text("utf-8")
    )
    values, last = dict[str, int](), -1
    for entry in body.split(","):
        name, _, given = map(str.strip, entry.partition("="))
        values[name] = last = eval(given, {}, values) if given else last + 1
    return values


def test_columns_of_plain_impacts() -> None:
    case = enumerated("python/many.c", "CASE_VELOCITY")
    assert case.pop("CASE_COLUMNS") == len(case)
    given = {"CASE_VELOCITY": 0, "CASE_GAP": 1, "CASE_DURATION": 2, "CASE_RTOL": 3}
    assert case == given
    brief = (CSRC / "track/brief.h").read_text("utf-8")
    (body,) = re.findall(r"struct aoi_brief \{(.*?)\}", brief, re.S)
    fields = re.findall(r"(\w+)(?=[,;]|\[2\])", re.sub(r"/\*.*?\*/", "", body))
    assert ("STATUS", *(name.upper() for name in fields[:-1]), "FIRST", "SECOND") == ANSWERS
    assert fields[-1] == "velocity"


def test_shares() -> None:
    for file, name, here in (
        ("law/law.c", "MOST_SHARE", law.MOST_SHARE),
        ("adaptive/step.h", "LESSER_SHARE", settings.LESSER),
    ):
        text = (CSRC / file).read_text("utf-8")
        (there,) = re.findall(rf"\bdouble {name} = ([\d.e-]+);", text)
        assert float(there) == here


def test_every_law_of_the_core_is_described_tested_and_fuzzed() -> None:
    """csrc/law has the table: names, and how many parameters each takes."""
    files = "\n".join(file.read_text("utf-8") for file in (CSRC / "law").glob("*.c"))
    laws = dict(re.findall(r'{"(\w+)",\s*(\d+),', files))
    assert len(laws) > 8
    header = re.search(
        r"Makes the law of that name(.*?)\*/",
        (ROOT / "include/aoimpact.h").read_text("utf-8"),
        re.S,
    )
    assert header is not None
    assert set(re.findall(r"(\w+)(?=: k\b| and \w+: k\b)", header[1])) == set(laws)
    fuzzer = (ROOT / "tests/c/fuzz/fuzz.h").read_text("utf-8")
    assert dict(re.findall(r'\{"(\w+)", (\d), ', fuzzer)) == laws
    tests = (ROOT / "tests/c/test_law.c").read_text("utf-8")
    tried, after = tests.split("wanted[] = {")
    formulas = after.split("};")[0]
    for place, text in (("every", tried), ("wanted", formulas + PIECEWISE)):
        missing = [name for name in laws if f'{{"{name}", ' not in text]
        assert not missing, f"tests/c/test_law.c, {place}: {missing}"


# Of these test_law.c has other formulas: they pull, or depend on what was before.
PIECEWISE = '{"kelvin_voigt_pulling", {"thornton", {"elastic_plastic", {"yang_sun", '


def test_every_mutant_is_of_what_the_core_says() -> None:
    """Mutants are tried rarely; a formula that changes takes its mutant along."""
    table = (ROOT / "tests" / "c" / "mutants.txt").read_text("utf-8")
    rows = [line.replace(r"\n", "\n").split("\t")[:2] for line in table.splitlines()]
    gone = [row for row in rows if row[1] not in (CSRC / row[0]).read_text("utf-8")]
    assert not gone
