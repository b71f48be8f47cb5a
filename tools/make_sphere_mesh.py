"""Make aoimpact/data/sphere.msh, a mesh of the paper's sphere with the paper's counts.

The paper (section 3) gives the radius, 10 mm, the order of the tetrahedra, 2, and the numbers of
nodes and elements, 1053 and 602, but not the mesh. With V corners, B of them on the surface,
and T elements, a ball has 2V + T + B - 3 nodes: 2V + B = 454. Gmsh is asked for meshes of random
fineness until some have exactly these counts; of those the one with the best worst element stays.
No force, frequency or stiffness enters the choice.

Needs gmsh, which the package itself does not:

    python tools/make_sphere_mesh.py              # the mesh that was chosen
    python tools/make_sphere_mesh.py --search 600 # look for others, so many seconds
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import dataclass
from pathlib import Path

import gmsh
import numpy as np

TARGET = Path(__file__).parents[1] / "aoimpact" / "data" / "sphere.msh"
RADIUS = 10.0  # mm, while Gmsh has it
NODES, ELEMENTS = 1053, 602
SURFACE_CORNERS = 114  # about what 602 tetrahedra of even size have; it must be even

TETRA, TRIANGLE, TETRA10, TRIANGLE6 = 4, 2, 11, 9


@dataclass(frozen=True)
class Recipe:
    """What Gmsh is asked for: element sizes, mm, its 2-D algorithm, and its random seed."""

    at_surface: float
    at_centre: float
    algorithm: int
    seed: int


CHOSEN = Recipe(3.791550423049012, 2.2854801341927935, 6, 5511)


def make_surface(recipe: Recipe) -> int:
    """Mesh the sphere's surface, its poles at (±R, 0, 0); return the number of corners."""
    gmsh.clear()
    gmsh.option.setNumber("Mesh.ElementOrder", 1)
    gmsh.option.setNumber("Mesh.Algorithm", recipe.algorithm)
    gmsh.option.setNumber("Mesh.RandomSeed", recipe.seed)
    gmsh.option.setNumber("Mesh.OptimizeNetgen", 1)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
    ball = gmsh.model.occ.addSphere(0, 0, 0, RADIUS)
    gmsh.model.occ.rotate([(3, ball)], 0, 0, 0, 0, 1, 0, math.pi / 2)
    gmsh.model.occ.synchronize()
    size = gmsh.model.mesh.field.add("MathEval")
    slope = (recipe.at_surface - recipe.at_centre) / RADIUS**2
    gmsh.model.mesh.field.setString(size, "F", f"{recipe.at_centre}+{slope}*(x*x+y*y+z*z)")
    gmsh.model.mesh.field.setAsBackgroundMesh(size)
    gmsh.model.mesh.generate(2)
    return len(np.unique(gmsh.model.mesh.getElementsByType(TRIANGLE)[1]))


def make_volume() -> tuple[int, int, float]:
    """Fill the surface; return corners, elements, and the quality of the worst element."""
    gmsh.model.mesh.generate(3)
    tags, corners = gmsh.model.mesh.getElementsByType(TETRA)
    return len(np.unique(corners)), len(tags), gmsh.model.mesh.getElementQualities(tags).min()


def search(seconds: float, seed: int) -> None:
    """Print every recipe found that has the counts, with the quality of its worst element."""
    rng = np.random.default_rng(seed)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        recipe = Recipe(
            float(rng.uniform(3.74, 3.97)),
            float(rng.uniform(2.05, 2.7)),
            int(rng.choice([1, 5, 6])),
            int(rng.integers(1, 10000)),
        )
        if make_surface(recipe) != SURFACE_CORNERS:
            continue
        corners, elements, quality = make_volume()
        if (2 * corners + SURFACE_CORNERS, elements) == (NODES - ELEMENTS + 3, ELEMENTS):
            print(f"{quality:.4f} {recipe}", flush=True)


def second_order() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Add midside nodes; return coordinates (m), tetrahedra and triangles, numbered from 0."""
    gmsh.model.mesh.setOrder(2)
    tags, places, _ = gmsh.model.mesh.getNodes(includeBoundary=True)
    places = places.reshape(-1, 3)
    tets = gmsh.model.mesh.getElementsByType(TETRA10)[1].reshape(-1, 10)
    triangles = gmsh.model.mesh.getElementsByType(TRIANGLE6)[1].reshape(-1, 6)
    used = np.unique(tets)
    number = {int(tag): i for i, tag in enumerate(used)}
    row = {int(tag): i for i, tag in enumerate(tags)}
    nodes = places[[row[int(tag)] for tag in used]]
    renumber = np.vectorize(number.__getitem__)
    tets, triangles = renumber(tets), renumber(triangles)
    surface = np.unique(triangles)
    # Gmsh leaves 1e-6 of rounding; the sphere is known exactly.
    nodes[surface] *= RADIUS / np.linalg.norm(nodes[surface], axis=1)[:, None]
    nodes[np.abs(nodes) < 1e-9 * RADIUS] = 0.0
    return 1e-3 * nodes, tets, triangles


def write(nodes: np.ndarray, tets: np.ndarray, triangles: np.ndarray) -> None:
    """Write format 2.2 in text, with as many digits as matter."""
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
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--search", type=float, metavar="SECONDS")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    if arguments.search:
        search(arguments.search, arguments.seed)
    else:
        make_surface(CHOSEN)
        corners, elements, quality = make_volume()
        nodes, tets, triangles = second_order()
        print(f"{len(nodes)} nodes, {elements} elements, {corners} corners, worst {quality:.3f}")
        write(nodes, tets, triangles)
    gmsh.finalize()


if __name__ == "__main__":
    main()
