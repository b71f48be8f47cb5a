"""Finite-element models of bodies, and where they are touched.

Material, supports, assembly, damping; the contact point with its weights b and its patch; the
static mode. For all folders above that hold a body: `laws` takes patches and surfaces from here,
`reduction` K, M and b.
"""

from .assembly import stiffness_mass
from .attached import RigidMass
from .audit import Audit, audited
from .composition import (
    AnyMaterial,
    Layout,
    Materials,
    OneMaterial,
    Piece,
    each_of,
    layout,
    materials_of,
    pieces,
)
from .contact import PATCH_OVER_CONTACT, Body, ContactPoint, contact_point, contact_within
from .contactsurface import ContactSurface
from .contacttime import (
    SHIFT_TIMES_DURATION,
    fitted_shifts,
    highest_shift,
    near_static,
    own_contact_time,
    refuse_massless,
    shortest_contact_time,
    slow_shift,
)
from .damping import Damping, ModalDamping, Rayleigh, damping_or_none
from .extraction import Extraction, Splitting
from .frequencyresponse import FrequencyResponse
from .grounding import Grounding, VirtualMotion
from .labels import checked_labels
from .material import PAIRS, Material
from .mechanism import refuse_mechanism
from .model import FEModel
from .orthotropic import Orthotropic
from .patch import Patch
from .statics import (
    StaticMode,
    centre_of,
    displacement,
    moves_rigidly,
    static_mode,
    translates,
)
from .stress import Strain, Stress, compliances, gauss_stress, nodal_stress, stress_rows
from .stresserror import energy_error, missing_energy, stresses_around
from .supports import selected_nodes
from .touch import edge_length

__all__ = [
    "PAIRS",
    "PATCH_OVER_CONTACT",
    "SHIFT_TIMES_DURATION",
    "AnyMaterial",
    "Audit",
    "Body",
    "ContactPoint",
    "ContactSurface",
    "Damping",
    "Extraction",
    "FEModel",
    "FrequencyResponse",
    "Grounding",
    "Layout",
    "Material",
    "Materials",
    "ModalDamping",
    "OneMaterial",
    "Orthotropic",
    "Patch",
    "Piece",
    "Rayleigh",
    "RigidMass",
    "Splitting",
    "StaticMode",
    "Strain",
    "Stress",
    "VirtualMotion",
    "audited",
    "centre_of",
    "checked_labels",
    "compliances",
    "contact_point",
    "contact_within",
    "damping_or_none",
    "displacement",
    "each_of",
    "edge_length",
    "energy_error",
    "fitted_shifts",
    "gauss_stress",
    "highest_shift",
    "layout",
    "materials_of",
    "missing_energy",
    "moves_rigidly",
    "near_static",
    "nodal_stress",
    "own_contact_time",
    "pieces",
    "refuse_massless",
    "refuse_mechanism",
    "selected_nodes",
    "shortest_contact_time",
    "slow_shift",
    "static_mode",
    "stiffness_mass",
    "stress_rows",
    "stresses_around",
    "translates",
]
