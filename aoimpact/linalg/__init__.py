"""Linear algebra of K and K + s²M: linear solvers behind one interface, and eigenpairs.

`method.Method` describes the cost and capabilities of a method; solvers.py chooses among the
methods. This folder knows matrices and the coordinates of their rows, but no bodies.
"""

from .blocks import ENTRIES_AT_ONCE, rows_of
from .matrices import (
    LARGEST,
    check_mass,
    check_stiffness,
    core_rows,
    sound_matrix,
    symmetric_pair,
    with_int32,
)
from .method import ROUGH
from .pencil import Pencil
from .rigidity import m_orthonormal, unresisted_motions
from .solvers import (
    FEW_SOLUTIONS,
    METHODS,
    SOLVERS,
    LinearSolver,
    Solver,
    checked_solver,
    linear_solver,
)
from .spectra import (
    DENSE_DOFS,
    DENSE_MOST,
    dense_modes,
    lowest,
    null_space,
    shifted,
    warn_of_rounding,
)
from .superlu import Factorization, factorize
from .twolevel import two_level
