"""Make the notebooks from pages of the site, and store them with their outputs.

python tools/make_notebooks.py [NAME ...]      # writes notebooks/NAME.ipynb, all if none is named

Needs nbformat, nbclient and ipykernel, and gmsh for the page first_impact.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PAGES = (
    "start/first_impact",
    "how_to/choosing_a_model",
    "how_to/contact_and_mesh",
    "how_to/damping_and_restitution",
    "how_to/own_matrices",
    "how_to/several_bodies",
    "how_to/stress",
    "how_to/sweeps",
    "validation/paper",
)


def markdown(text: str) -> str:
    """Return reStructuredText as Markdown, as far as the pages use its constructs."""
    text = re.sub(r"^(=+)\n(.+)\n=+$", r"# \2", text, flags=re.M)
    text = re.sub(r"^(.+)\n={3,}$", r"# \1", text, flags=re.M)
    text = re.sub(r"^(.+)\n-{3,}$", r"## \1", text, flags=re.M)
    text = re.sub(r"\s*\(:doc:`[^`]+`\)", "", text)
    text = re.sub(r":doc:`/?([^`]+)`", r"the page *\1* of the site", text)
    text = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", text)
    text = re.sub(r"\n\.\. code-block:: python\n", "::\n", text)
    text = re.sub(
        r"\n?::\n\n((?: {4}.*\n|\n)+)",
        lambda block: "\n\n```\n" + re.sub(r"(?m)^ {4}", "", block[1]).strip() + "\n```\n\n",
        text + "\n",
    )
    return text.replace("``", "`").replace("```", "``").replace("``\n", "```\n").strip()


def cells(page: str) -> list[tuple[str, str]]:
    """Return kind and source of each cell of a page's notebook."""
    script = (ROOT / f"docs/gallery/{page}.py").read_text("utf-8")
    head, _, body = script.partition('"""')[2].partition('"""')
    made = [("markdown", markdown(head))]
    for block in re.split(r"^# %%.*\n", "\n" + body, flags=re.M):
        comment = re.match(r"(?:#.*\n)*", block)
        told = comment[0] if comment and block is not body else ""
        code = block[len(told) :].strip("\n")
        if told:
            made.append(("markdown", markdown(re.sub(r"(?m)^# ?", "", told))))
        if code:
            made.append(("code", code))
    return made


def notebook(page: str) -> Any:
    """Return the notebook of a page, without outputs."""
    import nbformat

    new = nbformat.v4.new_notebook()
    kinds = {"markdown": nbformat.v4.new_markdown_cell, "code": nbformat.v4.new_code_cell}
    for number, (kind, source) in enumerate(cells(page)):
        new.cells.append(kinds[kind](source, id=f"cell-{number}"))
    new.metadata["kernelspec"] = {
        "name": "python3",
        "language": "python",
        "display_name": "Python 3",
    }
    return new


def drawn(output: Any) -> bool:
    """Return whether an output only names an object of Matplotlib."""
    return bool(re.match(r"\[?<(matplotlib|Axes)", output.get("data", {}).get("text/plain", "")))


def kept(outputs: list[Any]) -> list[Any]:
    """Return outputs without names of Matplotlib's objects and without progress bars."""
    for each in outputs:
        if each.output_type == "stream" and each.name == "stderr":
            each.text = "".join(re.findall(r"\w+Warning: .*\n", each.text))
    return [each for each in outputs if each.get("text", "-") and not drawn(each)]


def look() -> list[str]:
    """Return the option of a kernel that gives figures and warnings the style of the site."""
    line = f"import sys; sys.path.append({str(ROOT / 'docs')!r}); from sitetools import settle"
    return [f"--IPKernelApp.exec_lines=[{line!r}, 'settle(); del settle, sys']"]


def main(names: list[str]) -> None:
    import nbclient
    import nbformat

    os.environ.pop("MPLBACKEND", None)  # figures go into the notebook
    for page in PAGES:
        name = page.rpartition("/")[2]
        if names and name not in names:
            continue
        made = notebook(page)
        with tempfile.TemporaryDirectory() as folder:
            nbclient.NotebookClient(
                made,
                timeout=600,
                kernel_name="python3",
                resources={"metadata": {"path": folder}},
                record_timing=False,
                extra_arguments=look(),
            ).execute()
        made.metadata.pop("language_info", None)
        for cell in made.cells:
            if cell.cell_type == "code":
                cell.outputs = kept(cell.outputs)
        nbformat.write(made, ROOT / f"notebooks/{name}.ipynb")
        print(f"notebooks/{name}.ipynb")


if __name__ == "__main__":
    main(sys.argv[1:])
