"""Low-velocity impact on structures by anti-oscillator models.

The public names stand in ``__init__.pyi``; each is imported when it is first asked for.
"""

from importlib.metadata import version as _version
from importlib.util import find_spec as _find_spec

import lazy_loader as _lazy_loader

if _find_spec("aoimpact._core") is None:  # the source folder, seen before the installed package
    raise ImportError(
        f"the compiled core is missing in {__path__[0]}: this is the source folder of aoimpact; "
        "install it (pip install .) and run from another folder, or use the command 'aoimpact'"
    )

__getattr__, __dir__, __all__ = _lazy_loader.attach_stub(__name__, __file__)

__version__ = _version("aoimpact")
