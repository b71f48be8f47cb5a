"""The public verbs: `simulate`, an impact of two bodies, and `Scene`, of any number.

They turn what a caller gives into a plan, and have models chosen where a tolerance is given. For
`scenefile`, `batch`, `study` and `paper`.
"""

from .checks import checked_duration
from .defaults import contact_width, fitted_pair, meeting
from .scene import Scene, SceneCase
from .simulate import checked_numbers, left_out_law, plan_impact, simulate

__all__ = [
    "Scene",
    "SceneCase",
    "checked_duration",
    "checked_numbers",
    "contact_width",
    "fitted_pair",
    "left_out_law",
    "meeting",
    "plan_impact",
    "simulate",
]
