"""A scene as the integrators take it: bodies, contacts, loads, and rest under load."""

from .bodies import FullPlayer, Player, StarPlayer, player
from .plan import Drift, Joint, Load, Plan, normal_gap
from .rows import BODY_ROWS, CONTACT_ROWS, PORT_ROWS
from .stepped import Equations, SteppedBody

__all__ = [
    "BODY_ROWS",
    "CONTACT_ROWS",
    "PORT_ROWS",
    "Drift",
    "Equations",
    "FullPlayer",
    "Joint",
    "Load",
    "Plan",
    "Player",
    "StarPlayer",
    "SteppedBody",
    "normal_gap",
    "player",
]
