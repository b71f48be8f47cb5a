"""Quantities of interest, and the models that give them to a tolerance.

For what runs impacts and what reads their results: `impact`, `batch`, `scenefile`, `study`.
"""

from .choice import checked_linear_solver, choose_models
from .hierarchy import Ladder, Models, ladder
from .interest import impact_quantity, scene_quantity
from .keep import Keep, Named, keeper
from .order import first_guess
from .quantities import COLUMNS, QUANTITIES, SCENE_CHOICES, quantity_unit

__all__ = [
    "COLUMNS",
    "QUANTITIES",
    "SCENE_CHOICES",
    "Keep",
    "Ladder",
    "Models",
    "Named",
    "checked_linear_solver",
    "choose_models",
    "first_guess",
    "impact_quantity",
    "keeper",
    "ladder",
    "quantity_unit",
    "scene_quantity",
]
