"""Many impacts: workers, checkpoints, sweeps and their tables.

Plain impacts run many in one call of the core (plain.py); all others by `simulate`. For `cli`.
"""

from .checkpoint import Checkpoint, Digests
from .many import simulate_many
from .plain import ANSWERS, PLAIN_NUMBERS, plain_numbers
from .sweep import SweepTable, sweep, sweep_file
