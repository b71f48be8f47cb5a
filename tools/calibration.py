"""Calibrate the estimated errors of default impacts against the truths of much finer meshes.

Needs gmsh, which the package itself does not:

    python tools/calibration.py truths      # docs/calibration-truths.csv: those that are missing
    python tools/calibration.py run         # half an hour; may be stopped and continued
    python tools/calibration.py table       # docs/calibration.md and docs/calibration.csv

``--only cup sheet`` takes the bodies whose names contain one of the words, ``--rows`` another file
of rows, and PYTHONPATH another clone's package. A truth is not computed again unless its lines are
deleted. It is the same impact with ``rtol=5e-4`` on bricks of twenty nodes, or tetrahedra of ten in
balls, that are small at the contact and grow from it, and its own error the difference to a coarser
such mesh.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import cumulative_trapezoid

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALU = ao.Material(E=70e9, nu=0.33, rho=2700)
PMMA = ao.Material(E=3.3e9, nu=0.37, rho=1190)

DOCS = Path(__file__).parents[1] / "docs"
TRUTHS_STORED = DOCS / "calibration-truths.csv"
NUMBERS = ("peak_force", "contact_duration", "impulse", "rebound_velocity")

# As `aoimpact.results.ErrorParts`: a slower rebound counts as this share of the velocity.
LEAST_REBOUND = 0.1

# Truths: tolerance, and of meshes from coarse to fine the size of elements at the contact over the
# body's own, their growth per length, and their largest size over the body's own. The finest is
# not needed where the others differ by less than this share.
RTOL, ENOUGH = 5e-4, 3e-3
TRUTHS = ((0.25, 0.5, 1.5), (0.15, 0.45, 1.2), (0.09, 0.4, 1.0))

# Natural modes of "modal" models.
MODES = 15

# Kinds of elements, and their sizes over the body's own, of bodies that gmsh draws: tetrahedra by
# gmsh, and even bricks.
MESHES = {
    "tetra": (1.5, 0.7),
    "tetra10": (1.8, 1.2),
    "hexahedron": (1.2, 0.7),
    "hexahedron20": (1.5, 1.0),
}

Point = tuple[float, float, float]
Sizes = tuple[float, float, float]
Meshes = dict[str, tuple[Sizes, ...]]


# ------------------------------------------------------------------------------------------ bodies


@dataclass(frozen=True)
class Shape:
    """A block of bricks between knots, or what gmsh draws, or both; lengths in mm.

    Attributes
    ----------
    knots : three sequences of float
        Coordinates along each axis at which elements end. Empty if there are no bricks.
    draw : callable, or None
        Makes the body in gmsh.
    keep : callable, or None
        Which cells there are, of their centres.
    outer, inner : float
        Radii, if the block is bent to a ring: along its axes are the radius less `inner`, the arc
        on the outside, and the height.
    coat : float
        Height above which the second material is.
    """

    knots: Sequence[Sequence[float]] = ()
    draw: Callable[[Any], Any] | None = None
    keep: Callable[[Any], Any] | None = None
    outer: float = 0.0
    inner: float = 0.0
    coat: float = np.inf


def box(*sides: float) -> Shape:
    return Shape([(0, side) for side in sides], lambda occ: occ.addBox(0, 0, 0, *sides))


def ring(outer: float, inner: float, height: float) -> Shape:
    def draw(occ: Any) -> None:
        rods = [(3, occ.addCylinder(0, 0, 0, 0, 0, height, of)) for of in (outer, inner)]
        occ.cut(rods[:1], rods[1:])

    knots = (0, outer - inner), (0, 2.0 * np.pi * outer), (0, height)
    return Shape(knots, draw, outer=outer, inner=inner)


def bracket(a: float, b: float, t: float, height: float) -> Shape:
    def draw(occ: Any) -> None:
        whole, rest = occ.addBox(0, 0, 0, a, b, height), occ.addBox(t, t, 0, a, b, height)
        occ.cut([(3, whole)], [(3, rest)])

    return Shape(((0, t, a), (0, t, b), (0, height)), draw, lambda x: (x[:, :2] < t).any(axis=1))


def spaced(knots: Sequence[float], at: float, sizes: Sizes) -> Any:
    """Coordinates through knots, even, or growing from one `at` a place to the largest size."""
    near, slope, most = sizes
    ends, parts = np.unique(np.round([*knots, *([at] if slope else [])], 9)), []
    for low, high in pairwise(ends):
        fine = np.linspace(low, high, 2001)
        density = 1.0 / np.minimum(near + slope * np.abs(fine - at), most)
        count = cumulative_trapezoid(density, fine, initial=0.0)
        n = max(1, round(count[-1]))
        parts.append(np.interp(np.linspace(0.0, count[-1], n + 1)[:-1], count, fine))
    return np.concatenate([*parts, ends[-1:]])


def bricks(shape: Shape, kind: str, at: Point, sizes: Sizes) -> ao.Mesh:
    """Mesh a block by cells that grow from a point; of shells, its middle surface."""
    axes = [spaced(*of, sizes) for of in zip(shape.knots, at, strict=True)]
    counts = [len(axis) - 1 for axis in axes]
    if kind == "quad":
        across = 0 if shape.outer else 2
        axes[across] = axes[across][-1:] / 2.0
        sheet = ao.sheet_mesh((1, 1), [n for i, n in enumerate(counts) if i != across])
        cells, share = sheet.cells, np.insert(sheet.nodes[:, :2], across, 0.0, axis=1)
    else:
        cube = ao.box_mesh((1, 1, 1), counts, kind=kind)
        cells, share = cube.cells, cube.nodes
    nodes = np.column_stack(
        [
            np.interp(of, np.linspace(0, 1, len(axis)), axis)
            for of, axis in zip(share.T, axes, strict=True)
        ]
    )
    centres = nodes[cells].mean(axis=1)
    if shape.keep:
        cells, centres = cells[shape.keep(centres)], centres[shape.keep(centres)]
    if shape.outer:
        radius, angle = shape.inner + nodes[:, 0], nodes[:, 1] / shape.outer - np.pi
        nodes[:, :2] = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    numbers, cells = np.unique(cells, return_inverse=True)
    _, first, once = np.unique(
        np.round(nodes[numbers], 7) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    core = centres[:, 2] < shape.coat
    groups = {"core": np.flatnonzero(core), "coat": np.flatnonzero(~core)}
    return ao.Mesh(
        1e-3 * nodes[numbers][first],
        once.ravel()[cells.reshape(len(centres), -1)],
        kind,
        cell_sets={name: of for name, of in groups.items() if len(of)},
    )


def drawn(shape: Shape, kind: str, at: Point, sizes: Sizes) -> ao.Mesh:
    """Mesh by tetrahedra that grow from a point, by gmsh."""
    import gmsh

    assert shape.draw is not None
    if not gmsh.isInitialized():
        gmsh.initialize()
    options = {"General.Terminal": 0, "Mesh.ScalingFactor": 1e-3, "Mesh.MeshSizeMax": sizes[2]}
    for option, value in options.items():
        gmsh.option.setNumber(option, value)
    gmsh.clear()
    shape.draw(gmsh.model.occ)
    gmsh.model.occ.synchronize()
    mesh, away = gmsh.model.mesh, [f"({x}-{of})^2" for x, of in zip("xyz", at, strict=True)]
    growing = mesh.field.add("MathEval")
    mesh.field.setString(growing, "F", f"{sizes[0]}+{sizes[1]}*Sqrt({'+'.join(away)})")
    mesh.field.setAsBackgroundMesh(growing)
    mesh.generate(3)
    if kind == "tetra10":
        mesh.setOrder(2)
    gmsh.model.addPhysicalGroup(3, [volume for _, volume in gmsh.model.getEntities(3)])
    with tempfile.TemporaryDirectory() as folder:
        gmsh.write(path := f"{folder}/body.msh")
        return ao.read_mesh(path)


# ------------------------------------------------------------------------------------------ setups


@dataclass(frozen=True)
class Setup:
    """A body, a place, a ball of steel and a speed; lengths in mm.

    Attributes
    ----------
    name : str
    shape : Shape
    material : Material, or two of them
        Of the core and of the coat.
    fixed : supports, or None
    point : tuple of float
    size : float
        Of the elements of a middling mesh.
    radius : float
        Of the ball.
    velocity : float or tuple of float
        m/s.
    elastic : bool
        Whether the ball has a mesh.
    far : float
        Largest size of a middling mesh, if it grows; 0 of an even one.
    meshes : mapping of str to sequences of (near, growth, most), mm
        By kind of element, of bodies that `bricks` meshes; gmsh meshes the others.
    """

    name: str
    shape: Shape
    material: Any
    fixed: Any
    point: Point
    size: float
    radius: float
    velocity: Any
    meshes: Meshes = field(default_factory=dict)
    far: float = 0.0
    elastic: bool = False

    def body(self, kind: str, sizes: Sizes) -> ao.FEModel:
        """Return the body meshed, by bricks or by gmsh."""
        material, fixed, at = self.material, self.fixed, self.point
        if isinstance(material, tuple):
            material = dict(zip(("core", "coat"), material, strict=True))
        if kind == "quad":
            across = self.shape.knots[0 if self.shape.outer else 2]
            material = ao.Shell(1e-3 * across[-1], material)
            fixed = fixed and [(*of, of[1]) if of[1] == "xyz" else of for of in fixed]
        if kind.startswith("tetra") and self.shape.draw and not self.meshes:
            return ao.FEModel.from_mesh(drawn(self.shape, kind, at, sizes), material, fixed=fixed)
        if self.shape.outer:
            angle = np.arctan2(at[1], at[0]) + np.pi
            at = (np.hypot(*at[:2]) - self.shape.inner, self.shape.outer * angle, at[2])
        return ao.FEModel.from_mesh(bricks(self.shape, kind, at, sizes), material, fixed=fixed)

    def strike(self, body: ao.FEModel, modes: int = 0, **more: Any) -> ao.Result:
        if isinstance(self.velocity, tuple):
            more["friction"] = 0.3
        tip: Any = body.contact(point=1e-3 * np.array(self.point))
        return ao.simulate(
            projectile=striker(1e-3 * self.radius, self.elastic),
            target=ao.modal(tip, modes) if modes else tip,
            velocity=self.velocity,
            **more,
        )

    def tests(self) -> Iterator[tuple[str, Sizes]]:
        """Kinds and sizes of the meshes that are compared."""
        if self.meshes:
            yield from ((kind, size) for kind, sizes in self.meshes.items() for size in sizes)
            return
        for kind, sizes in MESHES.items():
            for size in sizes if self.shape.knots or kind.startswith("tetra") else ():
                yield kind, (size * self.size, 0.0, size * self.size)


@cache
def striker(radius: float, elastic: bool) -> Any:
    """A ball that is rigid, or of elements that leave out less than what it strikes."""
    if not elastic:
        return ao.ball(radius, STEEL)
    model = ao.FEModel.from_mesh(ao.sphere_mesh(radius=radius, size=0.25 * radius), STEEL)
    return model.contact(point=(0, 0, -radius))


def kinds(*sizes: Sizes, more: Sequence[str] = ()) -> Meshes:
    return dict.fromkeys((*MESHES, *more), sizes)


def low(axis: int, high: bool = False) -> Callable[[Any], Any]:
    """The nodes of one end of a body, or both."""
    return lambda x: (x[:, axis] < 1e-7) | (high & (x[:, axis] > x[:, axis].max() - 1e-7))


def setups() -> Iterator[Setup]:
    """The setups: of gmsh's meshes first, then of bricks that grow, or are cut into other kinds."""
    rim = [(lambda x: low(0, True)(x) | low(1, True)(x), "z")]
    ends, root, foot = ([(at, "xyz")] for at in (low(0, True), low(0), low(2)))
    plate, thin = box(100, 80, 6), box(120, 120, 2.5)
    disc = Shape(draw=lambda occ: occ.addCylinder(0, 0, 0, 0, 0, 5, 40))
    balls = [Shape(draw=partial(lambda r, occ: occ.addSphere(0, 0, 0, r), r)) for r in (10, 8)]
    flat_ring, tube, block = ring(30, 20, 10), ring(20, 17, 60), box(40, 40, 30)
    pmma, beam, angle = box(80, 80, 15), box(150, 15, 10), bracket(60, 40, 8, 30)
    moves: Any = {"elastic": True}
    yield Setup("clamped plate", plate, ALU, ends, (50, 40, 6), 6, 10, 1.0, **moves)
    yield Setup("clamped plate, off centre", plate, ALU, ends, (30, 20, 6), 6, 5, 2.0)
    yield Setup("thin plate", thin, STEEL, None, (60, 60, 2.5), 6, 8, 0.5)
    yield Setup("thin plate, near its edge", thin, STEEL, None, (12, 60, 2.5), 6, 5, 1.0)
    yield Setup("supported plate", box(200, 200, 4), ALU, rim, (100, 100, 4), 10, 5, 1.0)
    yield Setup("plate of PMMA", pmma, PMMA, None, (40, 40, 15), 8, 10, 2.0, **moves)
    yield Setup("disc", disc, ALU, None, (0, 0, 5), 5, 8, 1.0)
    yield Setup("disc, off centre", disc, ALU, None, (25, 0, 5), 5, 5, 3.0, **moves)
    yield Setup("ring, on its face", flat_ring, STEEL, None, (25, 0, 10), 4, 6, 1.0)
    yield Setup("ring, from outside", flat_ring, STEEL, None, (30, 0, 5), 4, 6, 2.0, **moves)
    yield Setup("tube", tube, ALU, None, (20, 0, 30), 4, 6, 2.0, **moves)
    yield Setup("tube, near its end", tube, ALU, None, (20, 0, 10), 4, 6, 1.0)
    yield Setup("block", block, STEEL, None, (20, 20, 30), 5, 8, 1.0, **moves)
    yield Setup("block, near its edge", block, STEEL, None, (7, 20, 30), 5, 5, 2.0)
    yield Setup("clamped cube of PMMA", box(50, 50, 50), PMMA, foot, (25, 25, 50), 8, 10, 1.0)
    yield Setup("clamped beam", beam, ALU, ends, (75, 7.5, 10), 5, 6, 1.0, **moves)
    yield Setup("cantilever", beam, ALU, root, (140, 7.5, 10), 5, 5, 0.5)
    yield Setup("clamped bracket", angle, STEEL, root, (50, 8, 15), 5, 6, 1.0)
    yield Setup("bracket", angle, STEEL, None, (30, 0, 15), 5, 8, 0.5, **moves)
    yield Setup("ball", balls[0], STEEL, None, (0, 10, 0), 3, 10, 1.0)
    yield Setup("ball of aluminium", balls[1], ALU, None, (0, 8, 0), 2.5, 5, 2.0, **moves)

    shells, wedges, modal = ["quad"], ["wedge15"], ["modal"]
    wide, small = (box(300, 300, t) for t in (3, 4)), box(200, 200, 1)
    of = kinds((2, 0.7, 60), (5, 1.1, 60), more=shells)
    yield Setup("sheet of 3 mm", next(wide), STEEL, ends, (140, 150, 3), 5, 10, 1.0, of, 12)
    of = kinds((3, 0.7, 75), more=shells + wedges)
    yield Setup("sheet of 4 mm", next(wide), ALU, ends, (140, 150, 4), 6, 10, 1.0, of, 12)
    of = kinds((2, 0.9, 33), (1, 0.9, 33), more=shells)
    yield Setup("sheet of 1 mm", small, STEEL, ends, (95, 100, 1), 2, 5, 1.0, of, 6)
    of = kinds((10, 0, 10), (2, 0.7, 30), more=shells)
    yield Setup("sheet of 2 mm", box(120, 120, 2), STEEL, ends, (55, 60, 2), 4, 5, 1.0, of, 7)
    oblique, of = (0.2, 0.0, -2.0), kinds((8, 0, 8), (3, 0.5, 10))
    yield Setup("plate, oblique", plate, ALU, ends, (30, 20, 6), 6, 5, oblique, of)
    yield Setup("block, oblique", block, STEEL, None, (20, 20, 30), 5, 5, oblique, of)
    yield Setup("corner", block, STEEL, None, (4, 4, 30), 5, 5, 1.0, of)
    hole = Shape(
        ((0, 40, 60, 100), (0, 30, 50, 80), (0, 8)),
        keep=lambda x: (np.abs(x[:, :2] - (50, 40)) > 10).any(axis=1),
    )
    of = kinds((8, 0, 8), (3, 0.5, 10), more=modal)
    yield Setup("beside a hole", hole, ALU, ends, (34, 40, 8), 6, 5, 1.0, of, 9)
    step = Shape(((0, 50, 100), (0, 60), (0, 3, 6)), keep=lambda x: (x[:, 0] < 50) | (x[:, 2] < 3))
    of = kinds((6, 0, 6), (2, 0.5, 10), more=wedges)
    yield Setup("step of thickness", step, ALU, ends, (58, 30, 3), 5, 5, 1.0, of, 7)
    rib = Shape(
        ((0, 100), (0, 37, 43, 80), (0, 12, 15)),
        keep=lambda x: (x[:, 2] > 12) | (np.abs(x[:, 1] - 40) < 3),
    )
    of = kinds((6, 0, 6), (2, 0.5, 10))
    yield Setup("stiffener", rib, ALU, ends, (50, 40, 15), 5, 5, 1.0, of, 8)
    yield Setup("beside a stiffener", rib, ALU, ends, (50, 52, 15), 5, 5, 1.0, of, 8)
    of = kinds((6, 0, 6), (2, 0.5, 10), more=modal + shells)
    yield Setup("free edge", box(100, 80, 4), ALU, root, (97, 40, 4), 5, 5, 1.0, of, 8)
    cup = Shape(
        ((0, 2.5, 47.5, 50), (0, 2.5, 47.5, 50), (0, 37.5, 40)),
        keep=lambda x: (np.abs(x - (25, 25, 0)) > (22.5, 22.5, 37.5)).any(axis=1),
    )
    of = kinds((5, 0, 5), (2, 0.5, 8))
    yield Setup("cup", cup, ALU, None, (25, 25, 40), 5, 5, 1.0, of, 6)
    of = kinds((4, 0, 4), (1.5, 0.5, 6), more=shells)
    yield Setup("thin tube", ring(20, 18.5, 60), ALU, None, (20, 0, 30), 3, 5, 1.0, of, 5)
    coated, of = Shape(((0, 40), (0, 40), (0, 18, 20)), coat=18), kinds((6, 0, 6), (2, 0.5, 8))
    yield Setup("coating", coated, (STEEL, PMMA), None, (20, 20, 20), 5, 5, 1.0, of)
    yield Setup("steel on a soft pad", coated, (PMMA, STEEL), foot, (20, 20, 20), 5, 5, 1.0, of)


