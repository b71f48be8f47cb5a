"""Meshes of solid elements: files, generators, elements and their sides, surface, points."""

from .curvature import SurfaceShape, surface_shape
from .elements import KINDS, ReferenceElement, cofactors, jacobians, reference_element
from .faces import reference_faces
from .generate import box_mesh, paper_sphere_mesh, sphere_mesh
from .locate import node_at, weights_at
from .mesh import Mesh, read_mesh
from .rigidity import every_motion, motions_at, rigid_motions, unresisted_motions
from .surface import SHARP, Place, Surface, boundary, plane_of

__all__ = [
    "KINDS",
    "SHARP",
    "Mesh",
    "Place",
    "ReferenceElement",
    "Surface",
    "SurfaceShape",
    "boundary",
    "box_mesh",
    "cofactors",
    "every_motion",
    "jacobians",
    "motions_at",
    "node_at",
    "paper_sphere_mesh",
    "plane_of",
    "read_mesh",
    "reference_element",
    "reference_faces",
    "rigid_motions",
    "sphere_mesh",
    "surface_shape",
    "unresisted_motions",
    "weights_at",
]
