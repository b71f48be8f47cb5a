"""Low-velocity impact on structures by anti-oscillator models."""

from importlib.metadata import version as _version
from importlib.util import find_spec as _find_spec

if _find_spec("aoimpact._core") is None:  # the source folder, seen before the installed package
    raise ImportError(
        f"the compiled core is missing in {__path__[0]}: this is the source folder of aoimpact; "
        "install it (pip install .) and run from another folder, or use the command 'aoimpact'"
    )

from .adaptive import Adaptive
from .compare import compare
from .comparison import Comparison
from .contact import ContactPoint
from .damping import ModalDamping, Rayleigh
from .errors import (
    AOImpactError,
    AOImpactWarning,
    ConvergenceError,
    InputError,
    InputTypeError,
    MemoryLimitError,
    MeshError,
    MissingPackageError,
    SceneFileError,
    SingularError,
    WorkerError,
)
from .fem import FEModel
from .generate import box_mesh, paper_sphere_mesh, sphere_mesh
from .halfspace import PatchCheck, check_patch
from .interface import InterfaceModel, interface
from .krylov import KrylovSpace
from .laws import (
    ContactLaw,
    Flores,
    Gonthier,
    HerbertMcWhannell,
    Hertz,
    HuntCrossley,
    KelvinVoigt,
    KuwabaraKono,
    LankaraniNikravesh,
    LeeWang,
    Linear,
    PowerLaw,
    Tabulated,
    Thornton,
    Tsuji,
    UserLaw,
)
from .many import iterate_many, simulate_many
from .material import Material
from .mesh import Mesh, read_mesh
from .modes import ModalModel, modal
from .newmark import Newmark
from .patch import Patch
from .reduction import antioscillators
from .restitution import restitution
from .result import Result
from .run import Handle, Run
from .scene import Scene
from .scenefile import SceneFile, read_scene
from .simulate import simulate
from .star import AOModel, rigid
from .study import WorkPrecision, work_precision
from .sweep import sweep
from .sweep_table import SweepTable

__version__ = _version("aoimpact")

__all__ = [
    "AOImpactError",
    "AOImpactWarning",
    "AOModel",
    "Adaptive",
    "Comparison",
    "ContactLaw",
    "ContactPoint",
    "ConvergenceError",
    "FEModel",
    "Flores",
    "Gonthier",
    "Handle",
    "HerbertMcWhannell",
    "Hertz",
    "HuntCrossley",
    "InputError",
    "InputTypeError",
    "InterfaceModel",
    "KelvinVoigt",
    "KrylovSpace",
    "KuwabaraKono",
    "LankaraniNikravesh",
    "LeeWang",
    "Linear",
    "Material",
    "MemoryLimitError",
    "Mesh",
    "MeshError",
    "MissingPackageError",
    "ModalDamping",
    "ModalModel",
    "Newmark",
    "Patch",
    "PatchCheck",
    "PowerLaw",
    "Rayleigh",
    "Result",
    "Run",
    "Scene",
    "SceneFile",
    "SceneFileError",
    "SingularError",
    "SweepTable",
    "Tabulated",
    "Thornton",
    "Tsuji",
    "UserLaw",
    "WorkPrecision",
    "WorkerError",
    "antioscillators",
    "box_mesh",
    "check_patch",
    "compare",
    "interface",
    "iterate_many",
    "modal",
    "paper_sphere_mesh",
    "read_mesh",
    "read_scene",
    "restitution",
    "rigid",
    "simulate",
    "simulate_many",
    "sphere_mesh",
    "sweep",
    "work_precision",
]
