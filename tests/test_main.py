"""The command line: help, exit codes, and no traceback for what a user gets wrong."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import aoimpact as ao
from aoimpact import paper
from aoimpact.__main__ import main
from aoimpact.paper_table import Row, Table


def test_help_names_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["--help"])
    assert stop.value.code == 0
    assert "paper" in capsys.readouterr().out


def test_help_of_paper_says_where_files_go(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["paper", "--help"])
    assert stop.value.code == 0
    text = capsys.readouterr().out
    assert "--out DIR" in text
    assert "default: paper-results" in text


def test_version_is_the_package_s(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--version"])
    assert capsys.readouterr().out.split()[-1] == ao.__version__


@pytest.mark.parametrize("arguments", [[], ["papr"], ["paper", "--outt", "x"], ["paper", "x"]])
def test_wrong_usage_ends_with_two(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert "usage:" in capsys.readouterr().err


def test_folder_that_is_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "taken"
    file.write_text("mine")
    for out in (file, file / "below"):
        assert main(["paper", "--out", str(out)]) == 2
        message = capsys.readouterr().err
        assert str(out) in message
        assert "give another one" in message
    assert file.read_text() == "mine"


def test_run_as_a_module_has_no_traceback(tmp_path: Path) -> None:
    file = tmp_path / "taken"
    file.touch()
    command = [sys.executable, "-m", "aoimpact", "paper", "--out", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("aoimpact: error: cannot write")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ao.InputError("no such thing"), 2),
        (ao.ConvergenceError("it grew"), 1),
        (OSError("disk full"), 1),
        (KeyboardInterrupt(), 130),
    ],
)
def test_failures_have_codes_and_one_line(
    error: BaseException,
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail(_: object) -> None:
        raise error

    monkeypatch.setattr(paper, "reproduce", fail)
    assert main(["paper"]) == code
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert str(error) in lines[0]


def test_prints_the_tables_and_the_files(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    table = Table("Table 1", (Row("mass", 32.67, "32.7", "g"),))

    def done(out: Any) -> paper.Reproduction:
        return paper.Reproduction((table,), (Path(out) / "results.csv",))

    monkeypatch.setattr(paper, "reproduce", done)
    assert main(["paper", "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    for part in ("Table 1", "32.7 g", "32.67 g", "agrees", str(tmp_path), "results.csv"):
        assert part in text
