"""Linear algebra of K and K + s²M: solvers behind one interface, and eigenpairs.

What a solver can do is said as data (method.py); which one is taken, in solvers.py. It knows
matrices and where their rows lie in space, no bodies. For `fem`, `reduction` and all that solves
with K and M.
"""

from .blocks import ENTRIES_AT_ONCE
from .matrices import (
    LARGEST,
    LEAST,
    check_mass,
    check_stiffness,
    core_rows,
    sound_matrix,
    symmetric_pair,
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
    EQUAL,
    dense_modes,
    lowest,
    null_space,
    shifted,
    warn_of_rounding,
)
from .superlu import Factorization, factorize
from .twolevel import two_level
