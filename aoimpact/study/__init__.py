"""Comparison of models of one impact, and laws from measurements."""

from .compare import Comparison, compare
from .fitlaw import LawFit, fit_law
