"""A scene as the integrators take it: bodies, contacts, loads, and rest under load."""

from .bodies import FullBody, SceneBody, StarBody, scene_body
from .plan import Drift, Joint, Load, Plan, normal_gap
from .rows import BODY_ROWS, CONTACT_ROWS, PORT_ROWS
from .stepped import Equations, SteppedBody

__all__ = [
    "BODY_ROWS",
    "CONTACT_ROWS",
    "PORT_ROWS",
    "Drift",
    "Equations",
    "FullBody",
    "Joint",
    "Load",
    "Plan",
    "SceneBody",
    "StarBody",
    "SteppedBody",
    "normal_gap",
    "scene_body",
]
