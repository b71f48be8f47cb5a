"""Progress bars for what takes longer than a second: on a terminal, and in a notebook."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["Progress", "advance", "bar"]

# Seconds after which a bar appears, and between which its clock goes on though nothing is counted:
# a factorisation says nothing until it is done.
_DELAY, _CLOCK = 1.0, 0.5

# The outermost bar of each thread. Work within it is shown beside it.
_open = threading.local()


class Progress:
    """Progress that is not shown.

    Attributes
    ----------
    n : float
        How far it has come.
    """

    def __init__(self) -> None:
        self.n: float = 0

    def update(self, n: float = 1) -> None:
        """Go on by `n`."""
        self.n += n


class _Bar(Progress):
    """The outermost one, drawn by tqdm."""

    def __init__(self, what: str, total: float | None, unit: str) -> None:
        super().__init__()
        self.unit = unit
        self._drawn = _tqdm()(
            total=total, desc=what, unit=" " + unit, delay=_DELAY, leave=False, miniters=0
        )
        self._over = threading.Event()
        self._clock = threading.Thread(target=self._tick, daemon=True)
        self._clock.start()

    def update(self, n: float = 1) -> None:
        super().update(n)
        self._drawn.update(n)

    def tell(self, words: str) -> None:
        """Say beside the bar what is being done."""
        self._drawn.set_postfix_str(words, refresh=False)
        self._drawn.update(0)

    def close(self) -> None:
        """Take it away."""
        self._over.set()
        self._clock.join()
        self._drawn.close()

    def _tick(self) -> None:
        while not self._over.wait(_CLOCK):
            self._drawn.update(0)


class _Part(Progress):
    """What is done within the outermost bar."""

    def __init__(self, outer: _Bar, what: str, total: float | None) -> None:
        super().__init__()
        self._outer, self._what, self._total = outer, what, total
        outer.tell(what)

    def update(self, n: float = 1) -> None:
        super().update(n)
        share = f" {min(self.n / self._total, 1.0):.0%}" if self._total else ""
        self._outer.tell(self._what + share)


@contextmanager
def bar(what: str, total: float | None = None, unit: str = "step") -> Iterator[Progress]:
    """Show how far something has come, if it takes longer than a second.

    A bar within another one is shown beside that. In logs, files and tests there is none.

    Parameters
    ----------
    what : str
        What is being done.
    total : float, optional
        How far ``update`` will go.
    unit : str, optional

    Examples
    --------
    >>> with bar("models", 3) as progress:
    ...     for _ in range(3):
    ...         progress.update()
    """
    outer: _Bar | None = getattr(_open, "bar", None)
    if outer is not None:
        yield _Part(outer, what, total)
    elif not (_in_notebook() or _on_terminal()):
        yield Progress()
    else:
        _open.bar = shown = _Bar(what, total, unit)
        try:
            yield shown
        finally:
            _open.bar = None
            shown.close()


def advance(unit: str, n: float = 1) -> None:
    """Go on by `n` in the outermost bar, if it counts these."""
    outer: _Bar | None = getattr(_open, "bar", None)
    if outer is not None and outer.unit == unit:
        outer.update(n)


def _on_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


def _in_notebook() -> bool:
    """Whether a kernel draws what is written; its standard error is no terminal."""
    if "ipykernel" not in sys.modules:
        return False
    from IPython import get_ipython  # type: ignore[attr-defined, unused-ignore]

    return hasattr(get_ipython(), "kernel")


def _tqdm() -> Any:
    from tqdm import tqdm  # takes longer to import than most bars would show

    return tqdm
