"""Tools for all folders: errors, checks of arguments, units, read-only records, tables."""

from .cells import *
from .checks import *
from .decoding import *
from .errors import *
from .memory import *
from .progress import *
from .style import *
from .threads import *
from .units import *
