"""Comparison of models of one impact, and fits of contact laws to measurements."""

from .compare import Comparison, compare
from .fitlaw import LawFit, fit_law
