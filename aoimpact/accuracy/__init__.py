"""The models that give a quantity of interest to a tolerance, and the errors of every number.

interest.py finds the quantity that is meant in the table of `results`; order.py the models,
from hierarchy.py, that give it; leftout.py what mesh and contact add to its error. For what runs
impacts and what reads their results: `impact`, `batch`, `scenefile`, `study`.
"""

from .choice import checked_linear_solver, checked_rtol, choose_models
from .finer import finer_run
from .hierarchy import FixedModel, Hierarchy, Models, model_hierarchy
from .interest import impact_quantity, scene_quantity
from .keep import CONTROLLED, Keep, Named, keeper
from .leftout import LeftOutFinder
from .order import first_guess
from .stressat import StressAt

__all__ = [
    "CONTROLLED",
    "FixedModel",
    "Hierarchy",
    "Keep",
    "LeftOutFinder",
    "Models",
    "Named",
    "StressAt",
    "checked_linear_solver",
    "checked_rtol",
    "choose_models",
    "finer_run",
    "first_guess",
    "impact_quantity",
    "keeper",
    "model_hierarchy",
    "scene_quantity",
]
