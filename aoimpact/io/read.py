"""Meshes and sections from files of other programs.

Elements of the same kind are joined, and nodes that belong to no element are dropped.

The reader of a format returns a `RawMesh`. It raises a `ValueError` with the reason, or a
`MeshError` that names the file.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any, get_args

import numpy as np
import scipy

from ..base import (
    FilePath,
    FloatArray,
    InputError,
    InputTypeError,
    IntArray,
    MemoryLimitError,
    MeshError,
    MissingFileError,
    called,
    file_path,
    finite_array,
    held_warnings,
    instance,
    nearest,
    positive,
    sp,
    text,
    warn,
)
from ..fem import Layers, OneMaterial
from ..mesh import (
    KINDS,
    PARTS,
    THIN,
    Mesh,
    Solids,
    against_neighbours,
    checked_cells,
    collapse,
    gathered,
    of_second_order,
    reference_element,
    right_handed,
    select,
)
from . import abaqus, exodus, gmsh, med, nastran, viameshio, vtk
from .abaqusdeck import key, looks_like_inp
from .nastrandeck import is_nastran
from .raw import RawMesh, grouped, joined, listed, nodes_in
from .sections import Source
from .viameshio import from_meshio, is_meshio

_Reader = Callable[[Path], RawMesh]

# Number of bytes at the beginning of a file that are searched for an entry that identifies the
# format: in decks and punched files other entries may come first.
_HEAD = 2**20

# Readers by the suffix of the file's name in lower case; meshio reads files with other suffixes.
_READERS: dict[str, _Reader] = {
    **dict.fromkeys((".bdf", ".nas"), nastran.read),
    **dict.fromkeys((".e", ".ex2", ".exo", ".g", ".gen"), exodus.read),
    ".inp": abaqus.read,
    ".med": med.read,
    ".vtu": vtk.read,
}

# For each second-order kind of surface or line element: the first-order kind that it is split into,
# and the nodes of each part.
_SPLIT = {raised: (kind, parts) for kind, (raised, parts) in PARTS.items()}

# Kinds of elements that are turned over where neighbours have opposite normals.
_FLAT = ("quad", "triangle")


def read_mesh(
    source: FilePath | Any,
    *,
    scale: float = 1.0,
    part: str | Sequence[str] | None = None,
    order: int | None = None,
) -> Mesh:
    """Return the mesh in a file, or refuse the file if it cannot be read completely.

    Files of Abaqus and CalculiX (.inp), Exodus, Gmsh (2.2 and 4.1), MED, Nastran and VTK (.vtk,
    .vtu) are read completely, or refused. Meshes of AVS, DOLFIN, Medit, PERMAS, SU2, UGRID and XDMF
    are read by meshio, and refused if the numbers of nodes and cells differ from those that the
    file announces. Other formats are refused by name.

    The body consists of the cells of the highest dimension: solids if there are any, else surfaces
    for shells, else lines for beams. With `part`, the body consists of the cells of the named
    groups, of any dimension. Groups of other cells become node sets. Groups of the body's cells
    become both node sets and groups of elements. Surface elements are turned over where neighbours
    have opposite normals. Surface and line elements of second order are split into elements of
    first order: line3 into two lines, triangle6 into four triangles, quad9 into four quads, and
    quad8, with a node added in its middle, likewise. Bricks and other elements that repeat nodes
    are converted to the wedges, pyramids and tetrahedra that they represent. Midside nodes in
    another order than VTK's are reordered, and so are elements if all of a kind are left-handed.

    A set of an instance of an Abaqus part is called "instance.set", and also "set" if no other
    instance has a set of that name. Each instance is a group of elements.

    Groups of a Nastran deck are its properties, such as "property 3", and its sets, such as "SET 5
    nodes" and "SET 5 elements" for SET 5 of the case control, "SET1 5 nodes" for an entry SET1.

    Parameters
    ----------
    source : path, meshio.Mesh or Mesh
        File or mesh to be read.
    scale : float, optional
        Factor on the coordinates, to metres: 1e-3 for a file in millimetres.
    part : str or sequence of str, optional
        Groups of elements that make up the body; all elements by default. See `Mesh.part`. For a
        stiffened skin, give the groups of the skin and of the stiffeners.
    order : int, optional
        2 adds a node in the middle of each edge to elements of first order: tetra becomes tetra10,
        hexahedron hexahedron20, wedge wedge15 and pyramid pyramid13. Edges stay straight. A new
        node joins a set of nodes if both ends of its edge are in the set; if all of the set is on
        the surface, the edge must be on the surface, too.

    Raises
    ------
    MeshError
        If the file cannot be read (`MissingFileError` if it does not exist), has no elements or an
        unsupported kind, or has elements that are inverted or flat, or that repeat nodes and
        represent no other solid.
    InputError
        If there is no group of the name given as `part`, or `order` is neither 2 nor None.

    Warns
    -----
    AOImpactWarning
        If nodes were dropped or midside nodes reordered; if groups of the file have no elements; if
        a deck has elements that are neither in the body nor its sides or edges; if a deck has
        sections of shells or beams, which only `read_sections` reads; or if a file read by meshio
        announces no numbers of nodes and cells.

    Examples
    --------
    >>> import tempfile
    >>> import meshio
    >>> with tempfile.NamedTemporaryFile(suffix=".vtk") as file:
    ...     box = ao.box_mesh((20, 10, 10), (2, 1, 1))  # mm
    ...     meshio.Mesh(box.nodes, [("hexahedron", box.cells)]).write(file.name, file_format="vtk")
    ...     mesh = ao.read_mesh(file.name, scale=1e-3)
    >>> mesh.nodes.max(axis=0)  # m
    array([0.02, 0.01, 0.01])
    """
    return read_for(source, (), scale=scale, part=part, order=order)


def read_for(
    source: Any,
    thin: Sequence[str],
    *,
    scale: float = 1.0,
    part: str | Sequence[str] | None = None,
    order: int | None = None,
) -> Mesh:
    """Return the mesh as `read_mesh` does; the body includes the shell and beam groups `thin`."""
    factor = positive("scale", scale)
    parts = part if isinstance(part, (list, tuple)) else [part]
    named = [*thin, *(name for name in parts if isinstance(name, str))]  # `select` refuses others
    if order is not None and not (isinstance(order, (int, np.integer)) and order == 2):
        raise InputError(f"order must be 2 or None, got {order!r}")
    if isinstance(source, Mesh):
        mesh = source
        if factor != 1.0:
            cells: Any = [(block.kind, block.cells) for block in source.blocks]
            with np.errstate(over="ignore"):
                mesh = replace(source, nodes=source.nodes * factor, cells=cells, kind="mixed")
    elif isinstance(source, (str, os.PathLike)):
        raw = load(source)
        try:
            mesh = _ordered(raw, factor, named)
        except (MeshError, InputError, InputTypeError) as error:
            raise MeshError(f"mesh file {os.fspath(source)!r}: {error}") from None
    elif is_meshio(source):
        mesh = _ordered(from_meshio(source), factor, named)
    else:
        kind = type(source).__name__
        raise InputTypeError(f"mesh must be a path, a meshio.Mesh or a Mesh, got {kind}")
    mesh = _on_one_side(mesh if part is None else select(mesh, "part", part))
    return mesh if order is None else of_second_order(mesh)


def _ordered(raw: RawMesh, factor: float, named: Sequence[str]) -> Mesh:
    """Return the checked mesh of the elements of a file that make up the body."""
    if np.ndim(raw.nodes) != 2:
        shape = np.shape(raw.nodes)
        raise MeshError(f"coordinates of the mesh must have shape (any, 3), got {shape}")
    given = len(raw.nodes)
    raw = _of_first_order(raw, named)
    solids = _body(raw, named)
    _warn_of_rest(raw, solids, bool(named))
    used = np.zeros(len(raw.nodes), dtype=bool)
    for _, cells, _ in solids:
        used[cells] = True
    places = np.asanyarray(raw.nodes)
    if places.shape[1] == 2:
        raise MeshError("the mesh is two-dimensional (x, y); a solid needs x, y and z")
    if not used.all() and places.dtype.kind == "f":  # stray nodes may be NaN
        places = np.array(places, subok=True)  # keep a masked array, which is refused
        places[~used] = 0.0
    with np.errstate(over="ignore"):  # `Mesh` refuses infinite coordinates
        nodes = finite_array("coordinates of the mesh", places, shape=(None, 3), unit="m") * factor
    dropped = np.flatnonzero(~used[:given])
    if len(dropped):
        first = int(dropped[0])
        which = f"nodes after {first} have new numbers (named sets keep their members)"
        if raw.node_labels is not None:
            which = f"the first is node {raw.node_labels[first]}"
        of = f"{len(dropped)} of {given} nodes belong to no element of the body"
        warn(f"{of} and were dropped; {which}")
    labels, parts = raw.cell_labels, list[Solids]()
    for kind, cells, own in solids:
        found, wrong = collapse(kind, _order_midside_nodes(nodes, cells, kind), own)
        parts += found
        if len(wrong):
            first = int(own[wrong[0]])
            which = f"the first is element {first if labels is None else labels[first]}"
            raise MeshError(f"{len(wrong)} {kind} elements repeat nodes, {which}. Repair the mesh")
    parts = [(kind, right_handed(kind, nodes, of), own) for kind, of, own in _by_kind(parts)]
    return gathered(replace(raw, nodes=nodes, node_sets=_node_sets(raw)), parts, raw.first[-1])


def _of_first_order(raw: RawMesh, named: Sequence[str]) -> RawMesh:
    """Return a file's mesh with second-order surfaces and lines split into first-order elements.

    Each quad8 gets a node in its middle. The new node joins every set that contains all nodes of
    the quad8.
    """
    kinds = {block.kind for block in raw.blocks if len(block.cells)}
    solid = max((block.dim for block in raw.blocks if len(block.cells)), default=0) == 3
    if not kinds.intersection([*_SPLIT, "quad8"]) or (solid and not named):
        return raw
    nodes, labels, blocks, origins = raw.nodes, raw.node_labels, [], []
    node_sets = {name: np.asarray(own) for name, own in raw.node_sets.items()}
    middle = reference_element("quad8").shape(np.array([[0.5, 0.5, 0.0]]))[0]
    for block, numbers in zip(raw.blocks, raw.numbers, strict=True):
        kind, cells = block.kind, np.asarray(block.cells)
        sound = kind in {*_SPLIT, "quad8"} and cells.shape[1:] == (nodes_in(kind),) and len(cells)
        if kind == "quad8" and sound and 0 <= cells.min() <= cells.max() < len(raw.nodes):
            middles = len(nodes) + np.arange(len(cells))
            for name, own in node_sets.items():
                node_sets[name] = np.append(own, middles[np.isin(cells, own).all(axis=1)])
            nodes = np.concatenate([nodes, np.einsum("a,nai->ni", middle, nodes[cells])])
            if labels is not None:
                labels = np.append(labels, labels.max() + 1 + np.arange(len(cells)))
            kind, cells = "quad9", np.column_stack([cells, middles])
        if sound and kind in _SPLIT:  # malformed blocks are refused later
            kind, parts = _SPLIT[kind]
            tags = None if block.labels is None else np.repeat(block.labels, len(parts))
            cells = cells[:, np.array(parts)].reshape(-1, len(parts[0]))
            block = replace(block, kind=kind, cells=cells, labels=tags)
            numbers = np.repeat(numbers, len(parts))
        blocks.append(block)
        origins.append(numbers)
    origin = np.concatenate(origins)
    sets = {name: np.flatnonzero(np.isin(origin, own)) for name, own in raw.cell_sets.items()}
    return RawMesh(nodes, tuple(blocks), node_sets, sets, labels, raw.left_out, raw.deck)


def _warn_of_rest(raw: RawMesh, body: list[Solids], named: bool) -> None:
    """Warn of elements and sections of a deck that are not part of the body.

    Named groups imply that `read_sections` is used: then there is no warning of sections. In a deck
    without sections of shells and beams, elements on sides and edges of the body are taken for
    by-products of the mesher, without a warning.
    """
    if raw.deck is None:
        return
    if raw.deck.sections and not named and any(kind in THIN for kind, *_ in body):
        why = f"sections of the deck ({raw.deck.sections}) are not part of a mesh"
        warn(f"{why}: give those of read_sections(path) to FEModel.from_mesh")

    def corners(kind: str, cells: IntArray) -> Any:
        """Return a matrix with 1 where a node is a corner of a cell, shape (n_cells, n_nodes)."""
        cells = cells[:, : nodes_in(kind.rstrip("0123456789"))]
        starts = np.arange(0, cells.size + 1, cells.shape[1])
        shape = len(cells), len(raw.nodes)
        return sp.csr_array((np.ones(cells.size), cells.ravel(), starts), shape=shape)

    of_body, left = sp.vstack([corners(kind, cells) for kind, cells, _ in body]), list[Any]()
    there = np.concatenate([numbers for *_, numbers in body])
    for block, numbers in zip(raw.blocks, raw.numbers, strict=True):
        rest = block.cells[~np.isin(numbers, there)]
        count = len(rest)
        if block.dim and count and not raw.deck.sections:
            own = corners(block.kind, rest)
            inside = (own @ of_body.T).max(axis=1).toarray().ravel() == own.sum(axis=1)
            count = int(np.count_nonzero(~inside))
        left.append((block.name or block.kind, count))
    if others := listed(left):
        why = "that are neither solids nor in groups named as shells or beams were left out"
        warn(f"elements of the deck {why}: {others}")


def _node_sets(raw: RawMesh) -> dict[str, IntArray]:
    """Return all node sets, including the set of the nodes of each group of cells."""
    of_cells = (
        (name, block.cells[own].ravel())
        for name, members in raw.cell_sets.items()
        if name not in raw.node_sets  # a node set of this name takes precedence
        for block, own in raw.rows(members)
    )
    sets = grouped([*raw.node_sets.items(), *of_cells])
    for name, ids in sets.items():
        if not 0 <= ids[0] <= ids[-1] < len(raw.nodes):
            raise MeshError(f"the group {name!r} of the mesh has nodes that are not there")
    return {name: ids.astype(np.int64) for name, ids in sets.items()}


def _body(raw: RawMesh, named: Sequence[str]) -> list[Solids]:
    """Return the cells of the body by kind, with their numbers in `raw`.

    The body consists of the cells of the mesh's highest dimension, and of each named group's cells
    of the group's highest dimension.
    """
    dims, parts = raw.dims, []
    chosen = dims == dims.max(initial=0)
    groups = [raw.cell_sets[found] for name in named if (found := called(name, raw.cell_sets))]
    if groups and raw.deck is not None and dims.max() == 1:  # lines in no group may be rods
        chosen[:] = False
    for members in groups:
        chosen[members[dims[members] == dims[members].max(initial=0)]] = True
    for block, numbers in zip(raw.blocks, raw.numbers, strict=True):
        own = chosen[numbers]
        if block.dim and own.any():  # empty blocks may have any shape
            parts.append((block.kind, block.cells[own], numbers[own]))
    unknown = {kind for kind, _, _ in parts}.difference(KINDS + THIN)
    if unknown or not parts:
        them = tuple(of for of in raw.blocks if not parts or of.kind in unknown)
        it_has = replace(raw, blocks=them).contents or "no cells at all"
        what = "cells of an unsupported kind:" if unknown else "no elements: it has"
        cure = f"supported are {', '.join(KINDS + THIN)}"
        if re.search(r"\b(CP[ES]|CAX|M3D|SFM3D)\d", it_has):
            cure += ". Planar elements and membranes are no shells: write S4 or S3 for shells"
        elif any(kind.startswith(("triangle", "quad", "line")) for kind in unknown):
            cure += ". Shells and beams are of first order: mesh with these"
        raise MeshError(f"the mesh has {what} {it_has}; {cure}")
    return [
        (kind, checked_cells(cells, reference_element(kind), len(raw.nodes)), numbers)
        for kind, cells, numbers in _by_kind(parts)
    ]


def _on_one_side(mesh: Mesh) -> Mesh:
    """Return the mesh with surface elements turned over where neighbours have opposite normals."""
    surfaces = [block for block in mesh.blocks if block.kind in _FLAT]
    turned = against_neighbours(mesh.nodes, [block.cells for block in surfaces])
    if not (count := sum(int(each.sum()) for each in turned)):
        return mesh
    of = f"{count} of {sum(map(len, turned))} surface elements"
    warn(f"{of} had normals opposite to others and were turned: check which side is the top")
    cells = {block.kind: block.cells for block in mesh.blocks}
    for block, flipped in zip(surfaces, turned, strict=True):
        cells[block.kind] = np.where(flipped[:, None], block.cells[:, ::-1], block.cells)
    return replace(mesh, cells=list(cells.items()), kind="mixed")  # type: ignore[arg-type]


def _by_kind(parts: Iterable[Solids]) -> list[Solids]:
    """Return one table of elements for each kind, in the order of `KINDS` and `THIN`."""
    found: dict[str, list[Solids]] = {}
    for part in parts:
        found.setdefault(part[0], []).append(part)
    joined = []
    for kind in (kind for kind in KINDS + THIN if kind in found):
        _, cells, numbers = zip(*found[kind], strict=True)
        shapes = sorted({str(np.shape(table)[1:]) for table in cells})
        if len(shapes) > 1:
            raise MeshError(f"blocks of {kind} have different shapes: {', '.join(shapes)}")
        joined.append((kind, np.concatenate(cells), np.concatenate(numbers)))
    return joined


def _order_midside_nodes(nodes: FloatArray, cells: IntArray, kind: str) -> IntArray:
    """Return cells with midside nodes in meshio's order, which is found from coordinates.

    One permutation is determined from a sample of the elements and applied to all elements.
    """
    element = reference_element(kind)
    n = element.n_corners
    if not element.quadratic:
        return cells
    sample = cells[np.linspace(0, len(cells) - 1, min(len(cells), 2000)).astype(int)]
    corners = nodes[sample[:, :n]]
    expected = element.linear.shape(element.nodes[n:]) @ corners
    size = np.ptp(corners, axis=1).max(axis=1)
    with np.errstate(over="ignore", invalid="ignore"):
        gaps = expected[:, :, None, :] - nodes[sample[:, n:]][:, None, :, :]
        gaps = gaps / np.where(size > 0.0, size, 1.0)[:, None, None, None]
    misfit = np.einsum("eabi,eabi->ab", gaps, gaps)
    if not np.isfinite(misfit).all():  # overflow: refused later by the body
        return cells
    _, order = scipy.optimize.linear_sum_assignment(misfit)
    if np.array_equal(order, np.arange(len(order))):
        return cells
    warn(f"the midside nodes of the {len(cells)} {kind} elements were put in VTK's order")
    return np.ascontiguousarray(np.concatenate([cells[:, :n], cells[:, n:][:, order]], axis=1))


def read_sections(
    path: FilePath,
    *,
    scale: float = 1.0,
    force: float = 1.0,
    time: float = 1.0,
    given: Mapping[str, OneMaterial] | None = None,
) -> dict[str, OneMaterial]:
    """Return the sections in a deck, by the names of the groups of elements that have them.

    The result is the material argument of `FEModel.from_mesh`. For a deck in metres,
    ``FEModel.from_mesh(path, read_sections(path))`` returns the body.

    Abaqus and CalculiX: \\*SOLID SECTION, \\*SHELL SECTION (also COMPOSITE), \\*SHELL GENERAL
    SECTION of a material, \\*BEAM SECTION and \\*BEAM GENERAL SECTION; \\*ELASTIC, \\*DENSITY,
    rectangular \\*ORIENTATION. Nastran: PSOLID, PSHELL, PCOMP, PCOMPG, PBAR, PBARL, PBEAM, PBEAML;
    MAT1, MAT8, MAT11; PARAM,WTMASS. Anything else that changes the answer is refused, such as added
    mass and shear stiffness. Loads, supports and steps are not read.

    Beams have all shapes in Abaqus' library and in Nastran's PBARL except DBOX, or section
    properties given as numbers. The shear centre is taken at the centroid. The centroid is offset
    from the nodes as in Abaqus; for Nastran's bars it is at the nodes, or offset by WA = WB. J is
    Saint-Venant's, from an integral equation on the outline. The shear factor along an axis is the
    ratio of the area of the walls along it to the whole area. ARBITRARY has thin walls:
    J = Σ b t³/3, plus 4 A²/∮ds/t if the section is closed.

    LAMINA and MAT8 lack the modulus E3 across plies. It is estimated as for unidirectional fibres:
    E3 = E2, with ν13 = ν12 and ν23 = E2/(2 G23) − 1. If G23 is too small for this, as for fabrics,
    E3 = 2 (1 + ν) G with ν = ν13 = ν23 = 0.4 and G the smaller of G13 and G23. E3 affects contact
    only. Axis 1 of a shell without an orientation is the projection of x, as in Abaqus.

    Parameters
    ----------
    path : path
        The deck.
    scale, force, time : float, optional
        The deck's units of length in m, of force in N, and of time in s. The units of modulus and
        density follow as in solvers: ``force/scale**2`` and ``force*time**2/scale**4``.
        For mm, N, t, s: ``scale=1e-3``; mm, kN, kg, ms: ``scale=1e-3, force=1e3, time=1e-3``;
        mm, kg, s: ``scale=1e-3, force=1e-3``;
        in, lbf, s: ``scale=0.0254, force=4.44822``.
    given : mapping of str to Material, Orthotropic, Shell, Laminate or Beam, optional
        Sections by group and materials by name, in SI units, that replace those of the deck. The
        name for Nastran's MAT1 7 is "material 7".

    Returns
    -------
    dict of str to Material, Orthotropic, Shell, Laminate or Beam
        Sections by group of elements, in SI units.

    Raises
    ------
    MeshError
        If the deck cannot be read, or a section is not understood; file and line are named.
    InputError, InputTypeError

    Warns
    -----
    AOImpactWarning
        If plasticity, damping and the like of materials are left out, or if materials have values
        that no solid has, which suggests wrong units.

    Examples
    --------
    A triangle in millimetres, newtons, tonnes and seconds:

    >>> from tempfile import TemporaryDirectory
    >>> from pathlib import Path
    >>> deck = '''*NODE
    ... 1, 0, 0, 0
    ... 2, 30, 0, 0
    ... 3, 0, 30, 0
    ... *ELEMENT, TYPE=S3, ELSET=SKIN
    ... 1, 1, 2, 3
    ... *SHELL SECTION, ELSET=SKIN, MATERIAL=ALU
    ... 2.
    ... *MATERIAL, NAME=ALU
    ... *ELASTIC
    ... 70000., 0.33
    ... *DENSITY
    ... 2.7E-9'''
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "skin.inp"
    ...     _ = file.write_text(deck)
    ...     sections = ao.read_sections(file, scale=1e-3)
    ...     mesh = ao.read_mesh(file, scale=1e-3, part=list(sections))
    >>> sections["SKIN"].thickness, sections["SKIN"].material
    (0.002, Material(E=70000000000.0, nu=0.33, rho=2700.0))
    >>> ao.FEModel.from_mesh(mesh, sections)
    FEModel(18 dofs, 3 nodes, 1 triangle, 0.00243 kg, free)
    """
    named = {"scale": scale, "force": force, "time": time}
    length, newtons, seconds = (positive(name, one) for name, one in named.items())
    known = instance("given", {} if given is None else given, Mapping)
    for name, one in known.items():
        text("a name of given", name)
        instance(f"given[{name!r}]", one, *get_args(OneMaterial))
    with held_warnings():  # `read_mesh` gives the warnings about the mesh
        raw = load(path)
    where = f"mesh file {os.fspath(path)!r}"
    stress, per_speed = newtons / length / length, seconds / length
    density = stress * per_speed * per_speed
    source = Source(raw, length, stress, density, {key(name): one for name, one in known.items()})
    with held_warnings() as of_no_solid:
        if raw.deck is None:
            raise MeshError(f"{where} is no deck of Abaqus, CalculiX or Nastran")
        found: dict[str, OneMaterial] = raw.deck.read(source)
    if of_no_solid:
        said = of_no_solid[0].partition(":")[0]
        source.left_out.append(f"{said}; give scale=, force=, time= of its units")
    if not found:
        said = "; ".join([f"it has {raw.contents}", *dict.fromkeys(source.left_out)])
        cure = "Write shells as S3 or S4, rods as bars, or give materials to from_mesh"
        raise MeshError(f"{where} has no sections of solids, shells or beams; {said}. {cure}")
    for name, one in known.items():
        if key(name) not in source.taken:
            instance(f"given[{name!r}]", one, *source.wanted.get(key(name), (object,)))
            known_as = f"; the groups are {', '.join(map(repr, found))}"
            raise InputError(f"given: no part uses {name!r}{nearest(name, found)}{known_as}")
    _refuse_turned(raw, found, where)
    if source.left_out:
        warn(f"{where}: {'; '.join(dict.fromkeys(source.left_out))}")
    return found


def _refuse_turned(raw: RawMesh, found: Mapping[str, OneMaterial], where: str) -> None:
    """Refuse shells that `read_mesh` turns over if their offset or plies depend on the side."""
    sided = [name for name, of in found.items() if isinstance(of, Layers) and of.sided]
    shells = [i for i, block in enumerate(raw.blocks) if sided and block.kind in _FLAT]
    over = against_neighbours(raw.nodes, [raw.blocks[i].cells for i in shells])
    turned = joined(raw.numbers[i][own] for i, own in zip(shells, over, strict=True))
    for name in sided:
        if np.isin(raw.cell_sets[name], turned).any():
            why = f"{where}: elements of {name!r} have normals opposite to their neighbours'"
            raise MeshError(f"{why}, and plies or offset depend on the side; turn the elements")


def paper_sphere_mesh() -> Mesh:
    """Return the paper's sphere: radius 10 mm, 1053 nodes, 602 tetra10 (section 3, Table 1).

    The paper prints the numbers of nodes and elements, not the mesh. This mesh has the same
    numbers. Corner nodes lie at (±R, 0, 0); the node set "surface" holds the nodes on the sphere.

    Examples
    --------
    >>> mesh = ao.paper_sphere_mesh()
    >>> mesh.n_nodes, len(mesh.cells), mesh.kind
    (1053, 602, 'tetra10')
    """
    with resources.as_file(resources.files("aoimpact") / "data" / "sphere.msh") as path:
        return read_mesh(path)


# ------------------------------------------------------------------------------- files


def load(path: FilePath) -> RawMesh:
    """Return the nodes, cells and groups of a file.

    Raises
    ------
    MissingFileError
        If the file does not exist.
    MeshError
        If the file is empty, or its reader refuses it.
    MemoryLimitError
        If there is not enough memory to read the file.
    """
    file = file_path("mesh", path)
    where = f"mesh file {str(file)!r}"
    head = existing("mesh file", file)
    try:
        return _reader(file.suffix.lower(), head)(file)
    except MeshError:
        raise
    except MemoryError:
        raise MemoryLimitError(f"{where} needs more memory than there is: coarsen it") from None
    except (ValueError, LookupError, OverflowError, OSError, RecursionError) as error:
        why = f"{where} cannot be read: {error}"
        raise MeshError(f"{why}. Save it again, or as .msh or .vtu") from None


def existing(what: str, file: Path) -> bytes:
    """Return the first bytes of a file that is to be read.

    Raises
    ------
    MissingFileError
        If the file does not exist.
    MeshError
        If the file cannot be opened, is no regular file, or is empty.
    """
    where = f"{what} {str(file)!r}"
    try:
        if file.exists() and not file.is_file():  # reading from a pipe might block
            raise MeshError(f"{where} is no regular file")
        with file.open("rb") as stream:
            head = stream.read(_HEAD)
    except FileNotFoundError:
        raise MissingFileError(f"{where} does not exist (in {os.getcwd()})") from None
    except OSError as error:  # no access, or a name that is too long
        raise MeshError(f"{where} cannot be opened: {error}") from None
    if not head:
        raise MeshError(f"{where}: it is empty")
    return head


def _reader(suffix: str, head: bytes) -> _Reader:
    if looks_like_inp(head[:4096]):  # CalculiX names decks .msh, too
        return abaqus.read
    if suffix.startswith(".msh"):
        return gmsh.read
    foreign = suffix not in _READERS or (suffix == ".inp" and head.lstrip()[:1] != b"*")
    if foreign and is_nastran(head):
        return nastran.read
    return _READERS.get(suffix, viameshio.read)
