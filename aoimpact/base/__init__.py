"""Tools of every folder: errors, checks of arguments, units, read-only records, tables."""

from .arrays import *
from .cells import *
from .checks import *
from .decoding import *
from .errors import *
from .found import *
from .frozen import *
from .memory import *
from .packages import *
from .progress import *
from .style import *
from .threads import *
from .units import *
