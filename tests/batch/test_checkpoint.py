"""A checkpoint keeps whole records, whatever happened to the process that wrote them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import aoimpact as ao
from aoimpact.batch.checkpoint import Checkpoint
from aoimpact.batch.fingerprint import DIGEST_SIZE


def key(i: int) -> bytes:
    return i.to_bytes(DIGEST_SIZE, "big")


def filled(path: Path, count: int) -> bytes:
    with Checkpoint(path) as store:
        for i in range(count):
            store.put(key(i), {"peak_force": float(i)})
    return path.read_bytes()


def test_gives_back_what_was_put(tmp_path: Path) -> None:
    path = tmp_path / "sweep"
    filled(path, 3)
    with Checkpoint(path) as store:
        assert len(store) == 3
        assert store.get(key(1)) == {"peak_force": 1.0}
        assert key(7) not in store
        store.put(key(7), ValueError("no"))
        assert str(store.get(key(7))) == "no"
        assert store.get(key(2)) == {"peak_force": 2.0}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return filled(tmp_path_factory.mktemp("whole") / "sweep", 4)


@given(left=st.integers(0, 400))
def test_cut_anywhere_it_loses_the_torn_record_alone(
    left: int, whole: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("torn") / "sweep"
    path.write_bytes(whole[:left])
    record = (len(whole) - 8) // 4
    finished = min(4, max(0, left - 8) // record)
    with Checkpoint(path) as store:
        assert [key(i) in store for i in range(4)] == [i < finished for i in range(4)]
        for i in range(4):
            store.put(key(i), {"peak_force": float(i)})
    with Checkpoint(path) as store:
        assert [store.get(key(i))["peak_force"] for i in range(4)] == [0.0, 1.0, 2.0, 3.0]


def test_damage_in_the_middle_is_said(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "sweep"
    middle = len(whole) // 2
    path.write_bytes(whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :])
    with pytest.warns(ao.AOImpactWarning, match="damaged after 1 cases"):
        store = Checkpoint(path)
    with store:
        assert len(store) == 1


def test_another_file_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "thesis.txt"
    path.write_text("years of work")
    with pytest.raises(ao.InputError, match="another kind"):
        Checkpoint(path)
    assert path.read_text() == "years of work"


def test_two_sweeps_do_not_share_one(tmp_path: Path) -> None:
    path = tmp_path / "sweep"
    with Checkpoint(path), pytest.raises(ao.InputError, match="in use by another sweep"):
        Checkpoint(path)
    with Checkpoint(path) as store:
        assert len(store) == 0


def test_another_process_is_kept_out(tmp_path: Path) -> None:
    path = tmp_path / "sweep"
    program = f"from aoimpact.batch.checkpoint import Checkpoint; Checkpoint({str(path)!r})"
    with Checkpoint(path):
        other = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=False
        )
    assert other.returncode != 0
    assert "InputError" in other.stderr


@pytest.mark.parametrize("path", ["no/such/folder/sweep", "."])
def test_a_path_that_cannot_be_written(path: str, tmp_path: Path) -> None:
    with pytest.raises(ao.InputError, match="cannot be opened"):
        Checkpoint(tmp_path / path)


def test_no_path_at_all() -> None:
    with pytest.raises(ao.InputTypeError, match="must be a path"):
        Checkpoint(3)  # type: ignore[arg-type]
