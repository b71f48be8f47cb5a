"""Mesh files of other programs, a reader for each format.

A reader returns a `RawMesh`. It raises a `ValueError` with the reason, or a `MeshError` that names
the file.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

from ..base import MemoryLimitError, MeshError, MissingFileError, file_path
from . import abaqus, exodus, gmsh, med, nastran, viameshio, vtk
from .abaqusdeck import looks_like_inp
from .nastrandeck import is_nastran
from .raw import RawMesh

__all__ = ["existing", "load"]

_Reader = Callable[[Path], RawMesh]

# Readers by the end of a file's name, in small letters; meshio takes the rest.
_READERS: dict[str, _Reader] = {
    **dict.fromkeys((".bdf", ".nas"), nastran.read),
    **dict.fromkeys((".e", ".ex2", ".exo", ".g", ".gen"), exodus.read),
    ".inp": abaqus.read,
    ".med": med.read,
    ".vtk": vtk.read_legacy,
    ".vtu": vtk.read_xml,
}


def load(path: str | os.PathLike[str]) -> RawMesh:
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
    size = existing("mesh file", file)
    try:
        return _reader(file)(file)
    except MeshError:
        raise
    except MemoryError:
        raise MemoryLimitError(
            f"{where} ({size} bytes) needs more memory than there is: coarsen the mesh, "
            "or look for a count in the file that is wrong"
        ) from None
    except (ValueError, OverflowError) as error:
        raise MeshError(
            f"{where} cannot be read: {error}. Save it again, or as .msh or .vtu"
        ) from None


def existing(what: str, file: Path) -> int:
    """Return the size of a file that is to be read, bytes.

    Raises
    ------
    MissingFileError
        If there is no such file.
    MeshError
        If it cannot be opened, is none, or is empty.
    """
    where = f"{what} {str(file)!r}"
    try:
        state = file.stat()
    except FileNotFoundError:
        raise MissingFileError(f"{where} does not exist (in {os.getcwd()})") from None
    except OSError as error:  # no access, or a name that is too long
        raise MeshError(f"{where} cannot be opened: {error}") from None
    if not stat.S_ISREG(state.st_mode):
        kind = "a directory" if stat.S_ISDIR(state.st_mode) else "no regular file"
        raise MeshError(f"{where} is {kind}")
    if state.st_size == 0:
        raise MeshError(f"{where}: it is empty")
    return state.st_size


def _reader(file: Path) -> _Reader:
    suffix = file.suffix.lower()
    with file.open("rb") as stream:
        head = stream.read(4096)
    if looks_like_inp(head):  # CalculiX writes .msh
        return abaqus.read
    if suffix.startswith(".msh"):
        return gmsh.read
    if suffix not in _READERS and is_nastran(file):
        return nastran.read
    return _READERS.get(suffix, viameshio.read)
