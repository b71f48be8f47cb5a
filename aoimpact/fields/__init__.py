"""Whole bodies in a run: displacement and stress over time, sensors, pictures, files.

The motion of a body is recomputed from the recorded contact forces (response.py). `results` offers
the motion as attributes of a run's bodies. `accuracy` uses stresses and their errors, `testrig`
probes and the filter.
"""

from .channel import MOST_SAMPLES, Channel, zero_phase
from .field import Field, Shown, enlargement, write_movie, write_series
from .response import Response, response_of, times_within
from .sensors import (
    Filtered,
    Gauge,
    History,
    Measured,
    Probe,
    Reaction,
    TensorAt,
    Work,
    acceleration_of,
    errors_of,
    gauge_ends,
    gauge_strain,
    motion_rows,
    place_rows,
)
