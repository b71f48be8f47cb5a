"""Bounds for meshio's readers, which allocate what a file's counts say and read on at its end.

While a file is read, its readers see NumPy and `open` through this module: arrays larger than a
file of that size can stand for, and reads that go on beyond its end, are errors. Other threads'
readers have no bounds, and after the last file meshio's modules are as they were.
"""

from __future__ import annotations

import builtins
import io
import math
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from ..base import GIB

__all__ = ["Reading", "bounded", "bounded_text"]

# Bytes of arrays that any file may ask for, and how many times its size beyond that: text takes
# two bytes or more for a number, of which readers make several arrays of eight each.
_FOR_ALL, _PER_BYTE = GIB, 64

# Empty reads at the end of a file after which its reader would go on for ever, or for very long.
_MOST_EMPTY = 1000


@dataclass
class Reading:
    """A file that is read.

    Attributes
    ----------
    size : int
        Bytes.
    left : float
        Bytes that its reader may still ask for.
    opened : _Ending, optional
        What was opened last.
    """

    size: int
    left: float = field(init=False)
    opened: _Ending | None = None

    def __post_init__(self) -> None:
        self.left = float(_FOR_ALL + _PER_BYTE * self.size)

    @property
    def place(self) -> str:
        """How far the reader came, in words; empty where that is not known."""
        return "" if self.opened is None else self.opened.place


# What the reader of this context reads; None: without bounds.
_reading: ContextVar[Reading | None] = ContextVar("aoimpact_mesh_reading", default=None)


@contextmanager
def bounded(reading: Reading) -> Iterator[None]:
    """Bound what meshio's readers, called in this context, take for a file."""
    _bindings.begin()
    token = _reading.set(reading)
    try:
        yield
    finally:
        _reading.reset(token)
        _bindings.end()


def _take(n_bytes: float) -> None:
    reading = _reading.get()
    if reading is None:
        return
    reading.left -= n_bytes
    if reading.left < 0.0:
        raise ValueError(
            f"the file asks for an array of {n_bytes / GIB:.3g} GiB, which is out of proportion "
            "to its size: a count or number in it is wrong"
        )


class _Ending:
    """A file that refuses to be read again and again beyond its end."""

    _empty = 0
    # Lines read; None where other reads than by lines came between.
    lines: int | None = 0
    # Where it was closed, bytes from its beginning.
    _last: int | None = None
    name: Any

    @property
    def place(self) -> str:
        if self.lines:
            return f"line {self.lines}"
        if not self._last:
            return ""
        with builtins.open(self.name, "rb") as file:
            before = file.read(self._last)
        line = 1 + before.rstrip().count(b"\n")
        return f"byte {self._last}" if b"\0" in before else f"line {line}"

    def _ended(self, got: Any, *, line: bool = False) -> Any:
        self.lines = self.lines + 1 if line and self.lines is not None else None
        if not got:
            self._empty += 1
            if self._empty > _MOST_EMPTY:
                raise EOFError("the file ends before what it announces")
        return got


class _EndingBytes(_Ending, io.BufferedReader):
    lines = None  # NumPy reads on beside it

    def close(self) -> None:
        with suppress(OSError, ValueError):  # closed already
            self._last = self.tell()
        super().close()

    def readline(self, size: Any = -1, /) -> bytes:
        return bytes(self._ended(super().readline(size)))

    def read(self, size: Any = -1, /) -> bytes:
        return bytes(self._ended(super().read(size)))


class _EndingText(_Ending, io.TextIOWrapper):
    def readline(self, size: Any = -1, /) -> str:  # type: ignore[override]
        return str(self._ended(super().readline(size), line=True))

    def read(self, size: Any = -1, /) -> str:
        return str(self._ended(super().read(size)))


def bounded_text(binary: Any) -> Any:
    """Return a binary file as one of text that is not read beyond its end for ever."""
    return _EndingText(binary)


def _open(path: Any, mode: str = "r", *args: Any, **keywords: Any) -> Any:
    reading = _reading.get()
    if reading is None or mode not in ("r", "rb") or args or keywords:
        return builtins.open(path, mode, *args, **keywords)
    binary = _EndingBytes(io.FileIO(path))
    reading.opened = binary if mode == "rb" else bounded_text(binary)
    return reading.opened


