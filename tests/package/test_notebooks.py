"""The notebooks are pages of the site, stored with their outputs, and run from top to bottom."""

from __future__ import annotations

import importlib.util
import json
import os
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))


def maker() -> Any:
    spec = importlib.util.spec_from_file_location("maker", ROOT / "tools/make_notebooks.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_page_that_is_to_be_one_is_a_notebook() -> None:
    assert {path.stem for path in NOTEBOOKS} == {page.split("/")[1] for page in maker().PAGES}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_its_page_with_outputs(path: Path) -> None:
    """Made anew by tools/make_notebooks.py where a page changes."""
    (page,) = (page for page in maker().PAGES if page.split("/")[1] == path.stem)
    stored = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert [(cell["cell_type"], "".join(cell["source"])) for cell in stored] == maker().cells(page)
    outputs = [cell["outputs"] for cell in stored if cell["cell_type"] == "code"]
    assert sum(map(bool, outputs)) > len(outputs) // 2
    assert not any(output["output_type"] == "error" for some in outputs for output in some)
    shown = json.dumps([output for some in outputs for output in some], ensure_ascii=False)
    assert not re.search(r"/tmp/|Path\(|<Axes|\[Text\(", shown)  # of the machine, and of no use


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reason = "what runs notebooks is missing: pip install aoimpact[notebook]"
    nbformat = pytest.importorskip("nbformat", reason=reason)
    nbclient = pytest.importorskip("nbclient", reason=reason)
    pytest.importorskip("ipykernel", reason=reason)
    if path.stem == "first_impact":
        pytest.importorskip("gmsh", reason=reason)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", os.environ.get("OPENBLAS_NUM_THREADS", "1"))
    notebook = nbformat.read(path, as_version=4)
    # A failing cell raises, with its traceback.
    client = nbclient.NotebookClient(
        notebook,
        timeout=600,
        kernel_name="python3",
        resources={"metadata": {"path": str(tmp_path)}},
    )
    client.execute()
    assert not list(tmp_path.iterdir())  # nothing is left behind
