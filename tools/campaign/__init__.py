"""Random scenes run three ways: Adaptive, Newmark extrapolated, and a formulation in SciPy.

``python -m tools.campaign scenes --seeds 0:3000 --workers 2 --out failures``
"""

import sys as _sys
from importlib.machinery import EXTENSION_SUFFIXES as _SUFFIXES
from pathlib import Path as _Path

_CLONE = _Path(__file__).resolve().parents[2]

# `python -m` finds the folder it is called in before what is installed, and so the package's
# source: where its core has not been built in place, the installed package is meant.
if not any((_CLONE / "aoimpact" / f"_core{suffix}").exists() for suffix in _SUFFIXES):
    _sys.path.sort(key=lambda path: _Path(path).resolve() == _CLONE)
