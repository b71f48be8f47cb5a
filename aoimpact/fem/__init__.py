"""Finite-element models of bodies: material, supports, assembly, damping and stress.

Every folder that works on a body imports from here; `contact` takes K, M and the mesh.
"""

from .assembly import stiffness_mass, thin_stiffness_mass
from .audit import Audit, audited
from .beams import (
    Beam,
    BeamSection,
    CircularSection,
    RectangularSection,
    TubularSection,
    beam_motion,
)
from .composition import (
    AnyMaterial,
    Materials,
    OneMaterial,
    Piece,
    each_of,
    material_of,
    pieces,
    taken_material,
    thickness_of_cells,
    thin_groups,
)
from .damping import Damping, ModalDamping, Rayleigh, damping_or_none
from .frequencyresponse import FrequencyResponse
from .labels import checked_labels, label_of, labelled_rows, nodes_by_number
from .laminate import Laminate, Layers, Ply, Shell
from .material import PLACES, SAME, SIX, Material, Orthotropic, Solid, warn_of_units
from .model import FEModel
from .shells import FOLD, element_frames, linked, nodal_normals, rigid_ends
from .statics import Grounding, VirtualMotion, displacement, near_static, whole_motion
from .stress import Strain, Stress, compliances, gauss_stress, hooke, nodal_stress
from .stressrows import (
    Layer,
    StressRows,
    beam_von_mises,
    body_stress_rows,
    checked_layer,
)
from .supports import RigidMass, selected_nodes
