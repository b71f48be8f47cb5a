"""Trials of numbers in child processes; one that crashes, or takes too long, is replaced."""

from __future__ import annotations

import argparse
import faulthandler
import os
import re
import resource
import shutil
import signal
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path

import aoimpact

from .outcome import Trial, Verdict

# Module of each kind; its `trial(options, folder)` returns the function that tries a number.
KINDS = {
    "scene": "judge",
    "oblique": "oblique",
    "abaqus": "abaqusdecks",
    "nastran": "nastrandecks",
    "mesh": "meshes",
    "matrix": "matrices",
    "matrixfile": "matrixfiles",
    "scenefile": "scenefiles",
}

# Limits of a trial: processor time, s, wall time over that, and memory beyond the imports, bytes.
LIMIT, PATIENCE, MEMORY = 60.0, 10.0, 2**31

_trial: Trial


def _begin(options: argparse.Namespace, folder: Path) -> None:
    """Prepare a child process: import all modules, whose time and memory do not count."""
    global _trial
    faulthandler.enable()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # readers may print
    _trial = import_module(f".{KINDS[options.kind]}", __package__).trial(options, folder)
    for name in dir(aoimpact):
        getattr(aoimpact, name)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, 2 * (pages * resource.getpagesize() + MEMORY,))


def _tried(number: int) -> tuple[Verdict, float]:
    """Return the verdict on a number, and the processor time that it took, s."""
    signal.setitimer(signal.ITIMER_PROF, LIMIT)  # this and the next line may end the process
    faulthandler.dump_traceback_later(PATIENCE * LIMIT, exit=True)
    begin = time.process_time()
    verdict = _trial(number)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    faulthandler.cancel_dump_traceback_later()
    return verdict, time.process_time() - begin


def each(options: argparse.Namespace, root: str) -> Iterator[tuple[int, Verdict, float]]:
    """Yield each number with its verdict and the processor time that it took, s."""
    mine = threading.local()
    numbers = range(options.first, options.first + options.count)

    def one(number: int) -> tuple[Verdict, float]:
        if not hasattr(mine, "child"):
            mine.folder = Path(tempfile.mkdtemp(dir=root))
            begin = options, mine.folder
            mine.child = ProcessPoolExecutor(1, get_context("spawn"), _begin, begin)
        try:
            verdict, seconds = mine.child.submit(_tried, number).result()
        except BrokenProcessPool:
            del mine.child
            verdict, seconds = Verdict("hangs", "or crashes: its process ended"), LIMIT
        except Exception as error:
            verdict, seconds = Verdict("failed", f"the campaign itself: {error!r}"), 0.0
        if verdict.failed and options.out is not None:
            name = re.sub(r"\W+", "_", verdict.kind)[:60]
            if not any(options.out.glob(f"{name}-*")):
                shutil.copytree(mine.folder, options.out / f"{name}-{number}")
        return verdict, seconds

    team = ThreadPoolExecutor(options.workers)
    try:
        for number, found in zip(numbers, team.map(one, numbers), strict=True):
            yield number, *found
    finally:
        team.shutdown(cancel_futures=True)