# --------------------------------------------------------------------------------------------- run


def rows_in(path: Path) -> list[dict[str, str]]:
    if not path.exists():
        return []
    with path.open() as file:
        return list(csv.DictReader(file))


@cache
def known(column: str) -> dict[tuple[str, str], float]:
    """A column of the truths, by body and number."""
    return {(row["body"], row["number"]): float(row[column]) for row in rows_in(TRUTHS_STORED)}


def append(path: Path, row: dict[str, Any]) -> None:
    new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, list(row), lineterminator="\n")
        if new:
            writer.writeheader()
        writer.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})
    print(*(f"{v:.4g}" if isinstance(v, float) else v for v in row.values()), flush=True)


def truths(chosen: Sequence[Setup]) -> None:
    """Append the truths that are not there yet."""
    there = {row["body"] for row in rows_in(TRUTHS_STORED)}
    for setup in (of for of in chosen if of.name not in there):
        kind, part = ("hexahedron20", 1.0) if setup.shape.knots else ("tetra10", 0.4)
        last: dict[str, float] = {}
        own = {"": np.inf}
        for first, growth, most in TRUTHS:
            if max(own.values()) <= ENOUGH:
                break
            sizes = part * first * setup.size, growth, part * most * (setup.far or setup.size)
            body = setup.body(kind, sizes)
            hit = setup.strike(body, quantity="peak_force", rtol=RTOL)
            if last:
                own = {of: _apart(setup, of, last[of], getattr(hit, of)) for of in NUMBERS}
            last = {of: getattr(hit, of) for of in NUMBERS}
        made = f"{kind} of {sizes[0]:.3g} to {sizes[2]:.3g} mm, {body.n_dofs} dofs"
        for number, error in own.items():
            row = {"body": setup.name, "number": number, "truth": getattr(hit, number)}
            append(TRUTHS_STORED, row | {"own_error": error, "made": made})


