"""Finite-element models: material, supports, assembly, damping, and the contact functional."""

from .assembly import stiffness_mass
from .audit import Audit, audited
from .contact import Body, ContactPoint, contact_at, contact_point, contact_within
from .contactsurface import ContactSurface
from .damping import FASTEST, Damping, ModalDamping, Rayleigh, damping_or_none
from .halfspace import PatchCheck, check_patch, image_field
from .labels import checked_labels
from .material import Material
from .mechanism import refuse_mechanism
from .model import FEModel
from .patch import Patch
from .statics import (
    StaticMode,
    centre_of,
    displacement,
    moves_rigidly,
    static_mode,
    translates,
)
from .supports import selected_nodes
from .touch import Room, edge_length, room

__all__ = [
    "FASTEST",
    "Audit",
    "Body",
    "ContactPoint",
    "ContactSurface",
    "Damping",
    "FEModel",
    "Material",
    "ModalDamping",
    "Patch",
    "PatchCheck",
    "Rayleigh",
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
    "edge_length",
    "image_field",
    "moves_rigidly",
    "refuse_mechanism",
    "room",
    "selected_nodes",
    "static_mode",
    "stiffness_mass",
    "translates",
]
