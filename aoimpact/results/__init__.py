"""Running a plan, and its results: histories, events, energies, tables, plots, warnings.

`solve` runs a plan with a solver, `RecordLength` until the impact is over. The result is a `Run`,
for two bodies a `Result`. quantities.py has the table of the numbers that summarise a run,
advice.py every warning about it. `accuracy` compares runs, `impact` returns them, and `batch`,
`cli` and `study` print them.
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
