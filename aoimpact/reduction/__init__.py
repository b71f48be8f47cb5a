"""Reduced models of a body at its contact points: anti-oscillators, modes, Krylov vectors.

A scene takes a `Body`, in its natural modes (body.py), or a `FullModel`; `body_model` (full.py)
converts every argument of `simulate` to a `Body` or a `FullModel`. An `AOModel` is a body of one
port in other coordinates (star.py). Used by `scene` and all folders above it; hierarchy.py of
`accuracy` makes models of rising order.
"""

from .band import fitted_times, is_valid_for, unbalanced
from .body import Body, BodyModel, Pull, Velocity
from .finer import finer_model
from .full import FullModel, body_model, full
from .krylov import KrylovSpace, interface
from .recovery import Recovery
from .reduction import antioscillators, modal
from .star import AOModel, ball, rigid, turning, wall
