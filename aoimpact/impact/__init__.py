"""The public entry points: `simulate`, for an impact of two bodies, and `Scene`, for any number.

A call makes a plan from the caller's arguments, chooses models if a tolerance is given, and runs
the plan. Used by `scenefile`, `batch`, `study` and `paper`.
"""

from .foreseen import Foreseen
from .scene import LEAST_SPEED, Scene
from .twobodies import pair, plan_impact, simulate
