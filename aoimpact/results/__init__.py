"""The results of a run: histories, events, energies, tables, plots."""

from .misfit import warn_of_misfit
from .motion import BodyResult, LeftOut
from .result import Result
from .run import Chosen, Handle, Run

__all__ = ["BodyResult", "Chosen", "Handle", "LeftOut", "Result", "Run", "warn_of_misfit"]
