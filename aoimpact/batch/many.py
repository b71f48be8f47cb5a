"""Many impacts: run by several workers, returned in order, and resumed from a checkpoint."""

from __future__ import annotations

import inspect
import math
import os
import pickle
import re
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence, Sized
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from typing import Any, NamedTuple

from .. import __version__
from ..accuracy import Keep, Named, keeper, shared_models
from ..base import (
    FilePath,
    InputError,
    InputTypeError,
    WorkerError,
    bar,
    boolean,
    held_warnings,
    integer,
    nearest,
    text,
    warn,
)
from ..contact import ContactPoint
from ..impact import simulate
from ..laws import Linear
from ..reduction import rigid
from ..results import QUANTITIES, look_up
from .checkpoint import Checkpoint, Digests, Outcome, as_json
from .plain import PLAIN_NUMBERS, plain_numbers

# Intended duration of one task, s, in this process's threads (_TASK_HERE) and in other executors
# (_TASK_AWAY): far above the time to submit a task, and short enough for all workers to finish at
# almost the same time.
_TASK_HERE, _TASK_AWAY = 0.015, 0.1

# Number of submitted tasks per worker: one is running and one is waiting.
_AHEAD = 2

# Maximum number of threads, more than any machine runs at once.
_MOST_THREADS = 4096


def simulate_many(
    cases: Iterable[Any],
    workers: Any = 1,
    *,
    keep: Any = None,
    checkpoint: FilePath | None = None,
    key: str | None = None,
    progress: bool = True,
) -> list[Any]:
    """Simulate many cases; a failed case gives its exception and does not stop the other cases.

    Parameters
    ----------
    cases : iterable
        Dicts of `simulate`'s keywords, or pairs (scene, duration) or (scene, dict of keywords of
        its ``simulate``). Impacts on one contact point share its models if their contacts have
        similar durations and widths; errors are estimated for each impact. Without `quantity` and
        `rtol`, models are chosen for the peak force.
    workers : int or executor, optional
        Threads (the core runs without Python's lock), or anything with ``.submit``: executors of
        concurrent.futures and mpi4py.futures, a dask.distributed Client. The results are the same
        to the last bit for all workers.
    keep : names or function, optional
        Numbers to keep of each case instead of its result, which holds whole histories. With names,
        such as ("peak_force", "impulse", "error.time"), a dict of these numbers is kept, in scenes
        for each contact or body. If models are chosen, the dict also has the error of each number,
        such as "impulse_error" (`ErrorParts.total`), and "impulse_controlled". A function is called
        with the result; other processes must be able to import it. If only named numbers are kept,
        one call of the core runs many impacts of two AO models.
    checkpoint : path, optional
        A file that stores finished cases, one line of JSON each. The same call then resumes where
        an earlier call was stopped or killed. Cases are recognised by their content; changed and
        failed cases are computed again. A checkpoint needs `keep`. Arrays that a function returns
        become lists.
    key : str, optional
        Text that represents the code of functions in a case or `keep` in the checkpoint: change the
        text whenever you change a function. Without a key, a checkpoint refuses functions.
    progress : bool, optional
        True to show a progress bar on a terminal when it takes longer than a second.

    Returns
    -------
    list
        For each case, in order: its result, the numbers kept of the result, or its exception.

    Raises
    ------
    InputError, InputTypeError
        If there are no cases, or an argument other than a case is invalid.
    WorkerError
        If a worker is lost, or cases cannot be sent to it.

    Warns
    -----
    AOImpactWarning
        One warning at the end, if cases had warnings.

    Examples
    --------
    >>> ball = ao.rigid(mass=0.1)
    >>> case = {"projectile": ball, "target": ball, "law": ao.Hertz(k=1e9), "duration": 1e-3}
    >>> hits = ao.simulate_many([case | {"velocity": speed} for speed in (0.5, 1.0)])
    >>> round((hits[1].peak_force / hits[0].peak_force) ** (5 / 6), 6)  # Hertz: as V^(6/5)
    2.0
    """
    try:
        if isinstance(cases, (Mapping, str)) or not isinstance(cases, Iterable):
            raise TypeError
        # An array without axes, or a sparse array, has a __len__ that raises TypeError.
        total = len(cases) if isinstance(cases, Sized) else None
    except TypeError:
        raise InputTypeError(
            "cases must be a list (or generator) of dicts of simulate's keywords, or of pairs "
            f"(scene, duration), got {type(cases).__name__}"
        ) from None
    values = list(run_cases(cases, total, workers, keep, checkpoint, key, progress))
    if not values:
        raise InputError("cases is empty: there is nothing to simulate")
    return values


