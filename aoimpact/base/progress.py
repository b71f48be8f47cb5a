"""Progress bars for what takes longer than a second: on a terminal, and in a notebook."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

__all__ = ["Progress", "advance", "bar"]

# Seconds after which a bar appears, and between which its clock goes on though nothing is counted:
# a factorisation says nothing until it is done.
_DELAY, _CLOCK = 1.0, 0.5

# The outermost bar of each thread. Work within it is shown beside it.
_open = threading.local()


@dataclass
class Progress:
    """Progress of a task.

    Attributes
    ----------
    n : float
    drawn : tqdm, optional
        The bar on the screen, if there is one.
    unit : str
        Unit that the outermost bar counts.
    part, total : str, float
        Name and total of a task within the outermost bar.
    """

    n: float = 0
    drawn: Any = None
    unit: str = ""
    part: str = ""
    total: float | None = None

    def update(self, n: float = 1) -> None:
        """Go on by `n`."""
        self.n += n
        if self.part:
            self.tell()
        elif self.drawn is not None:
            self.drawn.update(n)

    def tell(self) -> None:
        """Show the share of this part beside the outermost bar."""
        if self.drawn is not None:
            share = f" {min(self.n / self.total, 1.0):.0%}" if self.total else ""
            self.drawn.set_postfix_str(self.part + share, refresh=False)
            self.drawn.update(0)


@contextmanager
def bar(what: str, total: float | None = None, unit: str = "step") -> Iterator[Progress]:
    """Show the progress of a task that takes longer than a second.

    A bar within another one is shown beside that. In logs, files and tests there is none.

    Parameters
    ----------
    what : str
        Name of the task.
    total : float, optional
        Sum of all updates.
    unit : str, optional

    Examples
    --------
    >>> with bar("models", 3) as progress:
    ...     for _ in range(3):
    ...         progress.update()
    """
    outer: Progress | None = getattr(_open, "bar", None)
    if outer is not None:
        part = Progress(drawn=outer.drawn, part=what, total=total)
        part.tell()
        yield part
    elif not (_in_notebook() or _on_terminal()):
        yield Progress()
    else:
        from tqdm import tqdm  # takes longer to import than most bars would show

        options = {"delay": _DELAY, "leave": False, "miniters": 0}
        with tqdm(total=total, desc=what, unit=" " + unit, **options) as drawn:
            over = threading.Event()
            clock = threading.Thread(target=_tick, args=(drawn, over), daemon=True)
            clock.start()
            _open.bar = Progress(drawn=drawn, unit=unit)
            try:
                yield _open.bar
            finally:
                _open.bar = None
                over.set()
                clock.join()


def _tick(drawn: Any, over: threading.Event) -> None:
    while not over.wait(_CLOCK):
        drawn.update(0)


def advance(unit: str, n: float = 1) -> None:
    """Go on by `n` in the outermost bar, if it counts these."""
    outer: Progress | None = getattr(_open, "bar", None)
    if outer is not None and outer.unit == unit:
        outer.update(n)


def _on_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


def _in_notebook() -> bool:
    """True if a notebook kernel draws what is written; its standard error is no terminal."""
    if "ipykernel" not in sys.modules:
        return False
    from IPython import get_ipython  # type: ignore[attr-defined, unused-ignore]

    return hasattr(get_ipython(), "kernel")
