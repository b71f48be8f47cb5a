"""Reduced models of a body at its contact: anti-oscillators, modes, several places.

Every model of a body derives from `BodyModel` (bodymodel.py), and is a body of a scene as it is.
full.py (`body_model`) says which model each thing that `simulate` takes stands for; `modal` of a
model has its modes with their ports (modalbody.py), which the core steps. For `scene` and all
folders above it; `accuracy` asks for models of rising order (hierarchy.py there).
"""

from .bodymodel import BodyModel, ReducedModel
from .finer import finer_model
from .full import FullModel, body_model, full
from .interface import InterfaceModel, InterfaceSpace, interface
from .krylov import KrylovSpace
from .modalbody import ModalBody, Pull, Velocity
from .modes import ModalModel, modal
from .recovery import PACE, SOLVED, GeneralizedCoordinates, Recovery
from .reduction import antioscillators
from .softer import softer_model
from .star import AOModel, TurningBody, ball, rigid, wall
from .validity import fitted_times, is_valid_for
