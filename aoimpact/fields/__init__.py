"""The whole body in a run: displacement and stress over time, pictures, files.

A body's motion is found again from the recorded contact forces (replay.py). `results` offers it as
attributes of a run's bodies, `accuracy` takes stresses and their errors; `testrig` uses it, too.
"""

from .channel import Channel, filtered_acceleration, zero_phase
from .fields import Field, Filtered, Probe
from .gauge import Gauge, gauge_ends
from .historyerror import relative_error, rest, warn_if_wrong
from .movie import MovingBody, movie_path, write_movie
from .reaction import Reaction
from .replay import response_of
from .response import (
    Response,
    motion_rows,
    place_rows,
    shell_gauge_rows,
    strain_rows_at,
    stress_rows_at,
)

__all__ = [
    "Channel",
    "Field",
    "Filtered",
    "Gauge",
    "MovingBody",
    "Probe",
    "Reaction",
    "Response",
    "filtered_acceleration",
    "gauge_ends",
    "motion_rows",
    "movie_path",
    "place_rows",
    "relative_error",
    "response_of",
    "rest",
    "shell_gauge_rows",
    "strain_rows_at",
    "stress_rows_at",
    "warn_if_wrong",
    "write_movie",
    "zero_phase",
]