def _apart(setup: Setup, number: str, value: float, right: float) -> float:
    """Relative difference, of a slow rebound to a share of the velocity."""
    speed = float(np.abs(np.atleast_1d(setup.velocity)[-1]))
    least = LEAST_REBOUND * speed if number == "rebound_velocity" else 0.0
    return abs(value - right) / max(abs(right), least)


def compared(setup: Setup, kind: str, sizes: Sizes) -> dict[str, Any]:
    """Return the numbers of an impact by the default call, their true errors and the claims."""
    start = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        body = setup.body("hexahedron20" if kind == "modal" else kind, sizes)
        hit = setup.strike(body, modes=MODES if kind == "modal" else 0)
        error = hit.error
    row = {"body": setup.name, "kind": kind, "mesh_mm": _told(sizes), "dofs": body.n_dofs}
    for number in NUMBERS:
        row[number] = value = float(getattr(hit, number))
        row[f"{number}_error"] = _apart(setup, number, value, known("truth")[setup.name, number])
        row[f"{number}_claim"] = float(error[number].total)
    return row | {"seconds": round(time.perf_counter() - start, 1)}


def run(chosen: Sequence[Setup], path: Path) -> None:
    """Append the impacts that are not there yet, of bodies with truths."""
    done = {(row["body"], row["kind"], row["mesh_mm"]) for row in rows_in(path)}
    for setup in (of for of in chosen if (of.name, NUMBERS[0]) in known("truth")):
        for kind, sizes in setup.tests():
            if (setup.name, kind, _told(sizes)) not in done:
                try:
                    append(path, compared(setup, kind, sizes))
                except ao.AOImpactError as problem:  # a mesh too coarse for a law, for example
                    print(setup.name, kind, _told(sizes), problem, flush=True)


