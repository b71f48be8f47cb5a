"""Many impacts: on all cores, in order, as a stream, and resumed from a checkpoint."""

from __future__ import annotations

import inspect
import os
import pickle
import re
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence, Sized
from contextlib import nullcontext
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, NamedTuple

from ..accuracy import Keep, Named, keeper, shared_models
from ..base import (
    InputError,
    InputTypeError,
    bar,
    boolean,
    held_warnings,
    nearest,
    text,
    warn,
)
from ..contact import ContactPoint
from ..impact import simulate
from ..laws import Linear
from ..reduction import rigid
from ..results import look_up
from .checkpoint import Checkpoint, Outcome, as_json
from .digest import Digests
from .plain import PLAIN_NUMBERS, plain_numbers
from .workers import checked_workers, run_tasks


def simulate_many(
    cases: Iterable[Any],
    workers: Any = 1,
    *,
    keep: Any = None,
    checkpoint: str | os.PathLike[str] | None = None,
    key: str | None = None,
    progress: bool = True,
) -> list[Any]:
    """Simulate many cases; one that fails gives its exception and does not stop the others.

    Parameters
    ----------
    cases : iterable
        Dicts of `simulate`'s keywords, or pairs (scene, duration). Impacts on one contact point
        share its models where their contacts last about as long and are about as wide; each has
        its own error. Without `quantity` and `rtol` models are chosen for the peak force.
    workers : int or executor, optional
        Threads (the core runs without Python's lock), or anything with ``.submit``: executors of
        concurrent.futures and mpi4py.futures, a dask.distributed Client. The results are the same
        to the last bit whoever computes them.
    keep : names or function, optional
        Numbers to keep of each case instead of its result, which holds whole histories: names of
        numbers, such as ("peak_force", "impulse", "error.time"), for a dict of these, each with
        its error, such as "impulse_error" (`ErrorParts.total`), and "impulse_controlled",
        where models are chosen; or a function of the result, which other processes must be able
        to import. Impacts of two AO models of which only named numbers are kept run many in one
        call of the core.
    checkpoint : path, optional
        A file that keeps finished cases, a line of JSON each: the same call resumes where an
        earlier one was stopped or killed. Cases are recognised by their content; one that has
        changed is computed again. It needs `keep`; arrays that a function keeps become lists.
    key : str, optional
        Stands for the code of the functions that a case or `keep` has, for the checkpoint: change
        it with them. Without one, a checkpoint refuses functions.
    progress : bool, optional
        True to show a progress bar on a terminal when it takes longer than a second.

    Returns
    -------
    list
        In the order of the cases: results, or what was kept of them, or exceptions.

    Raises
    ------
    InputError, InputTypeError
        If there are no cases, or an argument other than a case makes no sense.
    WorkerError
        If a worker is lost, or cannot be given its cases.

    Warns
    -----
    AOImpactWarning
        Once, at the end, if cases had warnings.

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
        # An array without axes, or a sparse one, has __len__ all the same, which raises TypeError.
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
    checkpoint: str | os.PathLike[str] | None,
    key: str | None,
    progress: bool,
) -> Iterator[Any]:
    """Check the other arguments of `simulate_many`, and yield what comes of each case.

    Parameters
    ----------
    cases : iterable
        As of `simulate_many`; an exception stands for a case that could not be made.
    total : int or None
        Number of the cases, where it is known.
    """
    boolean("progress", progress)
    if key is not None:
        text("key", key)
    job = _Job(keeper(keep), checkpoint is not None)
    if job.stored and job.keep is None:
        raise InputError(
            "checkpoint keeps no whole results; name numbers, such as keep='peak_force'"
        )
    if isinstance(job.keep, Named):  # a name that is no number of a result
        mass = rigid(mass=1.0)
        hit = simulate(mass, mass, 1.0, law=Linear(k=1.0), duration=5.0)
        for name in job.keep.names:
            if not re.search(r"\.\d", name):  # of a body or contact, which the cases have
                look_up(hit, name, "keep")
    threads = checked_workers(workers)
    done, warned, first = 0, 0, ""
    with (
        nullcontext() if checkpoint is None else Checkpoint(checkpoint) as store,
        bar("cases", total, unit="case", wanted=progress) as shown,
    ):
        for item, outcome in run_tasks(threads, job, _items(cases, job.keep, store, key)):
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
    """A case, its digest in the checkpoint, and whether the checkpoint has it already."""

    case: Any
    digest: str = ""
    known: bool = False


def _items(
    cases: Iterable[Any], keep: Keep | None, store: Checkpoint | None, key: str | None
) -> Iterator[_Item]:
    ours = "" if store is None else version("aoimpact")  # slow to read
    digests = Digests(key)
    for i, case in enumerate(cases):
        if store is None or isinstance(case, Exception):
            yield _Item(case)
        else:
            digest = digests.of((ours, keep, case), f"case {i}")
            known = digest in store
            yield _Item(None if known else case, digest, known)


@dataclass(frozen=True)
class _Job:
    """Runs cases and keeps what is wanted of them; returns exceptions instead of raising.

    stored: whether a checkpoint keeps it, so that it has to be such as JSON holds.
    """

    keep: Keep | None
    stored: bool = False

    def __call__(self, items: Sequence[_Item]) -> tuple[list[Outcome | None], float]:
        """The outcomes, None for those that are known, and the seconds that they took."""
        start = time.perf_counter()
        outcomes = self._together([item.case for item in items])
        for i, item in enumerate(items):
            if outcomes[i] is None and not item.known:
                outcomes[i] = self._alone(item.case)
        return outcomes, time.perf_counter() - start

    def _together(self, cases: Sequence[Any]) -> list[Outcome | None]:
        """The outcomes of the plain impacts, from one call of the core; None for the others."""
        if not isinstance(self.keep, Named) or not PLAIN_NUMBERS.issuperset(self.keep.names):
            return [None] * len(cases)
        return [None if of is None else (of, ()) for of in plain_numbers(cases, self.keep.names)]

    def _alone(self, case: Any) -> Outcome:
        with held_warnings() as messages, shared_models():
            try:
                result = _run(case)
                value = result if self.keep is None else self.keep(result)
                value = as_json(value) if self.stored else value
            except Exception as error:
                value = _portable(error)
        return value, tuple(messages)


def check_keywords(where: str, function: Callable[..., Any], names: Collection[str]) -> None:
    """Refuse keywords that a function does not have, and the lack of those that it needs."""
    known = inspect.signature(function).parameters
    for name in names:
        if name not in known:
            meant = nearest(str(name), known)
            raise InputTypeError(f"{where}: {function.__name__} has no keyword {name!r}{meant}")
    for name, parameter in known.items():
        if parameter.default is parameter.empty and name not in names:
            raise InputTypeError(f"{where}: {function.__name__} needs {name}")


def _run(case: Any) -> Any:
    if isinstance(case, Exception):  # it could not be made
        raise case
    if isinstance(case, Mapping):
        points = any(isinstance(of, ContactPoint) for of in case.values())
        if points and case.get("rtol") is None and case.get("quantity") is None:
            case = {**case, "quantity": "peak_force"}  # all of the force takes larger models
        try:
            return simulate(**case)
        except TypeError:
            check_keywords("case", simulate, case)
            raise
    if isinstance(case, (tuple, list)) and len(case) == 2 and hasattr(case[0], "simulate"):
        scene, duration = case
        return scene.simulate(duration=duration)
    raise InputTypeError(
        f"case must be a dict of simulate's keywords or a pair (scene, duration), got {case!r}"
    )


def _portable(error: Exception) -> Exception:
    """An exception that can be pickled, without its traceback, which would keep arrays alive."""
    error.__traceback__ = error.__context__ = error.__cause__ = None
    try:
        pickle.loads(pickle.dumps(error))
    except Exception as reason:
        return RuntimeError(f"{type(error).__name__}: {error} (which cannot be pickled: {reason})")
    return error
