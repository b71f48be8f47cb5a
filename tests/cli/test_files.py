"""What ``aoimpact run --out`` writes: every format, of an impact, of a scene and of a sweep."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import aoimpact as ao
from aoimpact.cli import main
from aoimpact.cli.files import FORMATS, write_files

from scenes import BAR, ROW

# A model for the force; its bar rings on.
pytestmark = pytest.mark.filterwarnings("ignore:velocity of bar:aoimpact.AOImpactWarning")

Alone = dict[Any, tuple[Path, list[Path]]]


@pytest.fixture(scope="module", params=[BAR, ROW], ids=["impact", "scene"])
def done(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A scene file and its result."""
    path = tmp_path_factory.mktemp("scene") / "scene.toml"
    path.write_text(request.param, encoding="utf-8")
    scene = ao.read_scene(path)
    return scene, scene.simulate()


@pytest.fixture(scope="module")
def alone(done: Any, tmp_path_factory: pytest.TempPathFactory) -> Alone:
    """Of each format, a folder of its own and the files that it says it wrote there."""
    folders = {write: tmp_path_factory.mktemp("alone") for write in FORMATS}
    return {write: (folder, list(write(*done, folder))) for write, folder in folders.items()}


@pytest.mark.parametrize("write", FORMATS)
def test_every_format_says_what_it_wrote(write: Any, alone: Alone) -> None:
    folder, files = alone[write]
    assert len(set(files)) == len(files)
    assert all(file.parent == folder and file.stat().st_size > 0 for file in files)
    beside = {file.stem for file in files}  # a .pvd names its .vtu files
    assert all(any(file.stem.startswith(stem) for stem in beside) for file in folder.iterdir())


def test_all_formats_are_written_and_none_over_another(
    done: Any, alone: Alone, tmp_path: Path
) -> None:
    files = write_files(*done, tmp_path / "new")
    assert len(set(files)) == len(files)
    assert [file.name for file in files] == [
        file.name for _, each in alone.values() for file in each
    ]


def test_the_help_and_the_page_name_every_format(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    text = capsys.readouterr().out
    page = Path(__file__).parents[2].joinpath("docs", "scene-files.md").read_text(encoding="utf-8")
    beginning = page.partition("A small file:")[0].upper()
    for write in FORMATS:
        for word in re.findall(r"\b[A-Z]{3,}\b", str(write.__doc__)):
            assert word in text, f"the help of --out in cli/main.py does not name {word}"
            assert word in beginning, f"docs/scene-files.md does not name {word}"
