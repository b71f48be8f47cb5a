"""How much memory there is, so that what would not fit is refused and not begun."""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

from .errors import MemoryLimitError

__all__ = ["GIB", "available", "require"]

GIB = 2.0**30

# Control groups of version 2 (containers): what the group may use, and what it uses.
_CGROUP = Path("/sys/fs/cgroup")


def available() -> float:
    """Return the memory available now, bytes; infinite if the system does not report it."""
    if sys.platform == "win32":
        return _windows()
    try:
        return min(_linux(), _container(), _address_space())
    except OSError:
        return _physical()


def require(n_bytes: float, what: str, cure: str) -> None:
    """Refuse work that needs more memory than there is.

    Parameters
    ----------
    n_bytes : float
        An estimate of what is needed.
    what, cure : str
        For the message: what would need it, and what to do instead.

    Raises
    ------
    MemoryLimitError
    """
    free = available()
    if n_bytes > free:
        raise MemoryLimitError(
            f"{what} would need some {n_bytes / GIB:.3g} GiB of memory, and {free / GIB:.3g} GiB "
            f"are free: {cure}"
        )


def _linux() -> float:
    for line in Path("/proc/meminfo").read_text().splitlines():
        if line.startswith("MemAvailable:"):
            return 1024.0 * int(line.split()[1])
    return _physical()


def _container() -> float:
    try:
        limit = (_CGROUP / "memory.max").read_text().strip()
        used = (_CGROUP / "memory.current").read_text()
    except OSError:
        return float("inf")
    return float("inf") if limit == "max" else float(limit) - float(used)


def _address_space() -> float:
    """What a limit of this process (``ulimit -v``, batch systems) leaves it."""
    import resource  # not there on Windows

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return float("inf")
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    return max(0.0, float(limit) - float(pages * resource.getpagesize()))


def _physical() -> float:
    """All the memory of the machine: macOS has no quick count of what is free."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * float(os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return float("inf")


class _MemoryStatus(ctypes.Structure):
    """MEMORYSTATUSEX of the Windows API."""

    _fields_ = (
        ("length", ctypes.c_uint32),
        ("load", ctypes.c_uint32),
        ("total_physical", ctypes.c_uint64),
        ("free_physical", ctypes.c_uint64),
        ("total_page_file", ctypes.c_uint64),
        ("free_page_file", ctypes.c_uint64),
        ("total_virtual", ctypes.c_uint64),
        ("free_virtual", ctypes.c_uint64),
        ("free_extended_virtual", ctypes.c_uint64),
    )


def _windows() -> float:
    status = _MemoryStatus(length=ctypes.sizeof(_MemoryStatus))
    kernel = getattr(ctypes, "windll").kernel32  # noqa: B009  (not there for mypy elsewhere)
    if not kernel.GlobalMemoryStatusEx(ctypes.byref(status)):
        return float("inf")
    return float(status.free_physical)
