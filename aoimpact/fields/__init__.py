"""The whole body in a run: displacement and stress over time, pictures, files.

A body's motion is found again from the recorded contact forces (replay.py). `results` offers it as
attributes of a run's bodies, `accuracy` takes stresses and their errors; `testrig` uses it, too.
"""

from .channel import Channel, filtered_acceleration, zero_phase
from .fields import Field, Filtered, Probe
from .gauge import Gauge, gauge_ends
from .historyerror import relative_error, rest, warn_if_wrong
from .picture import Picture, Shown, enlargement, movie_path
from .reaction import Reaction
from .replay import response_of
from .response import (
    Response,
    motion_rows,
    place_rows,
    shell_gauge_rows,
    strain_rows_at,
    stress_rows_at,
    times_within,
)
