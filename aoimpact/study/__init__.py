"""Comparison of models of one impact: the cost and the error of each."""

from .compare import compare
from .comparison import Comparison

__all__ = ["Comparison", "compare"]
