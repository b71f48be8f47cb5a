"""Scene files: impacts, scenes and sweeps in TOML.

binding.py binds tables to signatures, tables.py has the function that each table calls, by its
public name, and the values of a sweep and their places, lines.py the lines for errors.
For `batch` and `cli`.
"""

from .file import SceneFile, read_scene
from .lines import Place, line_of
