"""Damaged matrix files of every format, with files of their rows' dofs and of nodes."""

from __future__ import annotations

import random
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import meshio
import numpy as np

import aoimpact as ao

from .inputs import trials
from .mutate import damaged

_WRITERS = Path(__file__).parents[2] / "tests" / "io" / "writers.py"

_NAMED = re.compile(
    r"\b(K|M|dofs|nodes|labels|stiffness|inertia|mesh|material)\b|matrix file|mesh file"
)

_MATERIAL = ao.Material(E=70e9, nu=0.3, rho=2700.0)

# Beginnings of files of other programs.
_OTHERS = [b"MATLAB 5.0 MAT-file, Platform: GLNXA64", b"\x89HDF\r\n\x1a\n", b"\x93NUMPY\x01\x00"]
_OTHERS += [b"*MATRIX,TYPE=STIFFNESS\n", b"\x0c\x00\x00\x00NASTRAN FORT TAPE ID CODE - "]
_OTHERS += [b"**\n** ELEMENT NUMBER 1\n", b""]


@dataclass(frozen=True)
class Seed:
    """Sound files of one model by name, and the name of the file for each keyword."""

    files: dict[str, bytes]
    keywords: dict[str, str]


@dataclass(frozen=True)
class Given:
    """Files, some of them damaged, by the keywords of `read_matrices`."""

    keywords: dict[str, Path]

    def run(self) -> None:
        material = _MATERIAL if "mesh" in self.keywords else None
        body = ao.read_matrices(**self.keywords, material=material)  # type: ignore[arg-type]
        audit = body.audit(frequencies=min(3, body.n_dofs))
        if not np.isfinite(audit.frequencies).all():
            raise ArithmeticError(f"frequencies are not finite: {audit.frequencies}")

    def named(self, message: str) -> bool:
        return _NAMED.search(message) is not None


def seeds(folder: Path) -> list[Seed]:
    """Return sound files of every format, of a free block and of a held one."""
    writers, rng = SimpleNamespace(**run_path(str(_WRITERS))), random.Random(1)
    found = []
    for fixed in (None, [("xmin", "xyz")]):
        mesh = ao.box_mesh((0.1, 0.02, 0.01), (2, 1, 1))
        body = ao.FEModel.from_mesh(mesh, _MATERIAL, fixed=fixed)
        solid = meshio.Mesh(np.array(mesh.nodes), [(mesh.kind, np.array(mesh.cells))])
        assert body.free is not None
        assert body.nodes is not None
        labels = np.stack([1 + body.free // 3, 1 + body.free % 3], axis=1)
        nodes = "".join(f"{i + 1}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(body.nodes))
        for kind in writers.WRITERS:
            with tempfile.TemporaryDirectory() as name:
                place = Path(name)
                stiffness, inertia = writers.written(
                    kind, place, body.K.tocoo(), body.M.tocoo(), labels
                )
                keywords = {"K": stiffness.name, "M": inertia.name, "nodes": "nodes.inp"}
                (place / "nodes.inp").write_text("*NODE\n" + nodes)
                if rng.random() < 0.3:
                    solid.write(place / "box.vtu")
                    keywords["mesh"] = "box.vtu"
                if kind not in writers.LABELLED:
                    (place / "rows.txt").write_text("".join(f"{n}.{c}\n" for n, c in labels))
                    keywords["dofs"] = "rows.txt"
                found.append(
                    Seed({one.name: one.read_bytes() for one in place.iterdir()}, keywords)
                )
    return found


def make(rng: random.Random, sound: list[Seed], folder: Path) -> Given:
    """Write the files of one model, one or two of them damaged."""
    seed, other = rng.choice(sound), rng.choice(sound)
    files = dict(seed.files)
    wrong = [seed.keywords["K" if rng.random() < 0.6 else rng.choice(sorted(seed.keywords))]]
    if rng.random() < 0.2:
        wrong.append(rng.choice(sorted(files)))
    for name in wrong:
        content = damaged(rng, files[name], other.files[rng.choice(sorted(other.files))])
        if rng.random() < 0.02:
            content = rng.choice(_OTHERS) + rng.randbytes(rng.choice((0, 8, 200)))
        files[name] = content
    for name, data in files.items():
        (folder / name).write_bytes(data)
    keywords = {key: folder / name for key, name in seed.keywords.items()}
    if rng.random() < 0.2:
        keywords.pop(rng.choice(sorted(set(keywords) - {"K"})))
    return Given(keywords)


trial = trials(seeds, make)
