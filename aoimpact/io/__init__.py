"""Files of other programs: meshes, sections and matrices, a format a file.

`read_mesh` makes a mesh of the nodes, cells and groups that a reader finds (`RawMesh`), and
`read_sections` and `read_matrices` take the rest of the same files. Nothing in the core imports
this folder, but for `FEModel.from_mesh`, which takes the path of a mesh.
"""

from .matrices import load_matrices, read_matrices
from .raw import RawMatrix
from .read import load, paper_sphere_mesh, read_for, read_mesh, read_sections
from .write import write_matrices
