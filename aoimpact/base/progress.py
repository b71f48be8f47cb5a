"""Progress bars for tasks that take longer than a second, on a terminal or in a notebook."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

# Time after which a bar appears, s.
_DELAY = 1.0

# The outermost progress bar of each thread.
_open = threading.local()


@contextmanager
def bar(
    what: str, total: float | None = None, unit: str = "step", wanted: bool = True
) -> Iterator[Any]:
    """Show the progress of a task that takes longer than a second, as a ``tqdm.tqdm``.

    A bar within the context of another bar is shown below the other. A bar is shown only on a
    terminal or in a notebook.

    Parameters
    ----------
    what : str
        Name of the task.
    total : float, optional
        Sum of all updates.
    unit : str, optional
    wanted : bool, optional

    Examples
    --------
    >>> with bar("models", 3) as progress:
    ...     for _ in range(3):
    ...         progress.update()
    """
    from tqdm import tqdm  # slow to import

    options: dict[str, Any] = {"delay": _DELAY, "leave": False, "miniters": 0}
    notebook = False  # a notebook is no terminal, but shows the bar
    if "ipykernel" in sys.modules:
        from IPython import get_ipython  # type: ignore[attr-defined, unused-ignore]

        notebook = hasattr(get_ipython(), "kernel")
    shown = wanted and (notebook or (sys.stderr is not None and sys.stderr.isatty()))
    with tqdm(total=total, desc=what, unit=" " + unit, disable=not shown, **options) as drawn:
        if not shown or getattr(_open, "bar", None) is not None:
            yield drawn
            return
        _open.bar = drawn
        try:
            yield drawn
        finally:
            _open.bar = None


def advance(unit: str, n: float = 1) -> None:
    """Advance the outermost bar by `n`, if it counts in `unit`."""
    outer = getattr(_open, "bar", None)
    if outer is not None and outer.unit == " " + unit:
        outer.update(n)
