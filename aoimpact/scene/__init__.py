"""A scene as the integrators take it: bodies, contacts, loads, and rest under load.

A `Scenario` is all that a run needs to know. `impact` makes it, `integrate` runs it, and `results`
reads it; what a user calls a `Scene` stands in `impact`.
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
