"""Progress bars for what takes longer than a second."""

from __future__ import annotations

from typing import Any

__all__ = ["bar"]


def bar(what: str, total: float | None = None, unit: str = "step") -> Any:
    """Return a progress bar to be used in a with statement, on a terminal and after a second.

    Parameters
    ----------
    what : str
        What is being done.
    total : float, optional
        How far ``update`` will go.
    unit : str, optional
    """
    from tqdm import tqdm  # takes longer to import than most bars would show

    # disable=None: no bar where standard error is no terminal, as in logs and tests.
    return tqdm(total=total, desc=what, unit=unit, delay=1.0, leave=False, disable=None)
