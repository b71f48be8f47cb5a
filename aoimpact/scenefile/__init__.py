"""Scene files: impacts and scenes written down in TOML."""

from .file import SceneFile, read_scene

__all__ = ["SceneFile", "read_scene"]
