"""Many impacts: the same bits whoever computes them, and nothing finished is lost."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from impacts import beam_star, pair

import aoimpact as ao
from aoimpact.base import WorkerError

NAMES = ("peak_force", "peak_time", "contact_duration", "impulse", "rebound_velocity")


def balls(velocity: float, **changes: Any) -> dict[str, Any]:
    """Two rigid balls under Hertz's law."""
    return {
        "projectile": ao.rigid(mass=0.03),
        "target": ao.rigid(mass=0.05),
        "law": ao.Hertz(k=1e10),
        "velocity": velocity,
        "duration": 2e-4,
    } | changes


def mixed() -> list[dict[str, Any]]:
    """Stars of several kinds, both solvers, one contact and many."""
    beam = {"target": beam_star(6), "duration": 1e-3, "projectile": ao.rigid(mass=0.03)}
    return [
        *(balls(v) for v in (0.1, 1.0, -1.0, 3.0)),
        *(pair() | {"velocity": v} for v in (0.5, 1.0)),
        *(balls(v, **beam, solver=ao.Adaptive(rtol=1e-6)) for v in (0.5, 2.0)),
        balls(1.0, solver=ao.Newmark(dt=1e-6)),
        balls(1.0, gap=1e-5),
        balls(0.0),
    ]


def same(ours: list[Any], theirs: list[Any]) -> bool:
    """Equal to the last bit; exceptions by type and text."""

    def plain(item: Any) -> Any:
        if isinstance(item, dict):
            return {name: value.hex() for name, value in item.items()}
        return (type(item), str(item)) if isinstance(item, Exception) else item

    return [plain(item) for item in ours] == [plain(item) for item in theirs]


def peak(result: Any) -> float:
    return float(result.peak_force)


def test_kept_numbers_are_those_of_the_results() -> None:
    cases = [case for case in mixed() if case["velocity"] > 0.0]
    results = ao.simulate_many(cases)
    kept = ao.simulate_many(cases, keep=NAMES)
    assert same(kept, [{name: getattr(result, name) for name in NAMES} for result in results])
    assert ao.simulate_many(cases, keep=peak) == [result.peak_force for result in results]
    assert ao.simulate_many(cases, keep="error.energy") == [
        {"error.energy": result.error.energy} for result in results
    ]
    assert ao.simulate_many(cases[:1], keep="contacts.0.1") == [
        {"contacts.0.1": results[0].contacts[0][1]}
    ]


@pytest.mark.parametrize("workers", [2, 3, 7])
def test_the_same_bits_from_any_number_of_threads(workers: int) -> None:
    cases = 4 * mixed()
    assert same(ao.simulate_many(cases, keep=NAMES), ao.simulate_many(cases, workers, keep=NAMES))


def test_the_same_bits_from_any_executor() -> None:
    cases = 2 * mixed()
    alone = ao.simulate_many(cases, keep=NAMES)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as executor:
        assert same(ao.simulate_many(cases, executor, keep=NAMES), alone)
        whole = ao.simulate_many(cases[:2], executor)
        assert [result.peak_force for result in whole] == [item["peak_force"] for item in alone[:2]]
        assert np.array_equal(whole[0].at([1e-5]).force, ao.simulate(**cases[0]).at([1e-5]).force)
    with ThreadPoolExecutor(2) as executor:
        assert same(ao.simulate_many(cases, executor, keep=NAMES), alone)


def test_a_failed_case_is_its_own_exception() -> None:
    cases = [balls(1.0), balls(0.0), {"velocty": 1.0}, 3, balls(1.0, law=None), balls(2.0)]
    results = ao.simulate_many(cases, workers=2)
    assert [isinstance(result, ao.Result) for result in results] == [1, 0, 0, 0, 0, 1]
    assert "velocity is 0" in str(results[1])
    assert "did you mean 'velocity'" in str(results[2])
    assert isinstance(results[3], ao.InputTypeError)
    assert "law: it was left out" in str(results[4])
    assert all(result.__traceback__ is None for result in results[1:5])


def test_warnings_come_once_and_name_the_case() -> None:
    short = balls(1.0, duration=1e-5)
    with pytest.warns(ao.AOImpactWarning, match=r"^case") as seen:
        ao.simulate_many([balls(1.0), short, short], workers=2)
    assert len(seen) == 1
    assert "1 more of 3 cases" in str(seen[0].message)
    assert seen[0].filename == __file__


# ----------------------------------------------------------------------------------- streams


@pytest.mark.slow
@pytest.mark.parametrize("keep", ["peak_force", peak])
def test_bodies_of_past_cases_are_forgotten(keep: Any) -> None:
    """Cases of a generator are drawn as it goes; some 3 MB of 200 whole results are not held."""

    def held(count: int) -> int:
        cases = (balls(1.0, projectile=ao.rigid(mass=0.03)) for _ in range(count))
        assert len(ao.simulate_many(cases, keep=keep)) == count
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    held(20)  # with what is imported for it
    tracemalloc.start()
    assert held(200) < 50_000
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 1e6


# ------------------------------------------------------------------------------- checkpoints


def counted(path: Path) -> int:
    return path.read_bytes().count(b"\n") - 1


