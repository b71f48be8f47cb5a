"""A checkpoint keeps whole lines, whatever happened to the process that wrote them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import aoimpact as ao
from aoimpact.batch import Checkpoint


def key(i: int) -> str:
    return f"{i:032x}"


def filled(path: Path, count: int) -> bytes:
    with Checkpoint(path) as store:
        for i in range(count):
            store.put(key(i), ({"peak_force": float(i)}, ()))
    return path.read_bytes()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return filled(tmp_path_factory.mktemp("whole") / "sweep", 4)


@given(left=st.integers(0, 400))
def test_cut_anywhere_it_loses_the_torn_line_alone(
    left: int, whole: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("torn") / "sweep"
    path.write_bytes(whole[:left])
    finished = max(0, whole[:left].count(b"\n") - 1)
    with Checkpoint(path) as store:
        assert [key(i) in store for i in range(4)] == [i < finished for i in range(4)]
        for i in range(finished, 4):
            store.put(key(i), ({"peak_force": float(i)}, ()))
    assert path.read_bytes() == whole


@pytest.mark.parametrize(
    "line",
    [
        b"{",
        b"[]",
        b"\xff\xfe",
        b'{"case": "1"}',
        b'{"case": [], "warnings": [], "value": 1}',
        b'{"case": "1", "warnings": 3, "value": 1}',
        b'{"case": "1", "warnings": []}',
        b"[" * 100_000,
    ],
)
def test_damage_in_the_middle_is_said(line: bytes, whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "sweep"
    head, *lines = whole.splitlines(keepends=True)
    path.write_bytes(head + lines[0] + line + b"\n" + lines[2])
    with pytest.warns(ao.AOImpactWarning, match=r"^checkpoint"):
        store = Checkpoint(path)
    with store:
        assert [key(i) in store for i in range(4)] == [True, False, True, False]


@pytest.mark.parametrize("content", ["years of work", "AOICKPT1", '{"case": 1}\n'])
def test_another_file_is_left_alone(content: str, tmp_path: Path) -> None:
    path = tmp_path / "thesis.txt"
    path.write_text(content)
    with pytest.raises(ao.InputError, match=r"^checkpoint"):
        Checkpoint(path)
    assert path.read_text() == content


def test_two_sweeps_may_share_one(tmp_path: Path) -> None:
    path = tmp_path / "sweep"
    with Checkpoint(path) as one, Checkpoint(path) as other:
        for i in range(4):
            (one, other)[i % 2].put(key(i), (float(i), ()))
    with Checkpoint(path) as store:
        assert [store.get(key(i))[0] for i in range(4)] == [0.0, 1.0, 2.0, 3.0]
    assert all(json.loads(line) for line in path.read_text().splitlines())
