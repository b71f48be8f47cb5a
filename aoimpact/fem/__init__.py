"""Finite-element models of bodies, and where they are touched.

Material, supports, assembly, damping; the contact point with its weights b and its patch; the
static mode. For all folders above that hold a body: `laws` takes patches and surfaces from here,
`reduction` K, M and b.
"""

from .assembly import stiffness_mass
from .attached import RigidMass
from .audit import Audit, audited
from .beams import Beam, BeamSection, CircularSection, RectangularSection, TubularSection
from .compliance import ContactCompliance
from .composition import AnyMaterial, Materials, OneMaterial, thickness_of_cells, thin_groups
from .contact import (
    SHIFT_TIMES_DURATION,
    ContactPoint,
    contact_point,
    contact_within,
    own_contact_time,
)
from .contactsurface import ContactSurface
from .contacttime import (
    fitted_shifts,
    highest_shift,
    near_static,
    refuse_massless,
    shortest_contact_time,
    slow_shift,
)
from .damping import Damping, ModalDamping, Rayleigh, damping_or_none
from .extraction import Extraction, split
from .frequencyresponse import FrequencyResponse
from .grounding import Grounding, VirtualMotion
from .halfspace import AnisotropicHalfSpace, HalfSpace, IsotropicHalfSpace
from .labels import checked_labels
from .laminate import Laminate, Layers, Ply, Shell
from .layer import layer_compliance, layer_compliance_of, mesh_compliance
from .material import SIX, Material, warn_of_units
from .model import FEModel
from .orthotropic import Orthotropic, Solid
from .patch import Patch, spread
from .shearedhalfspace import ShearedHalfSpace
from .statics import (
    StaticMode,
    centre_of,
    displacement,
    moves_rigidly,
    refuse_mechanism,
    static_mode,
    whole_motion,
)
from .stress import Strain, Stress, compliances, gauss_stress, nodal_stress
from .stresserror import energy_error, missing_energy
from .stressrows import (
    Layer,
    StressRows,
    beam_von_mises,
    body_stress_rows,
    checked_layer,
    corner_stress,
)
from .supports import selected_nodes
from .thinextraction import ThinExtraction
from .touch import edge_length, motion_between, to_nodes
