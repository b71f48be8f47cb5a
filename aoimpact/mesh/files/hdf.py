"""HDF5 files, whose arrays are checked against the size of the file before they are read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...base import MeshError

__all__ = ["opened"]

# Bytes that one byte of a file may stand for: what zlib compresses by at most, about.
_COMPRESSION = 1100


@contextmanager
def opened(file: Path) -> Iterator[Any]:
    """Open an HDF5 file, and turn what h5py says of a damaged one into a `ValueError`."""
    try:
        import h5py
    except ModuleNotFoundError:
        raise MeshError(
            f"mesh file {str(file)!r} needs the package h5py: pip install h5py"
        ) from None
    most = 4096 + _COMPRESSION * file.stat().st_size

    def check(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.nbytes > most:
            raise ValueError(f"{name} announces {item.nbytes} bytes, more than the file can hold")

    try:
        with h5py.File(file, "r") as tree:
            tree.visititems(check)
            yield tree
    except (OSError, RuntimeError, LookupError, TypeError, AttributeError) as error:
        raise ValueError(f"HDF5: {error}") from None
