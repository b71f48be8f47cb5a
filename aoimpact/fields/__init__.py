"""The whole body in a run: displacement and stress over time, pictures, files.

A body's motion is found again from the recorded contact forces (response.py). `results` offers it
as attributes of a run's bodies, `accuracy` takes stresses and their errors; `testrig` uses it, too.
"""

from .channel import Channel, filtered_acceleration, zero_phase
from .fields import Field
from .history import History
from .picture import Shown, enlargement, movie_path, picture, write_movie
from .response import Response, response_of, times_within
from .rows import TensorRows, motion_rows, place_rows, tensor_rows
from .sensors import (
    Filtered,
    Gauge,
    Probe,
    Reaction,
    acceleration_of,
    gauge_at,
    gauge_ends,
    gauge_strain,
    probe_at,
    reaction_of,
)
from .vtu import write_series
