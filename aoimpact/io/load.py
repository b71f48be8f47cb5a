"""Mesh files of other programs, a reader for each format.

A reader returns a `RawMesh`. It raises a `ValueError` with the reason, or a `MeshError` that names
the file.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from ..base import FilePath, MemoryLimitError, MeshError, MissingFileError, file_path
from . import abaqus, exodus, gmsh, med, nastran, viameshio, vtk
from .abaqusdeck import looks_like_inp
from .nastrandeck import is_nastran
from .raw import RawMesh

__all__ = ["existing", "load"]

_Reader = Callable[[Path], RawMesh]

# Bytes by which a format is recognised; decks and punched files begin with other entries.
_HEAD = 2**20

# Readers by the end of a file's name, in small letters; meshio takes the rest.
_READERS: dict[str, _Reader] = {
    **dict.fromkeys((".bdf", ".nas"), nastran.read),
    **dict.fromkeys((".e", ".ex2", ".exo", ".g", ".gen"), exodus.read),
    ".inp": abaqus.read,
    ".med": med.read,
    ".vtu": vtk.read,
}


def load(path: FilePath) -> RawMesh:
    """Return the nodes, cells and groups of a file.

    Raises
    ------
    MissingFileError
        If there is no such file.
    MeshError
        If it is empty, or its reader refuses it.
    MemoryLimitError
        If there is not enough memory for it.
    """
    file = file_path("mesh", path)
    where = f"mesh file {str(file)!r}"
    head = existing("mesh file", file)
    try:
        return _reader(file.suffix.lower(), head)(file)
    except MeshError:
        raise
    except MemoryError:
        raise MemoryLimitError(f"{where} needs more memory than there is: coarsen it") from None
    except (ValueError, LookupError, OverflowError, OSError) as error:
        why = f"{where} cannot be read: {error}"
        raise MeshError(f"{why}. Save it again, or as .msh or .vtu") from None


def existing(what: str, file: Path) -> bytes:
    """Return the beginning of a file that is to be read.

    Raises
    ------
    MissingFileError
        If there is no such file.
    MeshError
        If it cannot be opened, is none, or is empty.
    """
    where = f"{what} {str(file)!r}"
    try:
        if file.exists() and not file.is_file():  # to read a pipe might never end
            raise MeshError(f"{where} is no regular file")
        with file.open("rb") as stream:
            head = stream.read(_HEAD)
    except FileNotFoundError:
        raise MissingFileError(f"{where} does not exist (in {os.getcwd()})") from None
    except OSError as error:  # no access, or a name that is too long
        raise MeshError(f"{where} cannot be opened: {error}") from None
    if not head:
        raise MeshError(f"{where}: it is empty")
    return head


def _reader(suffix: str, head: bytes) -> _Reader:
    if looks_like_inp(head[:4096]):  # CalculiX writes .msh
        return abaqus.read
    if suffix.startswith(".msh"):
        return gmsh.read
    foreign = suffix not in _READERS or (suffix == ".inp" and head.lstrip()[:1] != b"*")
    if foreign and is_nastran(head):
        return nastran.read
    return _READERS.get(suffix, viameshio.read)
