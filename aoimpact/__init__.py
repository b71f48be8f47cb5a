"""Low-velocity impact on structures by anti-oscillator models."""

from importlib.metadata import version as _version
from importlib.util import find_spec as _find_spec

if _find_spec("aoimpact._core") is None:  # the source folder, seen before the installed package
    raise ImportError(
        f"the compiled core is missing in {__path__[0]}: this is the source folder of aoimpact; "
        "install it (pip install .) and run from another folder, or use the command 'aoimpact'"
    )

from .adaptive import Adaptive
from .contact import ContactPoint
from .errors import (
    AOImpactError,
    AOImpactWarning,
    ConvergenceError,
    InputError,
    InputTypeError,
    MeshError,
    SingularError,
)
from .fem import FEModel
from .generate import box_mesh, paper_sphere_mesh, sphere_mesh
from .laws import ContactLaw, Hertz, Linear, PowerLaw
from .material import Material
from .mesh import Mesh, read_mesh
from .modes import ModalModel, modal
from .newmark import Newmark
from .reduction import antioscillators
from .result import Result
from .scene import simulate
from .star import AOModel, rigid
from .study import WorkPrecision, work_precision

__version__ = _version("aoimpact")

__all__ = [
    "AOImpactError",
    "AOImpactWarning",
    "AOModel",
    "Adaptive",
    "ContactLaw",
    "ContactPoint",
    "ConvergenceError",
    "FEModel",
    "Hertz",
    "InputError",
    "InputTypeError",
    "Linear",
    "Material",
    "Mesh",
    "MeshError",
    "ModalModel",
    "Newmark",
    "PowerLaw",
    "Result",
    "SingularError",
    "WorkPrecision",
    "antioscillators",
    "box_mesh",
    "modal",
    "paper_sphere_mesh",
    "read_mesh",
    "rigid",
    "simulate",
    "sphere_mesh",
    "work_precision",
]
