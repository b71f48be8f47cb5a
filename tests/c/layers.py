"""The order of the core's folders: no #include, and no symbol, from a later folder.

Files of one folder use each other in an order, too: no circle.

    python3 layers.py build     where build/<folder>/*.o are the compiled files

A header whose first line says "Private to <folder>/" is included there only.
Comments of the public header name nothing of the core that it does not declare.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

CORE = Path(__file__).resolve().parents[2] / "csrc"
PUBLIC = CORE.parent / "include" / "aoimpact.h"

# A folder may use those before it; newmark and motion know nothing of each other, and multigrid
# serves Python alone.
ORDER = ["linear", "multigrid", "star", "law", "model", "newmark", "motion", "collocation"]
ORDER += ["adaptive", "track", "python"]
STRANGERS = {("motion", "newmark"), ("collocation", "newmark"), ("adaptive", "newmark")}
STRANGERS |= {(folder, "multigrid") for folder in ORDER[2:-1]}


def may_use(folder: str, other: str) -> bool:
    earlier = ORDER.index(other) <= ORDER.index(folder)
    return earlier and (folder, other) not in STRANGERS


def wrong_includes() -> list[str]:
    wrong = []
    for path in sorted(CORE.glob("*/*.[ch]")):
        folder = path.parent.name
        for name in re.findall(r'#include "(\w+/\w+\.h)"', path.read_text()):
            other, private = name.split("/")[0], "Private to" in (CORE / name).read_text()[:20]
            if not may_use(folder, other) or (private and other != folder):
                wrong.append(f"{folder}/{path.name} includes {name}")
    return wrong


def symbols(folder: Path, kind: str, only: str = "*") -> set[str]:
    sources = {path.stem for path in (CORE / folder.name).glob(f"{only}.c")}
    files = [str(path) for path in folder.glob("*.o") if path.stem in sources]
    told = subprocess.run(["nm", "-g", *files], capture_output=True, text=True, check=True).stdout
    return set(re.findall(rf"^[\da-f ]* {kind} _?(aoi_\w+)$", told, re.MULTILINE))


def wrong_symbols(build: Path) -> list[str]:
    wrong = []
    folders = [name for name in ORDER if (build / name).is_dir()]
    defined = {name: symbols(build / name, "[TDRB]") for name in folders}
    for folder in folders:
        used = symbols(build / folder, "U") - defined[folder]
        for other in folders:
            if not may_use(folder, other):
                wrong += [f"{folder}/ uses {name} of {other}/" for name in used & defined[other]]
    return wrong


def circles(build: Path) -> list[str]:
    """Files of one folder that need each other."""
    found = []
    for folder in (build / name for name in ORDER if (build / name).is_dir()):
        files = [path.stem for path in sorted((CORE / folder.name).glob("*.c"))]
        has = {name: symbols(folder, "[TDRB]", name) for name in files}
        needs = {name: symbols(folder, "U", name) for name in files}
        left = set(files)
        while free := {a for a in left if not any(needs[a] & has[b] for b in left - {a})}:
            left -= free
        if left:
            found.append(f"{folder.name}/: {', '.join(sorted(left))} stand in a circle")
    return found


def undeclared() -> list[str]:
    """Names and files of the core that comments of the public header send its reader to."""
    text = PUBLIC.read_text()
    comments = " ".join(re.findall(r"/\*.*?\*/", text, re.DOTALL))
    declared = set(re.findall(r"\w+", re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)))
    named = set(re.findall(r"\baoi_\w+|\bAOI_\w+", comments)) - declared
    named |= set(re.findall(r"\bcsrc/\w+|\w+/\w+\.h\b", comments))
    return [f"aoimpact.h speaks of {name}, which it does not have" for name in sorted(named)]


if __name__ == "__main__":
    build = Path(sys.argv[1])
    found = undeclared() + wrong_includes() + wrong_symbols(build) + circles(build)
    print("\n".join(found) or "layers: in order")
    sys.exit(bool(found))
