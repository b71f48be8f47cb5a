"""The whole body in a run: displacement and stress over time, pictures, files."""

from .fields import Field, Probe
from .replay import response_of
from .response import Response
from .stress import Stress
from .stresserror import energy_error, missing_energy

__all__ = [
    "Field",
    "Probe",
    "Response",
    "Stress",
    "energy_error",
    "missing_energy",
    "response_of",
]
