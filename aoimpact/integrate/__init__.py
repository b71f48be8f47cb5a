"""Time integration of a `scene.Scenario`, which returns a recorder of the run.

There are two methods: Newmark's rule with fixed steps, and an adaptive method to a tolerance. Their
recorders have a common interface (recorder.py). `results` runs plans with either method (solve.py);
other folders only use the settings of the methods, and `Events`.
"""

from .comparison import touch_alike
from .events import Events
from .fixed_steps import SteppedRecorder, rigid_contact_time, solve_newmark
from .motion import Motion
from .recorder import Recorder
from .settings import DRAWN, TIGHTEST, Adaptive, Newmark
from .to_tolerance import solve_adaptive
