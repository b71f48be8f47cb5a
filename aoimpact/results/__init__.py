"""The results of a run: histories, events, energies, tables, plots."""

from .misfit import warn_of_lag, warn_of_misfit
from .motion import (
    LEAST_REBOUND,
    BodyEnergy,
    BodyResult,
    ContactResult,
    Cost,
    Energy,
    ErrorEstimate,
    LeftOut,
)
from .plausibility import least_said, warn_of_run
from .result import Result
from .run import Chosen, Handle, Run

__all__ = [
    "LEAST_REBOUND",
    "BodyEnergy",
    "BodyResult",
    "Chosen",
    "ContactResult",
    "Cost",
    "Energy",
    "ErrorEstimate",
    "Handle",
    "LeftOut",
    "Result",
    "Run",
    "least_said",
    "warn_of_lag",
    "warn_of_misfit",
    "warn_of_run",
]