def run_cases(
    cases: Iterable[Any],
    total: int | None,
    workers: Any,
    keep: Any,
    checkpoint: FilePath | None,
    key: str | None,
    progress: bool,
) -> Iterator[Any]:
    """Check the arguments of `simulate_many`, and yield the kept value or error of each case.

    Parameters
    ----------
    cases : iterable
        As in `simulate_many`, or an exception in place of a case that could not be made.
    total : int or None
        Number of cases; None if it is not known.
    """
    boolean("progress", progress)
    if key is not None:
        text("key", key)
    job = _Job(keeper(keep), checkpoint is not None)
    if job.stored and job.keep is None:
        raise InputError(
            "checkpoint keeps no whole results; name numbers, such as keep='peak_force'"
        )
    if isinstance(job.keep, Named):  # refuse names that no result has
        mass = rigid(mass=1.0)
        hit = simulate(mass, mass, 1.0, law=Linear(k=1.0), duration=5.0)
        for name in job.keep.names:
            there = hasattr(hit, name.partition(".")[0])  # else a name in a scene, not checked
            if there and name not in QUANTITIES and not re.search(r"\.\d", name):
                look_up(hit, name, "keep")
    if not callable(getattr(workers, "submit", None)):
        workers = min(integer("workers", workers, low=1), _MOST_THREADS)
    done, warned, first = 0, 0, ""
    with (
        nullcontext() if checkpoint is None else Checkpoint(checkpoint) as store,
        bar("cases", total, unit="case", wanted=progress) as shown,
    ):
        for item, outcome in _run_tasks(workers, job, _items(cases, job.keep, store, key)):
            if item.known and store is not None:
                outcome = store.get(item.digest)
            elif store is not None and item.digest:
                store.put(item.digest, outcome)
            value, messages = outcome
            if messages:
                first = first or f"case {done}: {messages[0]}"
                warned += 1
            done += 1
            shown.update()
            yield value
    if warned:
        warn(first + (f" ({warned - 1} more of {done} cases warn)" if warned > 1 else ""))


class _Item(NamedTuple):
    """A case, its digest for the checkpoint, and whether the checkpoint already has its outcome."""

    case: Any
    digest: str = ""
    known: bool = False


def _items(
    cases: Iterable[Any], keep: Keep | None, store: Checkpoint | None, key: str | None
) -> Iterator[_Item]:
    digests = Digests(key, None if store is None else (__version__, keep))
    for i, case in enumerate(cases):
        if store is None or isinstance(case, Exception):
            yield _Item(case)
        else:
            digest = digests.of(case, f"case {i}")
            known = digest in store
            yield _Item(None if known else case, digest, known)


@dataclass(frozen=True)
class _Job:
    """Function that runs cases and returns the kept numbers, or an exception for a failed case.

    `stored`: whether a checkpoint stores the numbers, which JSON must then be able to hold.
    """

    keep: Keep | None
    stored: bool = False

    def __call__(self, items: Sequence[_Item]) -> tuple[list[Outcome | None], float]:
        """Return the outcomes (None for cases with known outcome), and the time taken, s."""
        start = time.perf_counter()
        together: Sequence[Any] = [None] * len(items)
        if isinstance(self.keep, Named) and PLAIN_NUMBERS.issuperset(self.keep.names):
            # One call of the core runs all plain impacts.
            together = plain_numbers([item.case for item in items], self.keep.names)
        outcomes: list[Outcome | None] = []
        for item, found in zip(items, together, strict=True):
            if found is not None:
                outcomes.append((found, ()))
            else:
                outcomes.append(None if item.known else self._alone(item.case))
        return outcomes, time.perf_counter() - start

    def _alone(self, case: Any) -> Outcome:
        with held_warnings() as messages, shared_models():
            try:
                result = _run(case)
                value = result if self.keep is None else self.keep(result)
                value = as_json(value) if self.stored else value
            except Exception as error:
                value = _portable(error)
        return value, tuple(messages)


_signature = lru_cache(1)(inspect.signature)


