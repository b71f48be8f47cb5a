"""Scene files: impacts, scenes and sweeps in TOML.

binding.py binds the tables of a file to the signatures of functions, tables.py says which function
each table calls and reads the values of a sweep, lines.py finds the lines of errors. For `batch`
and `cli`.
"""

from .file import SceneFile, read_scene
from .lines import Place, line_of
