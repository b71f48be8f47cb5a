"""Which matrices of the files are meant, and what their rows are."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..base import InputError, InputTypeError, IntArray, MeshError, file_path
from ..fem import checked_labels
from .dofs import read_dofs
from .formats import read_file
from .found import Found, entry_line, spoilt

# Names of matrices: K, KAA, KAAX, KGG, STIFFNESS; M, MAA, MASS.
_NAMES = {
    role: re.compile(rf"(?:{role}(?:([A-Z])\1)?X?|{word}.*)$")
    for role, word in (("K", "STIF"), ("M", "MASS"))
}

File = str | os.PathLike[str] | tuple[str | os.PathLike[str], str]


@contextmanager
def naming(argument: str) -> Iterator[None]:
    """Begin errors of a file with the argument that it was given for."""
    try:
        yield
    except (InputError, MeshError) as error:
        said = str(error)
        if said.startswith(argument):
            raise
        raise type(error)(f"{argument}: {said}") from error


def chosen(K: File, M: File | None) -> tuple[Found, Found]:
    """The matrices that are meant, of the files' ones."""
    stiffness, wanted = _file("K", K)
    inertia, also_wanted = (stiffness, "") if M is None else _file("M", M)
    with naming("K"):
        read = {stiffness: read_file(stiffness)}
    if inertia == stiffness and len(read[stiffness]) == 1:
        raise InputError(
            f"K and M are the same file {str(stiffness)!r}, which has one matrix; give M its own"
        )
    if inertia not in read:
        with naming("M"):
            read[inertia] = read_file(inertia)
    found = _named("K", stiffness, read[stiffness], wanted)
    other = _named("M", inertia, read[inertia], also_wanted)
    if found is other:
        raise InputError(f"K and M are the same matrix {found.called}")
    return found, other


def _file(role: str, given: File) -> tuple[Path, str]:
    if isinstance(given, tuple):
        if len(given) != 2 or not isinstance(given[1], str):
            raise InputTypeError(f"{role} must be a path, or (path, name of the matrix)")
        return file_path(role, given[0]), given[1].strip().upper()
    return file_path(role, given), ""


def _named(role: str, file: Path, matrices: list[Found], wanted: str) -> Found:
    """The matrix of a file by its given name, or the only one with a fitting name."""
    if wanted:
        chosen = [one for one in matrices if one.name == wanted]
    elif len(matrices) == 1:
        chosen = matrices
        other = "M" if role == "K" else "K"
        if chosen[0].name and _NAMES[other].match(chosen[0].name):
            raise spoilt(
                file, f"it holds {chosen[0].name}, given for {role}: are K and M exchanged?"
            )
    else:
        fit = [one for one in matrices if not one.unfit]
        exact = [one for one in fit if one.name == role]
        chosen = exact or [one for one in fit if _NAMES[role].match(one.name)]
    if len(chosen) != 1:
        names = ", ".join(one.name or "one without a name" for one in matrices) or "none"
        several = f"{len(chosen)} of them may be {role}" if chosen else f"none of them is {role}"
        raise spoilt(file, f"its matrices are {names}: {several}; give {role}=(file, name)")
    found = chosen[0]
    if found.unfit:
        raise spoilt(file, f"{found.name or 'its matrix'} is {found.unfit}; {role} is real, square")
    if found.size is None or found.size > len(found.values):
        raise spoilt(
            file,
            f"{found.size} rows have only {len(found.values)} entries: is the file cut short?",
        )
    return found


def given_labels(dofs: Any, stiffness: Found, inertia: Found) -> IntArray | None:
    """The labels that were given, or that stand beside CalculiX' files."""
    if dofs is None:
        beside = stiffness.file.with_suffix(".dof")
        if stiffness.file.suffix.lower() != ".sti" or not beside.exists():
            return None
        dofs = beside
    if stiffness.labels is not None or inertia.labels is not None:
        raise InputError(
            f"dofs: {stiffness.called} itself lists which dofs its rows are; leave it out"
        )
    found = read_dofs(dofs)
    if len(found) != stiffness.size:
        source = f"{str(dofs)!r}" if isinstance(dofs, (str, os.PathLike)) else "the array"
        short = source
        if stiffness.size is not None and stiffness.size < len(found):
            short = f"{str(stiffness.file)!r}"
            if stiffness.before is not None:
                end = entry_line(stiffness.file, stiffness.before, len(stiffness.values))
                short += f", which ends with line {end},"
        raise InputError(
            f"dofs: {source} has {len(found)} dofs, but {stiffness.called} {stiffness.size} rows: "
            f"is {short} cut short?"
        )
    return checked_labels(found, len(found))
