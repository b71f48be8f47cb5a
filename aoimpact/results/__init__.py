"""A plan is run here, and its results: histories, events, energies, tables, plots, advice.

`solve` runs a plan by its solver, `RecordLength` for as long as it needs; a `Run` is the result, a
`Result` the same of two bodies; quantities.py is the table of the numbers that sum them up, and
advice.py has every warning about a run. For `accuracy`, which compares runs, and `impact`, which
returns them; `batch`, `cli` and `study` print them.
"""

from .advice import (
    Advice,
    limits,
    outgrown,
    warn_of_bodies,
    warn_of_exchange,
    warn_of_misfit,
    warn_of_run,
    warning_limits,
)
from .errors import Chosen, ErrorEstimate, ErrorParts, LeftOut
from .plot import shown_bodies
from .quantities import (
    COLUMNS,
    IMPACT_CHOICES,
    QUANTITIES,
    SCENE_CHOICES,
    Quantity,
    Speeds,
    look_up,
    number_errors,
    quantity_unit,
    recorded,
)
from .run import BodyEnergy, BodyResult, ContactResult, Cost, Energy, Handle, Result, Run
from .solve import RecordLength, TimeSolver, solve
from .table import ROLES
