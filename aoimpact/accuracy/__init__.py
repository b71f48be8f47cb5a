"""Choice of reduced models for a tolerance of the quantity of interest, and error estimates.

interest.py looks up the quantity of interest, order.py and choice.py choose its models from those
of hierarchy.py, and leftout.py estimates the errors from mesh and contact, and of histories. Used
by `impact`, `batch`, `scenefile` and `study`.
"""

from .choice import check_linear_solver, checked_rtol, choose_models
from .hierarchy import Hierarchy, alike, model_hierarchy, shared_models
from .interest import CONTROLLED, Interest, Keep, Named, keeper, quantity_of
from .leftout import compared_runs, errors_left_out
from .order import first_guess
from .sensor import Sensor
from .sensorat import AccelerationAt, ReactionAt, StrainAt, StressAt
