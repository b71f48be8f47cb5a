"""The paper, recomputed from its own meshes beside its printed numbers."""

from .reproduction import reproduce

__all__ = ["reproduce"]