def _told(sizes: Sizes) -> str:
    return "-".join(f"{of:.4g}" for of in sorted({sizes[0], sizes[2]}))


# ------------------------------------------------------------------------------------------- table

# Where the prose of docs/calibration.md ends.
BEGIN = "<!-- Below is what tools/calibration.py writes. -->\n"

HEAD = """
| {} | impacts | not known | true error (median) | claim (median) | within | claim / error |
|---|---|---|---|---|---|---|
"""


def table(rows: list[dict[str, str]]) -> None:
    """Write docs/calibration.csv and the tables of docs/calibration.md."""
    own = known("own_error")
    (DOCS / "calibration.csv").unlink(missing_ok=True)
    for row in rows:
        append(DOCS / "calibration.csv", row)
    kind, text, beyond = np.array([row["kind"] for row in rows]), "", ""
    for number in NUMBERS:
        title = number.replace("_", " ")
        true, claim, value = (
            np.array([float(row[f"{number}{of}"]) for row in rows])
            for of in ("_error", "_claim", "")
        )
        within = true <= claim + [own[row["body"], number] for row in rows]
        text += HEAD.format(title)
        for name in ("all", *dict.fromkeys(kind)):
            there = np.isfinite(value) & ((kind == name) | (name == "all"))
            of = there & np.isfinite(claim)
            large = of & (true > 1e-3)
            text += f"| {name} | {there.sum()} | {(there & ~of).sum()} | "
            if not of.any():
                text += " | | | |\n"
                continue
            medians = " | ".join(_percent(np.median(values[of])) for values in (true, claim))
            ratio = f"{np.median(claim[large] / true[large]):.2g}" if large.any() else ""
            text += f"{medians} | {100 * within[of].mean():.3g} % | {ratio} |\n"
        for i in np.flatnonzero(~within & np.isfinite(true + claim)):
            what = f"{rows[i]['body']}, {rows[i]['kind']} of {rows[i]['mesh_mm']} mm"
            beyond += f"- {title}, {what}: {_percent(true[i])}, claim {_percent(claim[i])}\n"
    told = (
        f"{len(rows)} impacts on {len({row['body'] for row in rows})} bodies; truths are known to"
    )
    off = [_percent(of(list(own.values()))) for of in (np.median, np.max)]
    page = DOCS / "calibration.md"
    prose = page.read_text(encoding="utf-8").partition(BEGIN)[0] + BEGIN
    told = f"{prose}\n{told} {off[0]} in the median, {off[1]} at most.\n{text}\n"
    page.write_text(f"{told}## Not within the claim\n\n{beyond or 'None.'}", encoding="utf-8")


def _percent(share: Any) -> str:
    return f"{100.0 * share:.2g} %"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("do", choices=("truths", "run", "table"))
    parser.add_argument("--only", nargs="+", default=[""], help="words in the names of bodies")
    parser.add_argument("--rows", type=Path, default=Path("calibration-rows.csv"))
    given = parser.parse_args()
    chosen = [of for of in setups() if any(word in of.name for word in given.only)]
    if given.do == "truths":
        truths(chosen)
    elif given.do == "run":
        run(chosen, given.rows)
    else:
        order = [of.name for of in chosen]
        rows = [row for row in rows_in(given.rows) if row["body"] in order]
        table(sorted(rows, key=lambda row: order.index(row["body"])))


if __name__ == "__main__":
    main()
