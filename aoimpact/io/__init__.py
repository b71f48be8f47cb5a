"""Files of other programs: stiffness and mass matrices, read and written.

A format a file. Within the package only `scenefile` uses it.
"""

from .matrices import load_matrices, read_matrices
from .matrix import RawMatrix
from .write import write_matrices
