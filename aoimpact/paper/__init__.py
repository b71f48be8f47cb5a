"""The paper, recomputed from its own meshes beside its printed numbers.

It uses the package as a reader of the paper would. Only `cli` uses it.
"""

from .reproduction import reproduce
