"""Test the C tests: with any one of these formulas wrong, some program must fail.

    python3 mutants.py [compiler]

Each line of mutants.txt is a file of the core, a piece of its text and its replacement, if it has
any, between tabs; "\\n" is the end of a line. A piece that has gone is an error: change that line
along with the formula. Mutants that only a sanitizer notices are left out.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

# s of processor time, which other work on the machine leaves alone; the longest of the programs
# takes four.
LONGEST = 20

HERE = Path(__file__).resolve().parent
CORE = HERE.parents[1] / "csrc"
PUBLIC = HERE.parents[1] / "include"

MUTANTS = [
    [part.replace(r"\n", "\n") for part in (*line.split("\t"), "")[:3]]
    for line in (HERE / "mutants.txt").read_text().splitlines()
]


def compile_file(
    compiler: str, source: Path, core: Path, compiled: Path, more: Sequence[str] = ()
) -> None:
    compiled.parent.mkdir(exist_ok=True)
    flags = ["-std=c99", "-O1", "-w", f"-I{PUBLIC}", f"-I{core}", f"-I{HERE}", *more]
    command = [compiler, *flags, "-c", source, "-o", compiled]
    subprocess.run(command, check=True)


def compiled(source: Path, out: Path) -> Path:
    return out / source.parent.name / f"{source.stem}.o"


def includes(source: Path, header: str) -> bool:
    return f'#include "{header}"' in source.read_text()


def passes(compiler: str, test: str, out: Path) -> bool:
    """True if a test program, linked with the core as it is now, passes."""
    objects = out.glob("*/*.o")
    program = out / test
    command = [compiler, out / f"{test}.o", *sorted(objects), "-lm", "-o", program]
    subprocess.run(command, check=True)
    limited = ["prlimit", f"--cpu={LONGEST}", program]
    return subprocess.run(limited, capture_output=True).returncode == 0


def noticed_by(compiler: str, tests: list[str], first: list[str], out: Path) -> str | None:
    """Return the test program that fails; those of `first` are tried before the others."""
    rest = [test for test in tests if test not in first]
    in_turn = [test for test in dict.fromkeys(first) if test in tests] + rest
    return next((test for test in in_turn if not passes(compiler, test, out)), None)


def main() -> int:
    compiler = sys.argv[1] if len(sys.argv) > 1 else "cc"
    tests = sorted(path.stem for path in HERE.glob("test_*.c"))
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        core, out = Path(folder, "csrc"), Path(folder, "build")
        shutil.copytree(CORE, core)
        out.mkdir()
        sources = [path for path in core.glob("*/*.c") if path.parent.name != "python"]
        for source in sources:
            compile_file(compiler, source, core, compiled(source, out))
        for test in tests:
            compile_file(compiler, HERE / f"{test}.c", core, out / f"{test}.o")
        if noticed_by(compiler, tests, [], out):
            print("the tests fail as it is")
            return 1
        last: dict[str, str] = {}  # the program that noticed the file's last mutant
        for name, old, new in MUTANTS:
            text = (CORE / name).read_text()
            if old not in text:
                print(f"{name}: '{old}' is not there any more")
                failed += 1
                continue
            (core / name).write_text(text.replace(old, new))
            changed = [path for path in sources if path == core / name or includes(path, name)]
            for path in changed:
                compile_file(compiler, path, core, compiled(path, out))
            own = [f"test_{part}" for part in (Path(name).stem, Path(name).parent.name)]
            found = noticed_by(compiler, tests, [last.get(name, own[0]), *own], out)
            if found:
                last[name] = found
            else:
                print(f"{name}: no test notices '{new}' for '{old}'")
                failed += 1
            (core / name).write_text(text)
            for path in changed:
                compile_file(compiler, path, core, compiled(path, out))
    print(f"mutants: {len(MUTANTS) - failed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
