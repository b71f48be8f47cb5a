"""The results of a run: histories, events, quantities of interest, energies, tables, plots.

For what runs impacts or reads what came of them: all folders above.
"""

from .misfit import warn_of_lag, warn_of_misfit
from .motion import (
    BodyEnergy,
    BodyResult,
    ContactResult,
    Cost,
    Energy,
    ErrorEstimate,
    LeftOut,
)
from .plausibility import least_said, warn_of_run
from .quantities import (
    COLUMNS,
    IMPACT_CHOICES,
    QUANTITIES,
    SCENE_CHOICES,
    Quantity,
    Speeds,
    find_number,
    like_number,
    number_errors,
    quantity_unit,
    recorded,
)
from .result import Result
from .run import Chosen, Handle, Run

__all__ = [
    "COLUMNS",
    "IMPACT_CHOICES",
    "QUANTITIES",
    "SCENE_CHOICES",
    "BodyEnergy",
    "BodyResult",
    "Chosen",
    "ContactResult",
    "Cost",
    "Energy",
    "ErrorEstimate",
    "Handle",
    "LeftOut",
    "Quantity",
    "Result",
    "Run",
    "Speeds",
    "find_number",
    "least_said",
    "like_number",
    "number_errors",
    "quantity_unit",
    "recorded",
    "warn_of_lag",
    "warn_of_misfit",
    "warn_of_run",
]
