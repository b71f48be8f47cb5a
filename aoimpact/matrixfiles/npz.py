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

__all__ = ["is_npz", "read_npz"]

# Largest compression of arrays of a matrix; zlib itself reaches some 1000.
_MOST_RATIO = 200


def is_npz(head: bytes) -> bool:
    """True if a file is an archive."""
    return head.startswith(b"PK\x03\x04")


def read_npz(file: Path, size: int) -> list[Found]:
    """Read a sparse matrix, or all square arrays of an archive by their names."""
    try:
        _check_sizes(file, size)
        with np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, KeyError) as error:
        raise spoilt(file, f"it is no archive of NumPy, or cut short: {error}") from None
    except (ValueError, NotImplementedError, TypeError, SyntaxError, TokenError) as error:
        raise spoilt(file, f"its arrays cannot be read: {error}") from None
    if "format" in arrays:
        return [_found(file, "", _sparse(file, arrays))]
    square = {
        name: array
        for name, array in arrays.items()
        if array.ndim == 2 and array.shape[0] == array.shape[1] and array.dtype.kind in "iuf"
    }
    if not square:
        raise spoilt(file, f"it has no square matrix of real numbers, but {', '.join(arrays)}")
    return [_found(file, name.upper(), sp.coo_array(array)) for name, array in square.items()]


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


def _sparse(file: Path, arrays: dict[str, Any]) -> Any:
    """The matrix of the arrays that `save_npz` writes."""
    try:
        shape = tuple(int(n) for n in arrays["shape"])
        data = arrays["data"]
        if len(shape) != 2 or shape[0] != shape[1]:
            raise ValueError(f"the matrix is of shape {shape}, not square")
        if data.dtype.kind not in "iuf":
            raise ValueError(f"its numbers are of type {data.dtype}")
        if shape[0] > data.size:
            raise ValueError(f"{shape[0]} rows have {data.size} entries, not one on each diagonal")
        kind = bytes(arrays["format"].item()).decode()
        if kind in ("csr", "csc", "bsr"):
            made = getattr(sp, f"{kind}_array")
            matrix = made((data, arrays["indices"], arrays["indptr"]), shape=shape)
            matrix.check_format(full_check=True)
            return matrix.tocoo()
        if kind == "coo":
            places = (arrays["row"], arrays["col"])
            if "coords" in arrays:
                places = tuple(arrays["coords"])
            return sp.coo_array((data, places), shape=shape)
        if kind == "dia":
            return sp.dia_array((data, arrays["offsets"]), shape=shape).tocoo()
    except (ValueError, TypeError, KeyError, IndexError, OverflowError, AttributeError) as error:
        raise spoilt(file, f"it is no sparse matrix: {error}") from None
    raise spoilt(file, f"it is a sparse matrix of format {kind!r}; save it as csr")


def _found(file: Path, name: str, matrix: Any) -> Found:
    rows, cols = matrix.row.astype(np.int64), matrix.col.astype(np.int64)
    values = matrix.data.astype(float)
    return Found(file, name, matrix.shape[0], rows, cols, values, unique=False)
