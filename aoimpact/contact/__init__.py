"""Contact of a body: contact point, functional b, patch, compliance, static mode and shifts s.

`laws` takes patches and surfaces from here, `reduction` the functional b.
"""

from .compliance import Compliance
from .extraction import DIFFERENCE, Splitting
from .halfspace import AnisotropicHalfSpace, HalfSpace, IsotropicHalfSpace, ShearedHalfSpace
from .layer import layer_compliance, layer_compliance_of, mesh_compliance
from .point import (
    SHIFT_TIMES_DURATION,
    ContactPoint,
    ContactSurface,
    contact_point,
    contact_within,
    own_contact_time,
)
from .staticmode import (
    StaticMode,
    centre_of,
    fitted_shifts,
    highest_shift,
    moves_rigidly,
    refuse_massless,
    refuse_mechanism,
    shortest_contact_time,
    slow_shift,
    static_mode,
)
from .touch import Patch, edge_length, motion_between, spread, to_nodes
