"""The public verbs: `simulate`, an impact of two bodies, and `Scene`, of any number.

They turn what a caller gives into a plan, and have models chosen where a tolerance is given. For
`scenefile`, `batch`, `study` and `paper`.
"""

from .foreseen import Foreseen
from .scene import LEAST_SPEED, Scene
from .twobodies import pair, plan_impact, simulate
