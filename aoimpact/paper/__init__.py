"""Results of the paper, recomputed with its own meshes and shown beside its printed numbers.

The code uses the public names of the package, as a user would. Only `cli` imports it.
"""

from .reproduction import reproduce