def test_a_second_run_computes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, every = tmp_path / "sweep", mixed()
    tried = ao.simulate_many(every, keep=NAMES, checkpoint=path)
    done = [not isinstance(one, Exception) for one in tried]  # a case that failed is tried again
    cases, first = list(compress(every, done)), list(compress(tried, done))
    assert counted(path) == len(cases) < len(every)

    def never(*example: Any, **case: Any) -> Any:
        if example:  # of what results have, by which names are checked
            return ao.simulate(*example, **case)
        raise AssertionError("computed again")

    monkeypatch.setattr("aoimpact.batch.many.simulate", never)
    for workers in (1, 2):
        assert same(ao.simulate_many(cases, workers, keep=NAMES, checkpoint=path), first)


def test_what_a_function_keeps_is_the_same_from_the_file(tmp_path: Path) -> None:
    def keep(result: ao.Result) -> Any:
        return {"force": result.force[:3], "t": (0.1, np.float32(0.1)), "none": None}

    first, second = (
        ao.simulate_many([balls(1.0)], keep=keep, checkpoint=tmp_path / "sweep", key="1")
        for _ in range(2)
    )
    assert first == second
    assert first[0]["force"] == ao.simulate(**balls(1.0)).force[:3].tolist()


def test_a_changed_sweep_computes_what_has_changed(tmp_path: Path) -> None:
    path = tmp_path / "sweep"
    ao.simulate_many([balls(1.0), balls(2.0)], keep="impulse", checkpoint=path)
    ao.simulate_many([balls(2.0), balls(3.0), balls(1.0)], keep="impulse", checkpoint=path)
    assert counted(path) == 3
    ao.simulate_many([balls(1.0)], keep="peak_force", checkpoint=path)
    assert counted(path) == 4


def test_functions_need_a_key_and_another_one_when_they_change(tmp_path: Path) -> None:
    def kept(keep: Any, key: str | None) -> float:
        found = ao.simulate_many([balls(1.0)], keep=keep, checkpoint=tmp_path / "sweep", key=key)
        return float(found[0])

    with pytest.raises(ao.InputTypeError, match="key="):
        kept(lambda hit: hit.peak_force, None)
    with pytest.raises(ao.InputTypeError, match="key"):
        kept(peak, 3)  # type: ignore[arg-type]
    before = kept(lambda hit: hit.peak_force, "1")
    assert kept(lambda hit: -hit.peak_force, "1") == before
    assert kept(lambda hit: -hit.peak_force, "2") == -before < 0.0


def test_errors_that_may_pass_are_tried_again(tmp_path: Path) -> None:
    path = tmp_path / "sweep"
    lack = iter([MemoryError("just now"), None])

    class Scene:
        def simulate(self, *, duration: float) -> ao.Result:
            if error := next(lack):
                raise error
            return ao.simulate(**balls(1.0))

    (first,) = ao.simulate_many([(Scene(), 1.0)], keep="impulse", checkpoint=path)
    assert isinstance(first, MemoryError)
    (second,) = ao.simulate_many([(Scene(), 1.0)], keep="impulse", checkpoint=path)
    assert second["impulse"] > 0.0


def die(result: Any) -> float:
    """Kill the worker that comes to a certain case."""
    if result.velocity == 7.0 and multiprocessing.parent_process():  # not what runs the tests
        os.kill(os.getpid(), signal.SIGKILL)
    return float(result.peak_force)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kill -9")
def test_a_lost_worker_is_said_and_what_is_finished_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "sweep"
    context = multiprocessing.get_context("spawn")
    cases = [balls(float(v)) for v in range(1, 11)]
    with (
        ProcessPoolExecutor(1, mp_context=context) as executor,
        pytest.raises(WorkerError, match=r"^workers"),
    ):
        ao.simulate_many(cases, executor, keep=die, checkpoint=path, key="1")
    # The cases of the batch that died with its worker are the only ones to be done again.
    assert 0 < counted(path) < 7


# --------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize("name", ["contacts", "error", "error.tme"])
def test_a_name_of_no_number_is_refused_before_the_first_case(name: str) -> None:
    def cases() -> Any:
        raise AssertionError("a case was drawn")
        yield

    with pytest.raises(ao.AOImpactError, match=f"keep: '{name}'"):
        ao.simulate_many(cases(), keep=("peak_force", name))


@pytest.mark.parametrize("name", ["contacts.5.0", "contacts.0.peak_force"])
def test_a_name_that_leads_nowhere_fails_its_case(name: str) -> None:
    (error,) = ao.simulate_many([balls(1.0)], keep=name)
    assert isinstance(error, ao.AOImpactError)
    assert name in str(error)


def test_a_checkpoint_takes_what_json_holds(tmp_path: Path) -> None:
    (error,) = ao.simulate_many(
        [balls(1.0)], keep=lambda hit: hit.plan, checkpoint=tmp_path / "a", key="1"
    )
    assert isinstance(error, ao.InputTypeError)
    assert "must return what JSON holds" in str(error)


def test_what_cannot_be_sent_is_said() -> None:
    with (
        ProcessPoolExecutor(1) as executor,
        pytest.raises(WorkerError, match=r"^workers"),
    ):
        ao.simulate_many([balls(1.0)], executor, keep=lambda result: result.impulse)
