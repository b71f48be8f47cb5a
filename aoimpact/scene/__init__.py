"""The input of time integration: bodies, contacts, loads, and static equilibrium under load.

A `Scenario` is the complete plan of a run. `impact` makes the plan, also from the user's `Scene`,
`integrate` runs it, and `results` reads it.
"""

from .contact import (
    Contact,
    Friction,
    Load,
    extraction_of,
)
from .rows import RecordLayout
from .scenario import Oblique, Scenario
from .stepped import Equations, SteppedBody
