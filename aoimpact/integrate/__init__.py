"""Integration in time: Newmark's rule with fixed steps, and the adaptive method to a tolerance."""

from .adaptive import TIGHTEST, Adaptive, Track
from .events import Eventful, Events, find_events, find_impulse, find_peak
from .fixed_steps import Recorded, rigid_contact_time, solve_newmark
from .newmark import Newmark, Record
from .recorder import Recorder
from .to_tolerance import Sampled, solve_adaptive

__all__ = [
    "TIGHTEST",
    "Adaptive",
    "Eventful",
    "Events",
    "Newmark",
    "Record",
    "Recorded",
    "Recorder",
    "Sampled",
    "Track",
    "find_events",
    "find_impulse",
    "find_peak",
    "rigid_contact_time",
    "solve_adaptive",
    "solve_newmark",
]
