"""Many impacts: workers, checkpoints, sweeps and their tables.

One call of the core runs many plain impacts (plain.py); `simulate` runs all other impacts. `cli`
uses this folder.
"""

from .checkpoint import Checkpoint, Digests
from .many import simulate_many
from .plain import ANSWERS, PLAIN_NUMBERS, plain_numbers
from .sweep import SweepTable, sweep, sweep_file
