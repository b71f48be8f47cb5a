"""Low-velocity impact on structures: the force, its duration and the response, each with its error.

Each body, a finite-element mesh or its matrices K and M, is reduced once to an anti-oscillator (AO)
model at its contact point (E. Jacquelin, *On the rigid projectile model for low velocity impacts*).
Each impact then takes milliseconds. Units are SI. Two steel balls at 1 m/s:

>>> import aoimpact as ao
>>> ball = ao.ball(radius=0.01, material=ao.Material(E=210e9, nu=0.3, rho=7800))
>>> hit = ao.simulate(projectile=ball, target=ball, velocity=1.0)
>>> round(hit.peak_force, 1), round(1e6 * hit.contact_duration, 1)  # N, µs
(1001.5, 60.0)

Bodies
    Material, Orthotropic, FEModel, RigidMass, read_mesh, read_sections, read_matrices
    ball, rigid, wall
    Shell, Laminate, Ply; Beam, RectangularSection, CircularSection, TubularSection, BeamSection
    Mesh, box_mesh, sheet_mesh, sphere_mesh, paper_sphere_mesh; write_matrices
    Rayleigh, ModalDamping
Contact points
    FEModel.contact, ContactPoint
Models of bodies, from a rigid mass to the full finite-element model
    rigid, antioscillators, modal, interface, full
    AOModel, Body, FullModel
Contact laws
    Hertz, Linear, PowerLaw, Tabulated, UserLaw, ContactLaw
    HuntCrossley, Tsuji, KuwabaraKono, KelvinVoigt, Thornton, ElasticPlastic, YangSun; restitution
Impacts, scenes of many bodies, and time integration
    simulate, Scene; Adaptive, Newmark
    StressAt, StrainAt, AccelerationAt, ReactionAt
Results
    Result
Many impacts, and scene files
    sweep, simulate_many, read_scene
Choice of the model, and identification of the law
    compare, fit_law
Errors
    AOImpactError and InputError, InputTypeError, MeshError, SingularError, ConvergenceError;
    AOImpactWarning

Command line: ``aoimpact run file.toml``, ``aoimpact compare``, ``aoimpact paper``; see ``--help``.
Types of return values and rare errors are in the modules that create them, such as
`aoimpact.results.Run`. `ao.testrig` evaluates signals of test rigs.
``sphinx-build docs site`` makes the documentation.
"""

import sys as _sys
from importlib.machinery import PathFinder as _PathFinder
from pathlib import Path as _Path

# `PathFinder` searches only this folder. `find_spec` would also find an editable install's core.
if _PathFinder.find_spec("aoimpact._core", __path__) is None:
    # A script in the source folder imports this folder, which lacks the core, before the installed
    # package. The installed package then replaces this folder.
    _source = _Path(__file__).resolve().parents[1]
    _elsewhere = [entry for entry in _sys.path if _Path(entry).resolve() != _source]
    # An editable install is not on sys.path: a finder of setuptools finds it.
    _found = (finder.find_spec("aoimpact", _elsewhere) for finder in _sys.meta_path)
    _installed = next(filter(None, _found), None)
    if _installed and _installed.origin and _installed.submodule_search_locations:
        __file__, __path__ = _installed.origin, list(_installed.submodule_search_locations)
    if _PathFinder.find_spec("aoimpact._core", __path__) is None:
        raise ImportError(
            f"the compiled core is missing in {__path__[0]}: aoimpact is not installed for "
            f"{_sys.executable}; install it (pip install . in the source folder), and run the "
            "script by the Python of that environment (.venv/bin/python)"
        )

import lazy_loader as _lazy_loader  # last: the message above explains if it is missing

# The public names are listed in __init__.pyi; each is imported at its first use.
_find, __dir__, __all__ = _lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    from .base import spelled

    found = _find(name)
    globals()[name] = found = spelled(found, __name__) if callable(found) else found
    return found


__version__ = "0.1.0"
