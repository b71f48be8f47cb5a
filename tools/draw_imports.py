"""Draw which folder imports which, in CONTRIBUTING.md: `python tools/draw_imports.py`.

A folder imports only what stands to its left: the drawing has no mark on or above the diagonal.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

import grimp

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "CONTRIBUTING.md"
BEGIN, END = "<!-- imports: python tools/draw_imports.py -->\n", "<!-- end of imports -->\n"


def drawing() -> str:
    """Return a row of marks for each folder, in the order that lint-imports holds."""
    sys.path.insert(0, str(ROOT))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = project["tool"]["importlinter"]["contracts"][0]["layers"][::-1]
    graph = grimp.build_graph("aoimpact", cache_dir=None)
    for folder in folders:
        graph.squash_module(f"aoimpact.{folder}")
    width = max(map(len, folders))
    rows = []
    for row, folder in enumerate(folders):
        imported = graph.find_modules_directly_imported_by(f"aoimpact.{folder}")
        marks = [
            "■" if f"aoimpact.{other}" in imported else "·" if column < row else " "
            for column, other in enumerate(folders)
        ]
        marks[row] = "\\"
        rows.append(f"{folder:{width}}  {'  '.join(marks)}")
    heads = [name.rjust(width) for name in folders]
    above = [" " * (width + 2) + "  ".join(name[i] for name in heads) for i in range(width)]
    return "\n".join(line.rstrip() for line in above + rows)


def page(text: str) -> str:
    """Return CONTRIBUTING.md with the drawing made anew."""
    block = f"{BEGIN}\n```\n{drawing()}\n```\n\n{END}"
    return re.sub(re.escape(BEGIN) + ".*?" + re.escape(END), lambda _: block, text, flags=re.DOTALL)


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
