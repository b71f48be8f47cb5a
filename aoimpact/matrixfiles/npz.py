"""Matrices that SciPy and NumPy have saved: ``scipy.sparse.save_npz`` and ``numpy.savez``."""

from __future__ import annotations

import math
import zipfile
import zlib
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import require
from .found import Found, spoilt

# Largest compression of arrays of a matrix; zlib itself reaches some 1000.
_MOST_RATIO = 200

# Errors of NumPy and SciPy for arrays that are not those of a matrix.
_UNREADABLE = (
    *(ValueError, NotImplementedError, TypeError, SyntaxError, TokenError),
    *(IndexError, OverflowError, AttributeError),
)


def is_npz(head: bytes) -> bool:
    """True if a file is an archive."""
    return head.startswith(b"PK\x03\x04")


def read_npz(file: Path, size: int) -> list[Found]:
    """Read a sparse matrix, or all square arrays of an archive by their names."""
    arrays: dict[str, Any] = {}
    try:
        _check_sizes(file, size)
        with np.load(file, allow_pickle=False) as archive:
            if "format" not in archive.files:
                arrays = {name.upper(): archive[name] for name in archive.files}
        if not arrays:
            arrays[""] = sp.load_npz(file)
            if hasattr(arrays[""], "check_format"):
                arrays[""].check_format(full_check=True)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, KeyError) as error:
        raise spoilt(file, f"it is no archive of NumPy, or cut short: {error}") from None
    except _UNREADABLE as error:
        raise spoilt(file, f"its arrays cannot be read: {error}") from None
    found = []
    for name, array in arrays.items():
        if array.ndim == 2 and array.shape[0] == array.shape[1] and array.dtype.kind in "iuf":
            matrix = sp.coo_array(array)
            rows, cols = matrix.row.astype(np.int64), matrix.col.astype(np.int64)
            values = matrix.data.astype(float)
            found.append(Found(file, name, array.shape[0], rows, cols, values, unique=False))
    if not found:
        raise spoilt(file, f"it has no square matrix of real numbers, but {', '.join(arrays)}")
    return found


def _check_sizes(file: Path, size: int) -> None:
    """Refuse arrays that are out of proportion before they are made."""
    with zipfile.ZipFile(file) as archive:
        whole = sum(one.file_size for one in archive.infolist())
        if whole > _MOST_RATIO * size:
            raise ValueError(f"they would take {whole} bytes out of a file of {size}")
        require(3 * whole, f"matrix file {str(file)!r}", "take a coarser mesh")
        for one in archive.infolist():
            with archive.open(one) as stream:
                version = np.lib.format.read_magic(stream)
                known = {
                    (1, 0): np.lib.format.read_array_header_1_0,
                    (2, 0): np.lib.format.read_array_header_2_0,
                }
                if version not in known:
                    raise ValueError(f"{one.filename} is of version {version}")
                shape, _, dtype = known[version](stream)
                if math.prod(shape) * dtype.itemsize > one.file_size:
                    raise ValueError(
                        f"{one.filename} announces {shape} numbers, but has {one.file_size} bytes"
                    )
