"""Studies of one impact: speed against error, and models beside each other."""

from .compare import compare
from .comparison import Comparison
from .scenes import SCENES, report
from .table import WorkPrecision
from .work_precision import work_precision

__all__ = ["SCENES", "Comparison", "WorkPrecision", "compare", "report", "work_precision"]
