"""Available memory: work that would not fit is refused before it begins."""

from __future__ import annotations

import os
from pathlib import Path

from .errors import MemoryLimitError

GIB = 2.0**30

# Control groups of version 2 (containers): what the group may use, and what it uses.
_CGROUP = Path("/sys/fs/cgroup")


def available() -> float:
    """Return the memory available now, bytes; infinite if the system does not report it."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        (kibibytes,) = (line.split()[1] for line in lines if line.startswith("MemAvailable:"))
        return min(1024.0 * int(kibibytes), _container(), _address_space())
    except (OSError, ValueError):
        return _physical()


def require(n_bytes: float, what: str, cure: str) -> None:
    """Refuse work that needs more memory than there is.

    Parameters
    ----------
    n_bytes : float
        Estimated need.
    what, cure : str
        Parts of the message: the work that needs the memory, and the alternative.

    Raises
    ------
    MemoryLimitError
    """
    free = available()
    if n_bytes > free:
        raise MemoryLimitError(
            f"{what} needs {n_bytes / GIB:.3g} GiB of memory, {free / GIB:.3g} are free: {cure}"
        )


def _container() -> float:
    try:
        limit = (_CGROUP / "memory.max").read_text().strip()
        used = (_CGROUP / "memory.current").read_text()
    except OSError:
        return float("inf")
    return float("inf") if limit == "max" else float(limit) - float(used)


def _address_space() -> float:
    """Bytes left under a limit of this process (``ulimit -v``, batch systems)."""
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
