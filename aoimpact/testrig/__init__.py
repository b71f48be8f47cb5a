"""Quantities of test rigs: filtered signals, a load cell, drop-weight energies, shock spectra.

Measured signals and simulated impacts are treated alike: each is first a `Signal`. Public under
this name, ``from aoimpact import testrig``; it reads results, and nothing in the package uses it.
"""

from .dropweight import DropWeight, Point, drop_weight
from .loadcell import LoadCell
from .readsignal import read_signal
from .shock import ShockSpectrum, shock_spectrum
from .signal import Signal

__all__ = [
    "DropWeight",
    "LoadCell",
    "Point",
    "ShockSpectrum",
    "Signal",
    "drop_weight",
    "read_signal",
    "shock_spectrum",
]
