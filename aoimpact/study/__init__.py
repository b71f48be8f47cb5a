"""Studies of one impact: speed against error of the solvers, error of the models, measured laws.

Nothing but `cli` uses it.
"""

from .compare import compare
from .comparison import Comparison
from .fitlaw import LawFit, fit_law
from .scenes import SCENES, report
from .speed import work_precision
from .table import WorkPrecision

__all__ = [
    "SCENES",
    "Comparison",
    "LawFit",
    "WorkPrecision",
    "compare",
    "fit_law",
    "report",
    "work_precision",
]
