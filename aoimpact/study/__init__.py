"""Comparison of models of one impact, and laws from measurements."""

from .compare import compare
from .comparison import Comparison
from .fitlaw import LawFit, fit_law