class _Grids:
    """``np.mgrid``."""

    def __getitem__(self, key: Any) -> Any:
        slices = key if isinstance(key, tuple) else (key,)
        lengths = [_length(part.start or 0, part.stop, part.step or 1) for part in slices]
        _take(8.0 * len(slices) * math.prod(lengths))
        return np.mgrid[key]


def _length(start: Any, stop: Any = None, step: Any = 1) -> float:
    first, last = (0, start) if stop is None else (start, stop)
    return max(0.0, (float(last) - float(first)) / float(step)) if step else 0.0


def _by_shape(function: Callable[..., Any]) -> Callable[..., Any]:
    def made(shape: Any, *args: Any, **keywords: Any) -> Any:
        _take(8.0 * math.prod(float(n) for n in np.ravel(shape)))
        return function(shape, *args, **keywords)

    return made


def _arange(*args: Any, **keywords: Any) -> Any:
    _take(8.0 * _length(*args[:3]))
    return np.arange(*args, **keywords)


def _linspace(start: Any, stop: Any, num: Any = 50, **keywords: Any) -> Any:
    _take(8.0 * float(num))
    return np.linspace(start, stop, num, **keywords)


def _fromfile(
    file: Any, dtype: Any = float, count: Any = -1, sep: str = "", **keywords: Any
) -> Any:
    _take(float(np.dtype(dtype).itemsize) * max(0.0, float(count)))
    if isinstance(file, _Ending):
        file.lines = None
    return np.fromfile(file, dtype, count, sep, **keywords)


def _fromfile_of_gmsh(file: Any, *args: Any, **keywords: Any) -> Any:
    """A section of Gmsh 4.1 begins with four counts, of which the first becomes a list's length."""
    found = _fromfile(file, *args, **keywords)
    if found.shape == (4,) and found.dtype == np.uint64:
        _take(8.0 * float(found[0]))
    return found


def _fromiter(values: Any, dtype: Any, count: Any = -1, **keywords: Any) -> Any:
    _take(8.0 * max(0.0, float(count)))
    return np.fromiter(values, dtype, count, **keywords)


def _add_outer(one: Any, other: Any, **keywords: Any) -> Any:
    _take(8.0 * float(np.size(one)) * float(np.size(other)))
    return np.add.outer(one, other, **keywords)


class _Numpy(ModuleType):
    """NumPy with bounds on what makes an array of a size that is a number in the file."""

    def __init__(self, fromfile: Callable[..., Any] = _fromfile) -> None:
        super().__init__("numpy")
        for name in ("empty", "zeros", "ones", "full"):
            setattr(self, name, _by_shape(getattr(np, name)))
        self.arange, self.linspace, self.mgrid = _arange, _linspace, _Grids()
        self.fromfile, self.fromiter = fromfile, _fromiter
        self.add = SimpleNamespace(outer=_add_outer)

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)


_NUMPY, _NUMPY_OF_GMSH = _Numpy(), _Numpy(_fromfile_of_gmsh)


class _Bindings:
    """Lets meshio's modules see NumPy and `open` through this one while files are read."""

    def __init__(self) -> None:
        self._lock, self._files = threading.Lock(), 0
        self._before: list[tuple[ModuleType, str, Any]] = []

    def begin(self) -> None:
        with self._lock:
            self._files += 1
            for name, module in tuple(sys.modules.items()):
                if name.startswith("meshio."):
                    if getattr(module, "np", None) is np:
                        ours = _NUMPY_OF_GMSH if name.startswith("meshio.gmsh.") else _NUMPY
                        self._put(module, "np", ours)
                    if vars(module).get("open") is not _open:
                        self._put(module, "open", _open)

    def _put(self, module: ModuleType, name: str, value: Any) -> None:
        self._before.append((module, name, vars(module).get(name)))
        setattr(module, name, value)

    def end(self) -> None:
        with self._lock:
            self._files -= 1
            while self._before and not self._files:
                module, name, value = self._before.pop()
                if value is None:  # it saw Python's own
                    delattr(module, name)
                else:
                    setattr(module, name, value)


_bindings = _Bindings()
