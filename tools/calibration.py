"""Compare estimated errors of default impacts with their true errors, by much finer meshes.

Needs gmsh, which the package itself does not:

    python tools/calibration.py truths      # docs/calibration-truths.csv: those that are missing
    python tools/calibration.py run         # half an hour; may be stopped and continued
    python tools/calibration.py table       # docs/calibration.md and docs/calibration.csv

``--only cup sheet`` takes the bodies whose names contain one of the words, ``--rows`` another file
of rows, and PYTHONPATH another clone's package. The truth, a reference solution, is the same impact
with ``rtol=5e-4`` on 20-node bricks, or in balls on 10-node tetrahedra, which are small at the
contact and grow away from it; its own error is the difference to a coarser mesh of this kind. A
truth is not computed again unless its lines are deleted.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
import time
import tomllib
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import cumulative_trapezoid

import aoimpact as ao

MATERIALS = {
    "STEEL": ao.Material(E=210e9, nu=0.3, rho=7800),
    "ALU": ao.Material(E=70e9, nu=0.33, rho=2700),
    "PMMA": ao.Material(E=3.3e9, nu=0.37, rho=1190),
}

DOCS = Path(__file__).parents[1] / "docs"
TRUTHS_STORED = DOCS / "calibration-truths.csv"
NUMBERS = ("peak_force", "contact_duration", "impulse", "rebound_velocity")

# Smallest rebound velocity, over the impact's, that its error is divided by, as in
# `aoimpact.results.ErrorParts`.
LEAST_REBOUND = 0.1

# Truths: tolerance, and largest relative difference of coarser meshes with which the finest is not
# needed. Meshes from coarse to fine: size of elements at the contact over the body's `size`, their
# growth per length, and their largest size over the body's `size`.
RTOL, ENOUGH = 5e-4, 3e-3
TRUTHS = ((0.25, 0.5, 1.5), (0.15, 0.45, 1.2), (0.09, 0.4, 1.0))

# Number of natural modes of "modal" models.
MODES = 15

# Sizes of elements over the body's `size`, by kind, for bodies without `sizes`: tetrahedra by gmsh,
# and even bricks.
MESHES = {
    "tetra": (1.5, 0.7),
    "tetra10": (1.8, 1.2),
    "hexahedron": (1.2, 0.7),
    "hexahedron20": (1.5, 1.0),
}

Point = Sizes = tuple[float, float, float]


# ------------------------------------------------------------------------------------------ bodies


@dataclass(frozen=True)
class Shape:
    """A shape of tools/calibration.toml. A ring is a bent block, whose axes are the distance from
    the inner radius, the arc on the outside, and the height.
    """

    box: Sequence[float] = ()
    knots: Sequence[Sequence[float]] = ()
    without: Sequence[Sequence[Sequence[float]]] = ()
    ring: Sequence[float] = ()
    cylinder: Sequence[float] = ()
    sphere: float = 0.0
    coat: float = np.inf

    @property
    def bricks(self) -> Sequence[Sequence[float]]:
        """Coordinates along each axis at which elements must end, mm; empty if gmsh meshes it."""
        if self.ring:
            outer, inner, height = self.ring
            return (0, outer - inner), (0, 2.0 * np.pi * outer), (0, height)
        return self.knots or [(0, side) for side in self.box]

    def draw(self, occ: Any) -> None:
        """Make the shape in gmsh."""
        if self.sphere:
            occ.addSphere(0, 0, 0, self.sphere)
        elif self.cylinder or self.ring:
            *radii, height = self.cylinder or self.ring
            rods = [(3, occ.addCylinder(0, 0, 0, 0, 0, height, of)) for of in radii]
            if rods[1:]:
                occ.cut(rods[:1], rods[1:])
        else:
            whole = occ.addBox(0, 0, 0, *(knots[-1] for knots in self.bricks))
            holes = [occ.addBox(*low, *np.subtract(high, low)) for low, high in self.without]
            if holes:
                occ.cut([(3, whole)], [(3, hole) for hole in holes])


def spaced(knots: Sequence[float], at: float, sizes: Sizes) -> Any:
    """Return coordinates through knots: even, or with steps that grow with the distance from `at`.

    `sizes`: step at `at`, its growth per length, and its maximum.
    """
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
    """Mesh a block by cells that grow from a point, or for shells its middle surface."""
    axes = [spaced(*of, sizes) for of in zip(shape.bricks, at, strict=True)]
    counts = [len(axis) - 1 for axis in axes]
    if kind == "quad":
        across = 0 if shape.ring else 2
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
    for low, high in shape.without:
        there = ((centres < low) | (centres > high)).any(axis=1)
        cells, centres = cells[there], centres[there]
    if shape.ring:
        outer, inner, _ = shape.ring
        radius, angle = inner + nodes[:, 0], nodes[:, 1] / outer - np.pi
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
    """Mesh a shape by gmsh with tetrahedra that grow from a point."""
    import gmsh

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
    """An impact of a steel ball: body, place, ball's radius and velocity, m/s; lengths in mm.

    The fields are those of tools/calibration.toml; `material` is that of the core and, if there is
    one, that of the coat.
    """

    name: str
    shape: Shape
    material: Any
    point: Point
    size: float
    radius: float
    velocity: Any
    fixed: Any = None
    sizes: Sequence[Sizes] = ()
    more: Sequence[str] = ()
    far: float = 0.0
    elastic: bool = False

    def body(self, kind: str, sizes: Sizes) -> ao.FEModel:
        """Return the body, meshed by bricks or by gmsh."""
        material, fixed, at = self.material, self.fixed, self.point
        if isinstance(material, tuple):
            material = dict(zip(("core", "coat"), material, strict=True))
        if kind == "quad":
            across = self.shape.bricks[0 if self.shape.ring else 2]
            material = ao.Shell(1e-3 * across[-1], material)
            fixed = fixed and [(*of, of[1]) if of[1] == "xyz" else of for of in fixed]
        if kind.startswith("tetra") and not self.sizes:
            return ao.FEModel.from_mesh(drawn(self.shape, kind, at, sizes), material, fixed=fixed)
        if self.shape.ring:
            outer, inner, _ = self.shape.ring
            angle = np.arctan2(at[1], at[0]) + np.pi
            at = (np.hypot(*at[:2]) - inner, outer * angle, at[2])
        return ao.FEModel.from_mesh(bricks(self.shape, kind, at, sizes), material, fixed=fixed)

    def strike(self, body: ao.FEModel, modes: int = 0, **more: Any) -> ao.Result:
        if isinstance(self.velocity, list):
            more["friction"] = 0.3
        tip: Any = body.contact(point=1e-3 * np.array(self.point))
        return ao.simulate(
            projectile=striker(1e-3 * self.radius, self.elastic),
            target=ao.modal(tip, modes) if modes else tip,
            velocity=self.velocity,
            **more,
        )

    def tests(self) -> Iterator[tuple[str, Sizes]]:
        """Yield kinds and sizes of the meshes that are compared."""
        for kind, shares in MESHES.items():
            even = [(share * self.size, 0.0, share * self.size) for share in shares]
            if self.sizes or self.shape.bricks or kind.startswith("tetra"):
                yield from ((kind, sizes) for sizes in self.sizes or even)
        yield from ((kind, sizes) for kind in self.more for sizes in self.sizes)


@cache
def striker(radius: float, elastic: bool) -> Any:
    """Return a rigid ball, or an elastic one whose elements err less than those of the body."""
    if not elastic:
        return ao.ball(radius, MATERIALS["STEEL"])
    model = ao.FEModel.from_mesh(
        ao.sphere_mesh(radius=radius, size=0.25 * radius), MATERIALS["STEEL"]
    )
    return model.contact(point=(0, 0, -radius))


def low(axis: int, high: bool = False) -> Callable[[Any], Any]:
    """Return the function that selects the nodes at the low end of an axis, or at both ends."""
    return lambda x: (x[:, axis] < 1e-7) | (high & (x[:, axis] > x[:, axis].max() - 1e-7))


def setups() -> Iterator[Setup]:
    """Yield the setups of tools/calibration.toml."""
    fixed: dict[str, Any] = {
        "rim": [(lambda x: low(0, True)(x) | low(1, True)(x), "z")],
        "ends": [(low(0, True), "xyz")],
        "root": [(low(0), "xyz")],
        "foot": [(low(2), "xyz")],
    }
    stored = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    for name, of in stored["setups"].items():
        material = [MATERIALS[each] for each in np.atleast_1d(of["material"])]
        given = {
            "shape": Shape(**stored["shapes"][of["shape"]]),
            "material": tuple(material) if material[1:] else material[0],
            "fixed": fixed.get(of.get("fixed", "")),
        }
        yield Setup(name, **of | given)


# --------------------------------------------------------------------------------------------- run


def rows_in(path: Path) -> list[dict[str, str]]:
    if not path.exists():
        return []
    with path.open() as file:
        return list(csv.DictReader(file))


@cache
def known(column: str) -> dict[tuple[str, str], float]:
    """Return a column of the truths, by body and number."""
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
    """Compute and append the truths that are missing."""
    there = {row["body"] for row in rows_in(TRUTHS_STORED)}
    for setup in (of for of in chosen if of.name not in there):
        kind, part = ("hexahedron20", 1.0) if setup.shape.bricks else ("tetra10", 0.4)
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
    """Return the relative difference; that of a slow rebound is over a share of the velocity."""
    speed = float(np.abs(np.atleast_1d(setup.velocity)[-1]))
    least = LEAST_REBOUND * speed if number == "rebound_velocity" else 0.0
    return abs(value - right) / max(abs(right), least)


def compared(setup: Setup, kind: str, sizes: Sizes) -> dict[str, Any]:
    """Return the numbers of an impact by the default call, with true and estimated errors."""
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
    """Run and append the missing impacts of bodies with truths."""
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

# Line at which the prose of docs/calibration.md ends.
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
