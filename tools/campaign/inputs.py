"""Malformed inputs: the trial of an input, as a user would take it, and its verdict.

A failure is a crash, an exception that is no AOImpactError, a MemoryError, a warning that is no
AOImpactWarning, and a message that does not name the file or argument.
"""

from __future__ import annotations

import os
import random
import traceback
import warnings
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import aoimpact as ao

from .outcome import Trial, Verdict


class Given(Protocol):
    """A malformed input in a folder."""

    def run(self) -> None:
        """Read and use the input as a user would."""

    def named(self, message: str) -> bool:
        """Return whether a message names the file or argument that is wrong."""


def _signature(error: BaseException) -> str:
    """Return the exception's type and the package's innermost frames."""
    frames = [
        f"{Path(frame.filename).stem}.{frame.name}"
        for frame in traceback.extract_tb(error.__traceback__)
        if f"{os.sep}aoimpact{os.sep}" in frame.filename
    ]
    return f"{type(error).__name__} in {' < '.join(reversed(frames[-3:]))}"


def judged(given: Given) -> Verdict:
    """Return the verdict on an input: it passes, is refused by name, or fails with a signature."""
    found = Verdict("ok")
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        try:
            given.run()
        except ao.AOImpactError as error:
            named = given.named(str(error))
            found = Verdict("named" if named else f"unnamed {_signature(error)}", str(error))
        except BaseException as error:
            found = Verdict(f"bare {_signature(error)}", str(error))
    for one in seen:
        if not issubclass(one.category, ao.AOImpactWarning) and not found.failed:
            place = f"{Path(one.filename).name}:{one.lineno}"
            found = Verdict(f"warning {one.category.__name__} at {place}", str(one.message))
    return found


def trials(
    seeds: Callable[[Path], Any], make: Callable[[random.Random, Any, Path], Given]
) -> Callable[[Namespace, Path], Trial]:
    """Return the `trial` of a kind whose inputs are made from sound ones, in an empty folder."""

    def trial(options: Namespace, folder: Path) -> Trial:
        sound = seeds(folder)

        def one(number: int) -> Verdict:
            for old in folder.iterdir():
                old.unlink()
            rng = random.Random(f"{options.seed} {options.kind} {number}")
            return judged(make(rng, sound, folder))

        return one

    return trial
