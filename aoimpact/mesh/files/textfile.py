"""Text of files: encodings, numbers, errors by line."""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...base import FloatArray, IntArray, MeshError, MissingFileError, decoded

__all__ = ["integers", "number", "numbers_of", "read_lines", "refused"]

# Fortran's numbers: 1, -1.5, .5E3, 1.D0, and 1.0+3 for 1.0E+3.
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[EDed]([+-]?\d+)|([+-]\d+))?")


def read_lines(file: Path) -> list[str]:
    """Return the lines of a text file, without their ends.

    The encoding is that of the byte order mark; else UTF-8, or Latin-1 if the file is not UTF-8.

    Raises
    ------
    MissingFileError
        If there is no such file.
    MeshError
        If it cannot be opened, or is binary.
    """
    try:
        if not file.is_file():
            state = "is a directory or device" if file.exists() else "does not exist"
            raise MissingFileError(f"mesh file {str(file)!r} {state}")
        content = file.read_bytes()
    except OSError as error:
        if isinstance(error, MissingFileError):
            raise
        raise MeshError(f"mesh file {str(file)!r} cannot be opened: {error}") from None
    text = decoded(content)
    if text is None:
        raise MeshError(f"mesh file {str(file)!r} is binary; a text file is needed")
    return text.split("\n")


def number(text: str) -> float:
    """Return a number as Fortran programs write it, such as 1.5, 1.D0 or 1.0+3.

    Raises
    ------
    ValueError
        If it is none, or too large for a double.
    """
    found = _NUMBER.fullmatch(text.strip())
    if found is None:
        raise ValueError(f"{text.strip()!r} is no number")
    value = float(f"{found[1]}e{found[2] or found[3] or 0}")
    if not math.isfinite(value):
        raise ValueError(f"{text.strip()!r} is too large")
    return value


def numbers_of(text: bytes) -> FloatArray:
    """Return the numbers of a text that holds nothing but numbers and blanks.

    Raises
    ------
    ValueError
        If there is anything else.
    """
    if not text.strip():
        return np.zeros(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # how older versions of NumPy say it
        try:
            return np.fromstring(text.decode("latin-1"), sep=" ")
        except (ValueError, DeprecationWarning):
            raise ValueError("there is text among the numbers") from None


def integers(values: npt.NDArray[Any]) -> IntArray:
    """Return numbers that must be integers, as such.

    Raises
    ------
    ValueError
        If one is not.
    """
    if values.dtype.kind == "f":
        whole = (np.abs(values) < 2.0**53) & (values == np.trunc(values))
        if not whole.all():
            raise ValueError(f"{values[~whole][0]} is no whole number")
    return values.astype(np.int64)


def refused(file: Path, line: int, what: str, why: str) -> MeshError:
    """Return the error for what a reader does not understand.

    Parameters
    ----------
    file : Path
    line : int
        Counted from 1.
    what : str
        The keyword or entry, as in "*NODE".
    why : str
        The reason, and the cure if there is one.
    """
    return MeshError(f"mesh file {str(file)!r}, line {line}, {what}: {why}")
