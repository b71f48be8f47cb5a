"""Numbers in text."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, IntArray

__all__ = ["integers", "numbers_of"]


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
