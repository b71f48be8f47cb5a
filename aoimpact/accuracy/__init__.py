"""Quantities of interest, and the models that give them to a tolerance."""

from .answer import SCENE_QUANTITIES, Answer, answer, scene_answer
from .choice import checked_linear_solver, sufficient
from .hierarchy import Ladder, Models, ladder
from .order import first_guess
from .quantities import CONTROLLED, QUANTITIES, Keep, Named, keeper, quantity_unit

__all__ = [
    "CONTROLLED",
    "QUANTITIES",
    "SCENE_QUANTITIES",
    "Answer",
    "Keep",
    "Ladder",
    "Models",
    "Named",
    "answer",
    "checked_linear_solver",
    "first_guess",
    "keeper",
    "ladder",
    "quantity_unit",
    "scene_answer",
    "sufficient",
]
