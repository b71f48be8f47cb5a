"""Make aoimpact/data/sphere.msh, a mesh of the paper's sphere with the paper's numbers of nodes.

The paper (section 3) gives the radius, 10 mm, the order of the tetrahedra, 2, and the numbers of
nodes and elements, 1053 and 602, but not the mesh. A ball with V corners, B of them on the surface,
and T elements has 2V + T + B - 3 nodes: 2V + B = 454. Elements of even size have B = 114. Gmsh made
meshes with random seeds and random element sizes, 3.74 to 3.97 mm at the surface and 2.05 to 2.7 mm
at the centre. Of those with exactly the paper's numbers, this mesh has the largest quality of its
worst element. No force, frequency or stiffness entered the choice.

Needs gmsh, which the package itself does not: python tools/make_sphere_mesh.py
"""

from __future__ import annotations

import math
from pathlib import Path

import gmsh
import numpy as np

TARGET = Path(__file__).parents[1] / "aoimpact" / "data" / "sphere.msh"
RADIUS = 10.0  # mm, the unit of lengths in Gmsh

TETRA, TETRA10, TRIANGLE6 = 4, 11, 9

# Element sizes, mm, Gmsh's 2-D algorithm, and its random seed.
AT_SURFACE, AT_CENTRE, ALGORITHM, SEED = 3.791550423049012, 2.2854801341927935, 6, 5511


def make_surface() -> None:
    """Mesh the sphere's surface, its poles at (±R, 0, 0)."""
    gmsh.clear()
    gmsh.option.setNumber("Mesh.ElementOrder", 1)
    gmsh.option.setNumber("Mesh.Algorithm", ALGORITHM)
    gmsh.option.setNumber("Mesh.RandomSeed", SEED)
    gmsh.option.setNumber("Mesh.OptimizeNetgen", 1)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
    ball = gmsh.model.occ.addSphere(0, 0, 0, RADIUS)
    gmsh.model.occ.rotate([(3, ball)], 0, 0, 0, 0, 1, 0, math.pi / 2)
    gmsh.model.occ.synchronize()
    size = gmsh.model.mesh.field.add("MathEval")
    slope = (AT_SURFACE - AT_CENTRE) / RADIUS**2
    gmsh.model.mesh.field.setString(size, "F", f"{AT_CENTRE}+{slope}*(x*x+y*y+z*z)")
    gmsh.model.mesh.field.setAsBackgroundMesh(size)
    gmsh.model.mesh.generate(2)


def make_volume() -> tuple[int, int, float]:
    """Fill the surface; return corners, elements, and the quality of the worst element."""
    gmsh.model.mesh.generate(3)
    tags, corners = gmsh.model.mesh.getElementsByType(TETRA)
    return len(np.unique(corners)), len(tags), gmsh.model.mesh.getElementQualities(tags).min()


def second_order() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Add midside nodes; return coordinates (m), tetrahedra and triangles, numbered from 0."""
    gmsh.model.mesh.setOrder(2)
    tags, places, _ = gmsh.model.mesh.getNodes(includeBoundary=True)
    places = places.reshape(-1, 3)
    tets = gmsh.model.mesh.getElementsByType(TETRA10)[1].reshape(-1, 10)
    triangles = gmsh.model.mesh.getElementsByType(TRIANGLE6)[1].reshape(-1, 6)
    used, order = np.unique(tets), np.argsort(tags)
    nodes = places[order[np.searchsorted(tags, used, sorter=order)]]
    tets, triangles = np.searchsorted(used, tets), np.searchsorted(used, triangles)
    surface = np.unique(triangles)
    # Gmsh places nodes with errors of 1e-6; here they are moved onto the exact sphere.
    nodes[surface] *= RADIUS / np.linalg.norm(nodes[surface], axis=1)[:, None]
    nodes[np.abs(nodes) < 1e-9 * RADIUS] = 0.0
    return 1e-3 * nodes, tets, triangles


def write(nodes: np.ndarray, tets: np.ndarray, triangles: np.ndarray) -> None:
    """Write the mesh in format 2.2 as text, with 13 digits."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    lines += ["$PhysicalNames", "2", '2 1 "surface"', '3 2 "body"', "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(nodes))]
    lines += [f"{i} {x:.13g} {y:.13g} {z:.13g}" for i, (x, y, z) in enumerate(nodes, 1)]
    lines += ["$EndNodes", "$Elements", str(len(triangles) + len(tets))]
    blocks = ((TRIANGLE6, 1, triangles + 1), (TETRA10, 2, tets + 1))
    rows = [(kind, group, row) for kind, group, block in blocks for row in block]
    lines += [
        f"{i} {kind} 2 {group} 1 {' '.join(map(str, row))}"
        for i, (kind, group, row) in enumerate(rows, 1)
    ]
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_text("\n".join([*lines, "$EndElements", ""]))


def main() -> None:
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    make_surface()
    corners, elements, quality = make_volume()
    nodes, tets, triangles = second_order()
    print(f"{len(nodes)} nodes, {elements} elements, {corners} corners, worst {quality:.3f}")
    write(nodes, tets, triangles)
    gmsh.finalize()


if __name__ == "__main__":
    main()
