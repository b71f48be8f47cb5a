"""Available memory, and refusal of work that would need more."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from .errors import MemoryLimitError

GIB = 2.0**30

# Size of the temporary arrays of one batch, bytes. With 4 MB, sums of batches of sparse rows take
# up to twice as long.
_BATCH = 16e6

# Folder of a container's memory limit and use (control groups, version 2).
_CGROUP = Path("/sys/fs/cgroup")


def available() -> float:
    """Return the memory available now, bytes; infinite if the system does not report it.

    The result is the minimum of the machine's free memory and the unused parts of two limits: the
    container's, and this process's (``ulimit -v``, batch systems).
    """
    found = [float("inf")]
    with suppress(OSError, ValueError, AttributeError, ImportError):  # missing on macOS and Windows
        found.append(float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))
        lines = Path("/proc/meminfo").read_text().splitlines()
        (kibibytes,) = (line.split()[1] for line in lines if line.startswith("MemAvailable:"))
        found.append(1024.0 * int(kibibytes))
        import resource  # missing on Windows

        if (limit := resource.getrlimit(resource.RLIMIT_AS)[0]) != resource.RLIM_INFINITY:
            pages = int(Path("/proc/self/statm").read_text().split()[0])
            found.append(max(0.0, float(limit - pages * resource.getpagesize())))
    with suppress(OSError, ValueError):  # "max" means no limit
        limit = int((_CGROUP / "memory.max").read_text())
        found.append(float(limit - int((_CGROUP / "memory.current").read_text())))
    return min(found)


def require(n_bytes: float, what: str, cure: str) -> None:
    """Refuse work that needs more memory than is available.

    Parameters
    ----------
    n_bytes : float
        Estimated memory needed, bytes.
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


def in_batches(count: int, each: float) -> Iterator[slice]:
    """Yield slices of `count` items, each with temporary arrays of `each` bytes."""
    step = max(1, int(_BATCH / max(each, 1.0)))
    for start in range(0, count, step):
        yield slice(start, start + step)