def check_keywords(where: str, function: Callable[..., Any], names: Collection[str]) -> None:
    """Refuse a name that is no keyword of `function`, and a missing keyword without default."""
    known = _signature(function).parameters
    for name in names:
        if name not in known:
            meant = nearest(str(name), known)
            raise InputTypeError(f"{where}: {function.__name__} has no keyword {name!r}{meant}")
    for name, parameter in known.items():
        if parameter.default is parameter.empty and name not in names:
            raise InputTypeError(f"{where}: {function.__name__} needs {name}")


def _run(case: Any) -> Any:
    if isinstance(case, Exception):  # the case could not be made
        raise case
    if isinstance(case, Mapping):
        points = any(isinstance(of, ContactPoint) for of in case.values())
        if points and case.get("rtol") is None and case.get("quantity") is None:
            case = {**case, "quantity": "peak_force"}  # a whole history needs larger models
        check_keywords("case", simulate, case)
        return simulate(**case)
    if isinstance(case, (tuple, list)) and len(case) == 2 and hasattr(case[0], "simulate"):
        scene, how = case
        return scene.simulate(**(how if isinstance(how, Mapping) else {"duration": how}))
    raise InputTypeError(
        f"case must be a dict of simulate's keywords or a pair (scene, duration), got {case!r}"
    )


def _portable(error: Exception) -> Exception:
    """Return an exception that can be pickled, without its traceback, which would hold arrays."""
    error.__traceback__ = error.__context__ = error.__cause__ = None
    try:
        pickle.loads(pickle.dumps(error))
    except Exception as reason:
        return RuntimeError(f"{type(error).__name__}: {error} (which cannot be pickled: {reason})")
    return error


def _run_tasks(workers: Any, task: _Job, items: Iterable[_Item]) -> Iterator[tuple[Any, Any]]:
    """Yield each item and its outcome, in order; `items` is read only a few tasks ahead.

    Parameters
    ----------
    workers : int or executor
        Number of threads, or an object with ``submit`` as in `concurrent.futures.Executor`: a
        dask.distributed Client, an executor of mpi4py.futures.

    Raises
    ------
    WorkerError
        If a worker is lost, or items cannot be sent to it.
    """
    source, size, target = iter(items), 1, _TASK_HERE if isinstance(workers, int) else _TASK_AWAY
    under_way: deque[tuple[list[Any], Any]] = deque()
    with ExitStack() as stack:
        if workers == 1:
            submit, most = None, 1
        elif isinstance(workers, int):
            threads = ThreadPoolExecutor(workers, thread_name_prefix="aoimpact")
            stack.callback(threads.shutdown, wait=False)  # an interrupt must not wait
            submit, most = threads.submit, _AHEAD * workers
        else:
            submit, most = workers.submit, _AHEAD * _width(workers)
        stack.callback(lambda: [future.cancel() for _, future in under_way])
        while True:
            while len(under_way) < most and (batch := list(islice(source, size))):
                under_way.append((batch, submit and _asked(workers, submit, task, batch)))
            if not under_way:
                return
            batch, future = under_way.popleft()
            outcomes, seconds = _asked(workers, future.result) if submit else task(batch)
            # The next batch has the number of items that take the intended time, but at most four
            # times the number of items in this batch.
            wanted = target * len(batch) / seconds if seconds > 0.0 else math.inf
            size = int(max(1.0, min(wanted, 4.0 * len(batch))))
            yield from zip(batch, outcomes, strict=True)


def _asked(workers: Any, ask: Callable[..., Any], *arguments: Any) -> Any:
    """Call an executor; an exception means that the executor failed, since tasks raise none."""
    try:
        return ask(*arguments)
    except Exception as error:
        if isinstance(workers, int):
            raise
        raise WorkerError(
            f"workers: {type(error).__name__}: {error}. A worker was lost, or a case, a law or "
            "keep could not be sent to it: they must be picklable, functions defined in a module"
        ) from error


def _width(executor: Any) -> int:
    """Return the number of workers of an executor; the number of cores if it is not known."""
    for name in ("num_workers", "_max_workers"):
        if isinstance(number := getattr(executor, name, None), int) and number > 0:
            return number
    if hasattr(executor, "nthreads"):  # dask: number of threads by worker
        return max(1, int(sum(executor.nthreads().values())))
    return os.cpu_count() or 1
