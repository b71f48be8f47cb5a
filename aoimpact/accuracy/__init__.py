"""The models that give a quantity of interest to a tolerance, and the errors of every number.

interest.py finds the quantity that is meant in the table of `results`; order.py the models,
from hierarchy.py, that give it; leftout.py what mesh and contact add to its error. For what runs
impacts and what reads their results: `impact`, `batch`, `scenefile`, `study`.
"""

from .choice import checked_linear_solver, checked_rtol, choose_models, time_rule
from .finer import finer_run
from .hierarchy import (
    FixedModel,
    Hierarchy,
    KrylovHierarchy,
    Models,
    SharedPoint,
    model_hierarchy,
)
from .interest import impact_quantity, scene_quantity
from .keep import CONTROLLED, Keep, Named, keeper
from .leftout import Altered, LeftOutFinder, Met, alterations, extrapolated
from .order import first_guess, larger_orders, models_to_compare, safety_of
from .stressat import StressAt

__all__ = [
    "CONTROLLED",
    "Altered",
    "FixedModel",
    "Hierarchy",
    "Keep",
    "KrylovHierarchy",
    "LeftOutFinder",
    "Met",
    "Models",
    "Named",
    "SharedPoint",
    "StressAt",
    "alterations",
    "checked_linear_solver",
    "checked_rtol",
    "choose_models",
    "extrapolated",
    "finer_run",
    "first_guess",
    "impact_quantity",
    "keeper",
    "larger_orders",
    "model_hierarchy",
    "models_to_compare",
    "safety_of",
    "scene_quantity",
    "time_rule",
]
