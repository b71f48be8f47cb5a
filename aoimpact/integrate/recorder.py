"""The record that a solver leaves of a run, to be read at times.

Both kinds have the same attributes and methods:

solver : str
    How time was integrated.
seconds : float
    Run time, s.
duration : float
    Length of the record, s.
times : ndarray
    Times at which to draw it, s.
marks : ndarray
    Times at which the run itself is most exact, s: the ends of its steps.
events : tuple of Events
    Events of each contact; found between the steps where the solver does not locate them.
dense : bool
    True if it can be read at any times.
rows(times, energies)
    The record at times, shape (rows, n), for the caller to write on. `RecordLayout` tells its rows
    apart.
forces(times)
    Contact forces at times, N, shape (contacts, n).
pushes(times)
    Contact forces with those of friction, N; see `RecordLayout.pushes`.
motion(body)
    The motion of a body at any times, in the coordinates of its model: a `Motion`.
"""

from __future__ import annotations

from .dense import DenseRecorder
from .fixed_steps import SteppedRecorder

Recorder = DenseRecorder | SteppedRecorder
