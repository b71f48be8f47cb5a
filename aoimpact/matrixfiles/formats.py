"""The formats of matrix files, each recognised by its first bytes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from .coordinate import is_market, is_triples, read_market, read_triples
from .dmig import is_dmig, read_dmig
from .found import Found, existing, spoilt
from .nodal import is_nodal, read_nodal
from .npz import is_npz, read_npz
from .op4 import is_op4, read_op4

# Bytes that are searched to recognise a format; punched files begin with other entries.
_HEAD = 2**20


@dataclass(frozen=True)
class Format:
    """A format: its recognition and its reader.

    Attributes
    ----------
    name : str
    matches : callable
        Test of the first bytes.
    read : callable
        Reader of the file, given its size; returns all of its matrices.
    """

    name: str
    matches: Callable[[bytes], bool]
    read: Callable[[Path, int], list[Found]]


FORMATS = (
    Format("Matrix Market", is_market, read_market),
    Format("SciPy .npz", is_npz, read_npz),
    Format("Nastran OP4", is_op4, read_op4),
    Format("Nastran DMIG", is_dmig, read_dmig),
    Format("CalculiX .sti and .mas, Abaqus COORDINATE", is_triples, read_triples),
    Format("Abaqus MATRIX INPUT", is_nodal, read_nodal),
)

# Marks at the beginning of other programs' files, and the alternative.
_OTHERS = {
    b"MATLAB 5.0": "of MATLAB; load it with scipy.io.loadmat and make FEModel(K=, M=)",
    b"\x89HDF": "of HDF5; read it with h5py and make FEModel(K=, M=)",
    b"\x93NUMPY": "of NumPy; load it with numpy.load and make FEModel(K=, M=)",
    b"*MATRIX,TYPE=": "of *ELEMENT MATRIX OUTPUT; write *MATRIX GENERATE and *MATRIX OUTPUT",
    b"NASTRAN FORT TAPE": "of OUTPUT2; write OUTPUT4",
}


def read_file(file: Path) -> list[Found]:
    """Return the matrices of a file, whose format is found from its content.

    Raises
    ------
    MissingFileError, InputError, MemoryLimitError
    """
    size = existing(file)
    with file.open("rb") as stream:
        head = stream.read(_HEAD)
    for one in FORMATS:
        if one.matches(head):
            return one.read(file, size)
    for mark, cure in _OTHERS.items():
        if mark in head[:4096]:
            raise spoilt(file, f"it is a file {cure}")
    known = "; ".join(one.name for one in FORMATS)
    raise spoilt(file, f"its beginning is of no format that can be read ({known})")
