"""A scene as the integrators take it: bodies, contacts, loads, and rest under load.

A `Plan` is all that a run needs to know. `impact` makes plans, `integrate` runs them, and `results`
reads them; what a user calls a `Scene` stands in `impact`.
"""

from .bodies import coordinates, stepped
from .contact import (
    Contact,
    FreeMotion,
    Load,
    extraction_of,
    law_of_models,
    normal_gap,
)
from .plan import Plan, reduced_mass
from .rows import RecordLayout
from .stepped import Equations, SteppedBody

__all__ = [
    "Contact",
    "Equations",
    "FreeMotion",
    "Load",
    "Plan",
    "RecordLayout",
    "SteppedBody",
    "coordinates",
    "extraction_of",
    "law_of_models",
    "normal_gap",
    "reduced_mass",
    "stepped",
]
