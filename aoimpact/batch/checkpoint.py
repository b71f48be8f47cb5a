"""A file of finished cases, from which a sweep that was killed resumes.

The file only grows: eight bytes that identify it, then one record per case, which begins with its
length and checksum. A process that is killed leaves at most the last record incomplete; the next
process cuts it off. Records are found by the digest of their case, not by their place in the sweep,
so cases may be changed, added or reordered.

Records are pickles: open only checkpoints that you, or someone you trust, have written.
"""

from __future__ import annotations

import os
import pickle
import struct
import sys
import threading
import zlib
from typing import Any, BinaryIO

from ..base import InputError, file_path, warn
from .fingerprint import DIGEST_SIZE

__all__ = ["Checkpoint"]

_MAGIC = b"AOICKPT1"

# Length of the pickle, CRC-32 of digest and pickle; then the digest, then the pickle.
_HEAD = struct.Struct("<QI")

# Bytes of a record that are checked at a time: a long one takes no memory.
_READ = 2**20


class Checkpoint:
    """Finished cases by their digests, on disk; one process at a time.

    Parameters
    ----------
    path : path
        Made if it is not there.

    Raises
    ------
    InputError
        If the file is something else, cannot be opened, or another sweep is using it.

    Warns
    -----
    AOImpactWarning
        If records were damaged: they are dropped.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._name = str(file_path("checkpoint", path))
        self._lock = threading.Lock()
        self._places: dict[bytes, tuple[int, int]] = {}
        try:
            # O_APPEND would not allow an incomplete record to be overwritten.
            descriptor = os.open(
                self._name, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666
            )
        except OSError as error:
            raise InputError(
                f"checkpoint {self._name!r} cannot be opened: {error.strerror}; give the path of a "
                "file that can be written"
            ) from None
        self._file: BinaryIO = os.fdopen(descriptor, "r+b")
        try:
            _lock_file(self._file, self._name)
        except InputError:
            self._file.close()
            raise
        try:
            self._end = self._read_all()
        except BaseException:
            self.close()
            raise

    def __len__(self) -> int:
        return len(self._places)

    def __contains__(self, digest: bytes) -> bool:
        return digest in self._places

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def get(self, digest: bytes) -> Any:
        """Return what was put under a digest."""
        place, length = self._places[digest]
        with self._lock:
            self._file.seek(place)
            data = self._file.read(length)
        return pickle.loads(data)

    def put(self, digest: bytes, value: Any) -> None:
        """Write a record; it survives if the process is killed after that."""
        data = pickle.dumps(value, protocol=pickle.HIGHEST_PROTOCOL)
        record = _HEAD.pack(len(data), zlib.crc32(data, zlib.crc32(digest))) + digest + data
        with self._lock:
            self._file.seek(self._end)
            self._file.write(record)
            self._file.flush()
            self._places[digest] = self._end + len(record) - len(data), len(data)
            self._end += len(record)

    def close(self) -> None:
        """Wait until everything is on the disk, and release the file."""
        with self._lock:
            if self._file.closed:
                return
            _open_here.discard(_identity(self._file))
            try:
                os.fsync(self._file.fileno())
            finally:
                self._file.close()

    def _read_all(self) -> int:
        """Find all whole records; cut off what follows them. Return where they end."""
        size = os.fstat(self._file.fileno()).st_size
        self._file.seek(0)
        start = self._file.read(len(_MAGIC))
        if not _MAGIC.startswith(start):
            raise InputError(
                f"checkpoint {self._name!r} is a file of another kind and was left as it is; give "
                "another path"
            )
        if len(start) < len(_MAGIC):  # new, or killed during its first write
            self._file.seek(0)
            self._file.write(_MAGIC)
            self._file.flush()
            return len(_MAGIC)
        end = len(_MAGIC)
        while (record := self._read_record(end, size)) is not None:
            digest, length = record
            end += _HEAD.size + DIGEST_SIZE
            self._places[digest] = end, length
            end += length
        if end < size:
            self._cut(end, size)
        return end

    def _read_record(self, place: int, size: int) -> tuple[bytes, int] | None:
        """Digest and length of the pickle of the record at a place; None if it is not whole."""
        head = self._file.read(_HEAD.size + DIGEST_SIZE)
        if len(head) < _HEAD.size + DIGEST_SIZE:
            return None
        length, checksum = _HEAD.unpack_from(head)
        digest = head[_HEAD.size :]
        if length > size - place - len(head):
            return None
        found, left = zlib.crc32(digest), length
        while left > 0:
            data = self._file.read(min(left, _READ))
            found, left = zlib.crc32(data, found), left - len(data)
        return (digest, length) if found == checksum else None

    def _cut(self, end: int, size: int) -> None:
        """Drop an incomplete record; warn if the file is damaged otherwise."""
        self._file.seek(end)
        head = self._file.read(_HEAD.size)
        fits = size - end - _HEAD.size - DIGEST_SIZE
        if len(head) == _HEAD.size and _HEAD.unpack(head)[0] <= fits:  # all there, but wrong
            warn(
                f"checkpoint {self._name!r} is damaged after {len(self)} cases: the last "
                f"{size - end} bytes are dropped, and their cases computed again"
            )
        self._file.truncate(end)


# Files that this process has open as checkpoints, by device and inode: a process is not
# stopped by its own lock.
_open_here: set[tuple[int, int]] = set()


def _identity(file: BinaryIO) -> tuple[int, int]:
    status = os.fstat(file.fileno())
    return status.st_dev, status.st_ino


def _lock_file(file: BinaryIO, name: str) -> None:
    """Lock the file for this process; the system releases it when the process ends in any way.

    The lock belongs to the process, not to the file as flock's would: workers forked from it do not
    keep it when it is killed.
    """
    busy = f"checkpoint {name!r} is in use by another sweep; wait for it, or give another path"
    if _identity(file) in _open_here:
        raise InputError(busy)
    try:
        if sys.platform == "win32":
            import msvcrt

            # Locked bytes cannot be read by others: one far behind any record is taken.
            file.seek(2**62)
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        raise InputError(busy) from None
    except OSError as error:
        raise InputError(
            f"checkpoint {name!r} cannot be locked: {error.strerror}; give a path on a local disk"
        ) from None
    _open_here.add(_identity(file))
