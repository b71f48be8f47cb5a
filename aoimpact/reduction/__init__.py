"""Reduced models of a body at its contact: anti-oscillators, modes, several places.

Every model of a body derives from `BodyModel` (bodymodel.py). body.py says which model each
thing that `simulate` takes stands for; modalbody.py finds its modes, which the core steps. For
`scene` and all folders above it; `accuracy` asks for models of rising order (hierarchy.py there).
"""

from .body import body_model
from .bodymodel import BodyModel, ReducedModel
from .coordinates import GeneralizedCoordinates
from .full import FullModel, full
from .interface import InterfaceModel, InterfaceSpace, interface
from .krylov import KrylovSpace
from .modal import modal, whole_interface
from .modalbody import ModalBody, modal_body
from .modes import ModalModel
from .recovery import PACE, SOLVED, Recovery
from .reduction import antioscillators
from .star import AOModel, ball, rigid
from .starmodes import StarModes, star_modes
from .validity import fitted_times, is_valid_for, unbalanced

__all__ = [
    "PACE",
    "SOLVED",
    "AOModel",
    "BodyModel",
    "FullModel",
    "GeneralizedCoordinates",
    "InterfaceModel",
    "InterfaceSpace",
    "KrylovSpace",
    "ModalBody",
    "ModalModel",
    "Recovery",
    "ReducedModel",
    "StarModes",
    "antioscillators",
    "ball",
    "body_model",
    "fitted_times",
    "full",
    "interface",
    "is_valid_for",
    "modal",
    "modal_body",
    "rigid",
    "star_modes",
    "unbalanced",
    "whole_interface",
]
