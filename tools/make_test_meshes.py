"""Make tests/meshes: a box of 2 x 1.5 x 1 m in 2 x 2 x 2 bricks, with Gmsh's numbering of nodes.

Needs gmsh, which the package itself does not: python tools/make_test_meshes.py
"""

from __future__ import annotations

from contextlib import chdir
from pathlib import Path

import gmsh

TARGET = Path(__file__).parents[1] / "tests" / "meshes"

# File, kind of element, version of the .msh format (without effect on other formats).
FILES = (
    ("hexahedron.inp", "hexahedron", 4.1),
    ("hexahedron20_v4.msh", "hexahedron20", 4.1),
    ("hexahedron27_v2.msh", "hexahedron27", 2.2),
    ("tetra10_v4.msh", "tetra10", 4.1),
    ("wedge_v2.msh", "wedge", 2.2),
)


def make_box(kind: str) -> None:
    """Mesh the box; name the body, its base and its origin, and leave the top's group unnamed."""
    gmsh.clear()
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", int(kind == "hexahedron20"))
    bricks = kind.startswith("hexahedron")
    geo = gmsh.model.geo
    origin = geo.addPoint(0, 0, 0)
    line = geo.extrude([(0, origin)], 2, 0, 0, numElements=[2], recombine=True)
    base = geo.extrude([line[1]], 0, 1.5, 0, numElements=[2], recombine=bricks)
    layers = geo.extrude([base[1]], 0, 0, 1, numElements=[2], recombine=bricks or kind == "wedge")
    geo.synchronize()
    gmsh.model.addPhysicalGroup(3, [layers[1][1]], name="body")
    gmsh.model.addPhysicalGroup(2, [base[1][1]], name="base")
    gmsh.model.addPhysicalGroup(0, [origin], name="origin")
    gmsh.model.addPhysicalGroup(2, [layers[0][1]])
    gmsh.model.mesh.generate(3)
    if kind in ("tetra10", "hexahedron20", "hexahedron27"):
        gmsh.model.mesh.setOrder(2)


def main() -> None:
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    for name, kind, version in FILES:
        make_box(kind)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        with chdir(TARGET):  # Gmsh writes the path it is given into .inp files
            gmsh.write(name)
    gmsh.finalize()


if __name__ == "__main__":
    main()
