"""Scene files: impacts, scenes and sweeps in TOML.

schema.py has the kinds of values, names.py what a file may contain, build.py makes bodies and cases
of it, toml_lines.py finds lines for errors. For `batch` and `cli`.
"""

from .file import SceneFile, read_scene
