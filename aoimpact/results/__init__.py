"""A plan is run here, and what comes of it: histories, events, energies, tables, plots.

`solve` runs a plan by its solver, `RecordLength` for as long as it needs; a `Run` is what has run,
a `Result` the same of two bodies; quantities.py is the table of the numbers that sum them up. For
`accuracy`, which compares runs, and `impact`, which returns them; `batch`, `cli` and `study` print
them.
"""

from .errors import ErrorEstimate, ErrorParts, LeftOut
from .misfit import warn_of_lag, warn_of_misfit
from .motion import (
    BodyEnergy,
    BodyResult,
    ContactResult,
    Cost,
    Energy,
)
from .plausibility import warn_of_run, warning_limits
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
from .record import AS_LONG_AGAIN, RecordLength
from .result import Result
from .run import FIRST_ORDER_LIMIT, Chosen, Handle, Run
from .solve import TimeSolver, solve

__all__ = [
    "AS_LONG_AGAIN",
    "COLUMNS",
    "FIRST_ORDER_LIMIT",
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
    "ErrorParts",
    "Handle",
    "LeftOut",
    "Quantity",
    "RecordLength",
    "Result",
    "Run",
    "Speeds",
    "TimeSolver",
    "find_number",
    "like_number",
    "number_errors",
    "quantity_unit",
    "recorded",
    "solve",
    "warn_of_lag",
    "warn_of_misfit",
    "warn_of_run",
    "warning_limits",
]
