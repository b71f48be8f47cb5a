"""A scene as the integrators take it: bodies, contacts, loads, and rest under load.

A `Plan` is all that a run needs to know. `impact` makes plans, `integrate` runs them, and `results`
reads them; what a user calls a `Scene` stands in `impact`.
"""

from .bodies import stepped
from .contact import (
    Contact,
    Friction,
    Load,
    extraction_of,
    normal_gap,
)
from .plan import Oblique, Plan, reduced_mass
from .rows import RecordLayout
from .stepped import Equations, SteppedBody
