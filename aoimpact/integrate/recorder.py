"""The record of a run, from which histories are read.

Both kinds of recorders have the same attributes and methods:

solver : str
    Description of the time integration.
seconds : float
    Computing time of the run, s.
duration : float
    Length of the record, s.
times : ndarray
    Times for smooth curves, s.
marks : ndarray
    Ends of the steps, s, at which the run is most accurate.
events : tuple of Events
    Events of each contact; interpolated between the steps if the solver does not locate them.
dense : bool
    True if the record is accurate at any time, not only at the steps.
rows(times, energies)
    Record at times, shape (rows, n), which the caller may modify; for its rows see `RecordLayout`.
pushes(times)
    Contact forces with those of friction, N; see `RecordLayout.pushes`.
motion(body)
    The `Motion` of a body at any times, in the coordinates of its model.
"""

from __future__ import annotations

from .dense import DenseRecorder
from .fixed_steps import SteppedRecorder

Recorder = DenseRecorder | SteppedRecorder
