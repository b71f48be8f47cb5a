"""The paper, recomputed from its own meshes beside its printed numbers.

It uses the public names of the package, as a reader would. Only `cli` uses it.
"""

from .reproduction import reproduce
