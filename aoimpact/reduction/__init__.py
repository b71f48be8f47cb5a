"""Reduced models of a body at its contact: anti-oscillators, modes, several places.

A scene takes a `Body`, in its natural modes (body.py), or a `FullModel`; `body_model` (full.py)
says which of them each thing that `simulate` takes stands for. An `AOModel` is a body of one port
in other coordinates (star.py). For `scene` and all folders above it; `accuracy` asks for models of
rising order (hierarchy.py there).
"""

from .band import fitted_times, is_valid_for, unbalanced
from .body import Body, BodyModel, Pull, Velocity
from .finer import finer_model
from .full import FullModel, body_model, full
from .krylov import KrylovSpace, interface
from .recovery import PACE, Recovery
from .reduction import antioscillators, modal
from .star import AOModel, ball, rigid, turning, wall
