"""Studies of one impact: speed against error of the solvers, and error of the models.

Nothing but `cli` uses it.
"""

from .compare import compare
from .comparison import Comparison
from .scenes import SCENES, report
from .speed import work_precision
from .table import WorkPrecision

__all__ = ["SCENES", "Comparison", "WorkPrecision", "compare", "report", "work_precision"]
