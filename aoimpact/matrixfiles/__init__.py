"""Matrices of other programs: stiffness and mass from their files, and models written for them.

A format a file, named in formats.py. Public; within the package only `scenefile` uses it.
"""

from .read import read_matrices
from .write import write_matrices
