"""Readers and writers of meshes, sections and matrices for other programs, by file format.

Each reader returns the nodes, cells and groups of a file as a `RawMesh`, which `read_mesh` turns
into a `Mesh`. `read_sections` and `read_matrices` read the other contents of the same files.
The rest of the package does not import this folder, except `FEModel.from_mesh` for mesh paths.
"""

from .matrices import load_matrices, read_matrices
from .raw import RawMatrix
from .read import load, paper_sphere_mesh, read_for, read_mesh, read_sections
from .write import write_matrices
