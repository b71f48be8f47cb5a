"""Meshes: elements and their sides, generators, surfaces, and the location of points.

This package handles geometry only, not files, materials or matrices. `io` reads meshes, `fem` makes
bodies of them, `linalg` uses nodes and corners for multigrid, `fields` uses elements for stresses
and pictures.
"""

from .convert import Solids, collapse, of_second_order, open_edges
from .curvature import SurfaceShape, surface_shape
from .elements import (
    KINDS,
    SOLIDS,
    SURFACES,
    THIN,
    ReferenceElement,
    Rule,
    cofactors,
    jacobians,
    meshio_of_all_kinds,
    reference_element,
    reference_faces,
)
from .enrichment import enriched
from .generate import GOLDEN, box_mesh, sheet_mesh, sphere_mesh
from .halving import PARTS, halved
from .locate import ON_SURFACE, nearest_line, node_at, weights_at
from .mesh import (
    AT_NODE,
    SHARP,
    Block,
    Mesh,
    checked_cells,
    gathered,
    group,
    jacobian_range,
    right_handed,
    select,
    taken,
    twins,
)
from .orient import against_neighbours, pairs, sides
from .surface import Place, Surface, boundary, plane_of
from .vectors import dot, motions_at, parted, rigid_motions, unit
