"""Numbers in text."""

from __future__ import annotations

import warnings

import numpy as np

from ..base import FloatArray

__all__ = ["numbers_of"]


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
