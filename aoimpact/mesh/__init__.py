"""Meshes: files, generators, elements and their sides, surface, points.

It knows shapes, but neither materials nor matrices. `fem` makes bodies of meshes, `linalg` takes
their nodes and corners for multigrid, `fields` their elements for stresses and pictures.
"""

from .convert import open_edges
from .curvature import SurfaceShape, surface_shape
from .elements import KINDS, THIN, ReferenceElement, cofactors, jacobians, reference_element
from .files import existing, load
from .files.abaqus import AbaqusDeck
from .files.abaqusdeck import Keyword, key, looks_like_inp
from .files.nastran import Entries, NastranDeck, nastran_nodes
from .files.nastrandeck import Table, is_nastran, read_bulk_data
from .files.nastrandeck import read_sections as read_deck
from .files.raw import RawMesh, number, rows_of
from .files.viameshio import meshio_of_all_kinds
from .generate import box_mesh, paper_sphere_mesh, sheet_mesh, sphere_mesh
from .locate import AT_NODE, nearest_line, node_at, weights_at
from .mesh import Block, Mesh, group, taken
from .read import read_for, read_mesh
from .rigidity import every_motion, motions_at, rigid_motions, unresisted_motions
from .surface import SHARP, Place, Surface, boundary, plane_of
