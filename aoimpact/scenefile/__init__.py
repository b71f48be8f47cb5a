"""Scene files: impacts, scenes and sweeps in TOML.

file.py reads a file and builds its objects. binding.py binds the tables of a file to the signatures
of functions. tables.py says which function each table calls, and reads the values of a sweep.
lines.py finds the line numbers of errors. `batch` and `cli` use this folder.
"""

from .file import SceneFile, read_scene
from .lines import Place, line_of
