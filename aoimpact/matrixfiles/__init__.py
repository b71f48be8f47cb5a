"""Matrices of other programs: stiffness and mass from their files, and models written for them."""

from .read import read_matrices
from .write import write_matrices

__all__ = ["read_matrices", "write_matrices"]
