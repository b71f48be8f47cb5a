"""The whole body in a run: displacement and stress over time, pictures, files.

A body's motion is found again from the recorded contact forces (replay.py). `results` offers it as
attributes of a run's bodies, `accuracy` takes stresses and their errors; `testrig` uses it, too.
"""

from .fields import Field, Probe
from .historyerror import relative_error, rest, warn_if_wrong
from .movie import MovingBody, movie_path, write_movie
from .replay import response_of
from .response import Response, stress_rows_at

__all__ = [
    "Field",
    "MovingBody",
    "Probe",
    "Response",
    "movie_path",
    "relative_error",
    "response_of",
    "rest",
    "stress_rows_at",
    "warn_if_wrong",
    "write_movie",
]
