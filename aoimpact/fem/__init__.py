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
from .contact import Body, ContactPoint, contact_at, contact_point, contact_within
from .contactsurface import ContactSurface
from .damping import Damping, ModalDamping, Rayleigh, damping_or_none
from .halfspace import PatchCheck, check_patch, image_field
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
    near_static,
    static_mode,
    translates,
)
from .supports import selected_nodes
from .touch import Room, edge_length, room

__all__ = [
    "PAIRS",
    "AnyMaterial",
    "Audit",
    "Body",
    "ContactPoint",
    "ContactSurface",
    "Damping",
    "FEModel",
    "Layout",
    "Material",
    "Materials",
    "ModalDamping",
    "OneMaterial",
    "Orthotropic",
    "Patch",
    "PatchCheck",
    "Piece",
    "Rayleigh",
    "RigidMass",
    "Room",
    "StaticMode",
    "audited",
    "centre_of",
    "check_patch",
    "checked_labels",
    "contact_at",
    "contact_point",
    "contact_within",
    "damping_or_none",
    "displacement",
    "each_of",
    "edge_length",
    "image_field",
    "layout",
    "materials_of",
    "moves_rigidly",
    "near_static",
    "pieces",
    "refuse_mechanism",
    "room",
    "selected_nodes",
    "static_mode",
    "stiffness_mass",
    "translates",
]
