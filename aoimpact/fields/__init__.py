"""The whole body in a run: displacement and stress over time, pictures, files."""

from .fields import Field, Probe
from .movie import MovingBody, movie_path, write_movie
from .replay import response_of
from .response import Response, stress_rows_at
from .stress import Stress
from .stresserror import energy_error, missing_energy, stresses_around

__all__ = [
    "Field",
    "MovingBody",
    "Probe",
    "Response",
    "Stress",
    "energy_error",
    "missing_energy",
    "movie_path",
    "response_of",
    "stress_rows_at",
    "stresses_around",
    "write_movie",
]
