"""Mesh files: which reader takes which."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

from ...base import MemoryLimitError, MeshError, MissingFileError, file_path
from . import abaqus, exodus, gmsh, kratos, med, nastran, viameshio, vtk
from .inpfile import looks_like_inp
from .nastrantext import is_nastran
from .rawmesh import RawMesh

__all__ = ["load"]

_Reader = Callable[[Path], RawMesh]

# Readers by the end of a file's name, in small letters; meshio takes the rest. A reader raises
# ValueError with the reason, or MeshError if that names the file.
_READERS: dict[str, _Reader] = {
    **dict.fromkeys((".bdf", ".nas"), nastran.read),
    **dict.fromkeys((".e", ".ex2", ".exo", ".g", ".gen"), exodus.read),
    ".inp": abaqus.read,
    ".mdpa": kratos.read,
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
    file = _existing(path)
    reader = _reader(file)
    try:
        return reader(file)
    except MeshError:
        raise
    except MemoryError:
        raise MemoryLimitError(
            f"mesh file {str(file)!r} ({file.stat().st_size} bytes) needs more memory than there "
            "is: coarsen the mesh, or look for a count in the file that is wrong"
        ) from None
    except (ValueError, OverflowError) as error:
        raise MeshError(
            f"mesh file {str(file)!r} cannot be read: {error}. Save it again, or as .msh or .vtu"
        ) from None


def _reader(file: Path) -> _Reader:
    suffix = file.suffix.lower()
    with file.open("rb") as stream:
        head = stream.read(4096)
    if suffix.startswith(".msh") and head.lstrip().startswith(b"$"):  # else Fluent's, or CalculiX'
        return gmsh.read
    if looks_like_inp(head):
        return abaqus.read
    if suffix not in _READERS and is_nastran(file):
        return nastran.read
    return _READERS.get(suffix, viameshio.read)


def _existing(path: str | os.PathLike[str]) -> Path:
    """Return the path of a file that is there and has a content."""
    file = file_path("mesh", path)
    try:
        state = file.stat()
    except FileNotFoundError:
        raise MissingFileError(
            f"mesh file {str(file)!r} does not exist (in {os.getcwd()})"
        ) from None
    except OSError as error:  # no access, or a name that is too long
        raise MeshError(f"mesh file {str(file)!r} cannot be opened: {error}") from None
    if not stat.S_ISREG(state.st_mode):
        what = "a directory" if stat.S_ISDIR(state.st_mode) else "no regular file"
        raise MeshError(f"mesh file {str(file)!r} is {what}")
    if state.st_size == 0:
        raise MeshError(f"mesh file {str(file)!r} is empty")
    return file
