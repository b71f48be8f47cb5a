"""The models that give a quantity of interest to a tolerance, and the errors of every number.

interest.py finds the quantity that is meant in the table of `results`; order.py the models,
from hierarchy.py, that give it; leftout.py the errors by mesh and contact, and of histories. For
what runs impacts and what reads their results: `impact`, `batch`, `scenefile`, `study`.
"""

from .choice import check_linear_solver, checked_rtol, choose_models
from .hierarchy import Hierarchy, alike, model_hierarchy, shared_models
from .interest import CONTROLLED, Interest, Keep, Named, keeper, quantity_of
from .leftout import compared_runs, errors_left_out
from .order import first_guess
from .sensor import Sensor
from .sensorat import AccelerationAt, ReactionAt, StrainAt, StressAt
