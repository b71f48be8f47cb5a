"""Quantities of test rigs: filtered signals, hammer tests, drop-weight energies, shock spectra.

Measured signals and simulated impacts are treated alike: each is first a `Signal`. Public as
``ao.testrig``.

>>> import aoimpact as ao
>>> t = [0.0, 1e-3, 2e-3]
>>> ao.testrig.Signal(t, [0.0, 400.0, 0.0])
Signal(force, 3 samples at 1000 Hz, largest 400 N)
"""

from .. import base
from .dropweight import DropWeight, Point, drop_weight
from .hammer import MeasuredResponse, frf
from .shock import ShockSpectrum, shock_spectrum
from .signal import Signal, read_signal

__all__ = [
    "DropWeight",
    "MeasuredResponse",
    "Point",
    "ShockSpectrum",
    "Signal",
    "drop_weight",
    "frf",
    "read_signal",
    "shock_spectrum",
]

globals().update({name: base.spelled(globals()[name], __name__) for name in __all__})
