"""Meshes, sections and matrices in files of other programs, with one module per format.

Each reader returns the nodes, cells and groups of a file as a `RawMesh`, which `read_mesh` turns
into a `Mesh`. `read_sections` and `read_matrices` read the other contents of the same files.
Outside this package only `FEModel.from_mesh` imports it, to accept the path of a mesh.
"""

from .matrices import load_matrices, read_matrices
from .raw import RawMatrix
from .read import load, paper_sphere_mesh, read_for, read_mesh, read_sections
from .write import write_matrices
