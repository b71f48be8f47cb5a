"""Integration in time: a `scene.Scenario` goes in, a recorder comes out.

Newmark's rule with fixed steps, and the adaptive method to a tolerance. Both recorders have one
interface (recorder.py). `results` runs plans by them (solve.py); other
folders take the solvers' settings and `Events` from here.
"""

from .comparison import touch_alike
from .events import Events
from .fixed_steps import SteppedRecorder, rigid_contact_time, solve_newmark
from .motion import Motion
from .recorder import Recorder
from .settings import TIGHTEST, Adaptive, Newmark
from .to_tolerance import solve_adaptive
