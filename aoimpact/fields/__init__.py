"""The whole body in a run: displacement and stress over time, pictures, files.

A body's motion is found again from the recorded contact forces (response.py). `results` offers it
as attributes of a run's bodies, `accuracy` takes stresses and their errors; `testrig` uses it, too.
"""

from .channel import Channel, filtered_acceleration, zero_phase
from .fields import Field
from .history import History
from .picture import Shown, enlargement, movie_path, picture, write_movie
from .response import Response, response_of, times_within
from .rows import motion_rows, place_rows, shell_gauge_rows, strain_rows_at, stress_rows_at
from .sensors import Filtered, Gauge, Probe, Reaction, gauge_at, gauge_ends, probe_at, reaction_of
