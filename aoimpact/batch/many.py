"""Many impacts: on all cores, in order, as a stream, and resumed from a checkpoint."""

from __future__ import annotations

import inspect
import os
import pickle
import re
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence, Sized
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, NamedTuple

from ..accuracy import Keep, Named, keeper
from ..base import (
    AOImpactError,
    InputError,
    InputTypeError,
    bar,
    boolean,
    held_warnings,
    nearest,
    spelled,
    text,
    warn,
)
from ..impact import simulate
from ..laws import Linear
from ..reduction import rigid
from ..results import look_up
from .checkpoint import Checkpoint, Outcome, as_json
from .digest import Digests
from .plain import PLAIN_NUMBERS, plain_numbers
from .shared import SharedCase, share_models
from .sharednumbers import shared_numbers
from .workers import checked_workers, run_tasks

_PARAMETERS = inspect.signature(simulate).parameters
KEYWORDS = tuple(_PARAMETERS)
REQUIRED = tuple(name for name in KEYWORDS if _PARAMETERS[name].default is inspect.Parameter.empty)


@spelled
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
        Dicts of `simulate`'s keywords, or pairs (scene, duration). Impacts in a list that name the
        same contact point share a model of it, which is chosen for the hardest of them; each has
        its own error. Those from a generator, which are not known in advance, share none.
    workers : int or executor, optional
        Threads (the core runs without Python's lock), or anything with ``.submit``: executors of
        concurrent.futures and mpi4py.futures, a dask.distributed Client. The results are the same
        to the last bit whoever computes them.
    keep : names or function, optional
        Numbers to keep of each case instead of its result, which holds whole histories: names of
        numbers, such as ("peak_force", "impulse", "error.time"), for a dict of these, each with
        its error, such as "impulse_error" (`ErrorParts.total`), and "impulse_controlled",
        where models are chosen; or a function of the result, which other processes must be able
        to import. Impacts of two AO models, or that share one, of which only named numbers are kept
        run many in one call of the core.
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
    return list(
        iterated(cases, workers, keep=keep, checkpoint=checkpoint, key=key, progress=progress)
    )


def iterated(
    cases: Iterable[Any],
    workers: Any,
    *,
    keep: Any,
    checkpoint: str | os.PathLike[str] | None,
    key: str | None,
    progress: bool,
) -> Iterator[Any]:
    """Check the arguments of `simulate_many`, and return what comes of each case, one by one."""
    try:
        if isinstance(cases, (Mapping, str)) or not isinstance(cases, Iterable):
            raise TypeError
        # An array without axes, or a sparse one, has __len__ all the same, which raises TypeError.
        empty = isinstance(cases, Sized) and len(cases) == 0
    except TypeError:
        raise InputTypeError(
            "cases must be a list (or generator) of dicts of simulate's keywords, or of pairs "
            f"(scene, duration), got {type(cases).__name__}"
        ) from None
    if empty:
        raise InputError(_EMPTY)
    boolean("progress", progress)
    if key is not None:
        text("key", key)
    job = _Job(_checked(keeper(keep)), checkpoint is not None)
    if job.stored and job.keep is None:
        raise InputError(
            "checkpoint keeps no whole results; name numbers, such as keep='peak_force'"
        )
    return _iterate(cases, checked_workers(workers), job, checkpoint, key, progress)


def _checked(keep: Keep | None) -> Keep | None:
    """Refuse a name that is no number of a result before any case is computed."""
    if isinstance(keep, Named):
        mass = rigid(mass=1.0)
        hit = simulate(mass, mass, 1.0, law=Linear(k=1.0), duration=5.0)
        for name in keep.names:
            if not re.search(r"\.\d", name):  # of a body or contact, which the cases have
                look_up(hit, name, "keep")
    return keep


def _iterate(
    cases: Iterable[Any],
    workers: Any,
    job: _Job,
    checkpoint: str | os.PathLike[str] | None,
    key: str | None,
    progress: bool,
) -> Iterator[Any]:
    count, warned, first = 0, 0, ""
    if isinstance(cases, Sequence):
        cases = share_models(cases, KEYWORDS, REQUIRED)
    with ExitStack() as stack:
        store = None if checkpoint is None else stack.enter_context(Checkpoint(checkpoint))
        total = len(cases) if isinstance(cases, Sized) else None
        shown = stack.enter_context(bar("cases", total, unit="case") if progress else nullcontext())
        for value, messages in _outcomes(cases, workers, job, store, key):
            if messages:
                first = first or f"case {count}: {messages[0]}"
                warned += 1
            count += 1
            if shown is not None:
                shown.update()
            yield value
    if count == 0:
        raise InputError(_EMPTY)
    if warned:
        warn(first + (f" ({warned - 1} more of {count} cases warn)" if warned > 1 else ""))


_EMPTY = "cases is empty: there is nothing to simulate"


class _Item(NamedTuple):
    """A case, its digest in the checkpoint, and whether the checkpoint has it already."""

    case: Any
    digest: str = ""
    known: bool = False


def _outcomes(
    cases: Iterable[Any], workers: Any, job: _Job, store: Checkpoint | None, key: str | None
) -> Iterator[Outcome]:
    if store is None:
        for _, outcome in run_tasks(workers, job, map(_Item, cases)):
            yield outcome
        return
    for item, outcome in run_tasks(workers, job, _recognised(cases, job, store, key)):
        if item.known:
            yield store.get(item.digest)
            continue
        # Results and this package's own errors; other errors may not occur again.
        if not isinstance(outcome[0], Exception) or isinstance(outcome[0], AOImpactError):
            store.put(item.digest, outcome)
        yield outcome


def _recognised(
    cases: Iterable[Any], job: _Job, store: Checkpoint, key: str | None
) -> Iterator[_Item]:
    digests, ours = Digests(key), version("aoimpact")
    for i, case in enumerate(cases):
        digest = digests.of((ours, job.keep, case), f"case {i}")
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
        found = plain_numbers(cases, self.keep.names)
        for i, numbers in shared_numbers(cases, self.keep.names).items():
            found[i] = numbers
        return [None if numbers is None else (numbers, ()) for numbers in found]

    def _alone(self, case: Any) -> Outcome:
        with held_warnings() as messages:
            try:
                result = _run(case)
                value = result if self.keep is None else self.keep(result)
                value = as_json(value) if self.stored else value
            except Exception as error:
                value = _portable(error)
        return value, tuple(messages)


@dataclass(frozen=True)
class Failed:
    """A case that could not be made."""

    error: Exception


def _run(case: Any) -> Any:
    if isinstance(case, Failed):
        raise case.error
    if isinstance(case, SharedCase):
        return case.simulate()
    if isinstance(case, Mapping):
        for name in case:
            if name not in KEYWORDS:
                raise InputTypeError(
                    f"case: simulate has no keyword {name!r}{nearest(str(name), KEYWORDS)}"
                )
        for name in REQUIRED:
            if name not in case:
                raise InputTypeError(f"case: {name} is missing")
        return simulate(**case)
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
