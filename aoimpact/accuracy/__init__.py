"""Quantities of interest, and the models that give them to a tolerance.

quantities.py is the registry of what can be asked for; order.py finds the least models, from
hierarchy.py, that give it; leftout.py what mesh and contact add to its error. For what runs impacts
and what reads their results: `impact`, `batch`, `scenefile`, `study`.
"""

from .choice import checked_linear_solver, checked_rtol, choose_models
from .compliance import ComplianceError, best_radius, compliance_error
from .hierarchy import FixedModel, Hierarchy, Models, model_hierarchy
from .interest import impact_quantity, scene_quantity
from .keep import CONTROLLED, Keep, Named, keeper
from .leftout import LeftOutFinder
from .order import first_guess
from .quantities import COLUMNS, QUANTITIES, SCENE_CHOICES, Quantity, R, quantity_unit
from .stressat import StressAt

__all__ = [
    "COLUMNS",
    "CONTROLLED",
    "QUANTITIES",
    "SCENE_CHOICES",
    "ComplianceError",
    "FixedModel",
    "Hierarchy",
    "Keep",
    "LeftOutFinder",
    "Models",
    "Named",
    "Quantity",
    "R",
    "StressAt",
    "best_radius",
    "checked_linear_solver",
    "checked_rtol",
    "choose_models",
    "compliance_error",
    "first_guess",
    "impact_quantity",
    "keeper",
    "model_hierarchy",
    "quantity_unit",
    "scene_quantity",
]
