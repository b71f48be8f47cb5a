"""Files cut short, mixed up, exchanged and in other units: named with file, line and cause."""

from __future__ import annotations

import io
import re
import shutil
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from rows import each
from test_matrices import BAR, LABELS, NODES, K, M
from writers import market, written

import aoimpact as ao
from aoimpact import AOImpactWarning

FREE = ao.FEModel.from_mesh(BAR.mesh, ao.Material(E=70e9, nu=0.3, rho=2700.0))


def edited(file: Path, line: int, text: str | None) -> Path:
    """The file with another text in a line, counted from 1; None ends the file before it."""
    lines = file.read_text().splitlines()
    lines = lines[: line - 1] if text is None else [*lines[: line - 1], text, *lines[line:]]
    file.write_text("\n".join([*lines, ""]))
    return file


@each(
    "kind, line, text, named",
    [
        ("market", 50, None, 3),
        ("market", 1000, None, 999),
        ("market", 50, "1 2 x", 50),
        ("market", 50, "1 1 1.0-103", 50),
        ("market", 50, "1 999 1.0", 50),
        ("market", 50, "9 1 1.0 5", 50),
        ("market", 1, "%%MatrixMarket matrix coordinate complex symmetric", 1),
        ("market", 3, "72 72 1000000000000", 3),
        ("market", 3, "72 71 100", 3),
        ("market-array", 3, "900000000 900000000", 3),
        ("calculix", 300, "5 7", 300),
        ("calculix", 300, "5 0 1.0", 300),
        ("calculix", 2, "1 1 5.0", 2),
        ("dmig", 2, "DMIG    KAAX         101       1             103       2 1.0", 2),
        ("dmig", 30, "*   113    2 1.0E+", 30),
        ("abaqus", 300, "101,1, 103,", 300),
        ("abaqus", 300, "101 1 103 2 1.0", 300),
        ("op4-text", 2, "       x       1       9", 2),
    ],
)
def test_a_spoilt_file_is_named_with_its_line(
    kind: str, line: int, text: str | None, named: int, tmp_path: Path
) -> None:
    files = written(kind, tmp_path, K, M, LABELS)
    edited(files[0], line, text)
    with pytest.raises(ao.InputError, match=rf"stiffness\.(txt|sti)', line {named}\b"):
        ao.read_matrices(*files)


@each("share", [0.2, 0.5, 0.9])
@each("kind", ["calculix", "coordinate", "op4", "op4-sparse", "npz", "abaqus"])
def test_a_file_cut_short_is_refused(kind: str, share: float, tmp_path: Path) -> None:
    files = written(kind, tmp_path, K, M, LABELS)
    content = files[0].read_bytes()
    files[0].write_bytes(content[: int(share * len(content))])
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*ends within a line", AOImpactWarning)
        with pytest.raises(ao.InputError, match=r"stiffness\.(txt|sti)"):
            ao.read_matrices(*files)


@each("which", [0, 1])
@each("lines", [1, 2, 30])
@each("kind", ["calculix", "coordinate", "abaqus", "labels", "dmig", "op4-text"])
def test_a_file_without_its_last_lines_is_refused(
    kind: str, lines: int, which: int, tmp_path: Path
) -> None:
    """Cut at the end of a line, where each line is sound; no entry is lost in silence."""
    # In the order of the labels, as these programs write.
    order = np.lexsort(LABELS.T[::-1])
    in_order = [sp.coo_array(sp.csr_array(one)[order][:, order]) for one in (K, M)]
    files = written(kind, tmp_path, *in_order, LABELS[order])
    content = files[which].read_text().splitlines(keepends=True)
    files[which].write_text("".join(content[:-lines]))
    with pytest.raises(ao.InputError, match=r"(stiffness|inertia)\."):
        ao.read_matrices(*files)


def test_of_calculix_s_files_the_one_that_is_short_is_named(tmp_path: Path) -> None:
    stiffness, _ = files = written("calculix", tmp_path, K, M, LABELS)
    dofs = stiffness.with_suffix(".dof")
    whole = dofs.read_text()
    lines = whole.splitlines()
    dofs.write_text("\n".join([*lines[:5], "171", ""]))
    with pytest.raises(ao.InputError, match=r"line 6\b"):
        ao.read_matrices(*files)
    dofs.write_text("\n".join([*lines[:5], ""]))
    with pytest.raises(ao.InputError, match=r"stiffness\.dof"):
        ao.read_matrices(*files)
    dofs.write_text(whole)
    edited(stiffness, 200, None)
    with pytest.raises(ao.InputError, match=r"^dofs.* 27 rows"):
        ao.read_matrices(*files)


def test_a_last_line_without_an_end_is_said(tmp_path: Path) -> None:
    files = written("calculix", tmp_path, K, M, LABELS)
    files[0].write_bytes(files[0].read_bytes()[:-1])
    with pytest.warns(AOImpactWarning, match=r"stiffness\.sti"):
        ao.read_matrices(*files)


@each(
    "kind, given, words",
    [
        *((kind, lambda K, M: (M, K), "^inertia") for kind in ("market", "calculix", "npz")),
        ("op4", lambda K, M: (M, K), "^matrix"),  # by their names
        ("market", lambda K, M: (K, shutil.copy(K, M)), "^stiffness"),
        ("op4", lambda K, M: (K, K), "^matrix"),
        ("op4", lambda K, M: (K,), "^matrix"),
        ("op4", lambda K, M: ((K, "KBB"), M), "^matrix"),
        ("op4", lambda K, M: ((K, "KAA"), (K, "KAA")), "^K"),
        ("market", lambda K, M: (K, smaller(M)), "^stiffness.*72 rows"),
        ("calculix", lambda K, M: (smaller(K, ".dof"), M), "dofs"),
        ("market", lambda K, M: (K.with_name("none.mtx"), M), r"none\.mtx"),
    ],
)
def test_matrices_exchanged_given_twice_or_of_other_models_are_refused(
    kind: str, given: Any, words: str, tmp_path: Path
) -> None:
    stiffness, inertia = written(kind, tmp_path, K, M, LABELS)
    with pytest.raises(ao.InputError, match=words):
        ao.read_matrices(*given(stiffness, inertia))


def smaller(file: Path, end: str = "") -> Path:
    """The file, in place of which, or of the one beside it with another end, stands a short one."""
    if end:
        file.with_suffix(end).write_text("1.1\n1.2\n")
    else:
        market(file, FREE.M, None)
    return file


def test_an_entry_that_is_no_number_is_refused(tmp_path: Path) -> None:
    """It must not pass for a row without stiffness and mass, which is left out."""
    stiffness = sp.lil_array(K)
    stiffness[0, 3] = stiffness[3, 0] = np.nan
    sp.save_npz(tmp_path / "K.npz", sp.csr_array(stiffness))
    sp.save_npz(tmp_path / "M.npz", sp.csr_array(M))
    with pytest.raises(ao.InputError, match="finite"):
        ao.read_matrices(tmp_path / "K.npz", tmp_path / "M.npz")


def test_one_file_with_both_and_names_in_it(tmp_path: Path) -> None:
    stiffness, inertia = written("op4", tmp_path, K, M, LABELS)
    both = tmp_path / "both.op4"
    both.write_bytes(stiffness.read_bytes() + inertia.read_bytes())
    alone = ao.read_matrices(both)
    assert abs(alone.K - ao.read_matrices((both, "kaa"), (both, "MAA")).K).max() == 0.0


def test_other_nodes_are_refused(tmp_path: Path) -> None:
    files = written("abaqus", tmp_path, K, M, LABELS)
    with pytest.raises(ao.InputError, match="nodes"):
        ao.read_matrices(*files, nodes=NODES + np.array([1000.0, 0, 0, 0]))


@each(
    "content",
    [
        b"",
        b"hello\n",
        b"MATLAB 5.0 MAT-file, made by",
        b"PK\x03\x04 no archive",
        b"DMIG    KAAX           0       6       4       0\n",
    ],
)
def test_what_is_no_matrix_is_refused(content: bytes, tmp_path: Path) -> None:
    file = tmp_path / "K.mtx"
    file.write_bytes(content)
    with pytest.raises(ao.InputError, match=r"K\.mtx"):
        ao.read_matrices(file, file)


def test_an_archive_that_promises_too_much_is_refused(tmp_path: Path) -> None:
    """A header of a terabyte."""
    vast = io.BytesIO()
    header = {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**5)}
    np.lib.format.write_array_header_1_0(vast, header)
    with zipfile.ZipFile(tmp_path / "vast.npz", "w") as archive:
        archive.writestr("K.npy", vast.getvalue() + bytes(8000))
    with pytest.raises(ao.InputError, match=r"vast\.npz"):
        ao.read_matrices(tmp_path / "vast.npz", tmp_path / "vast.npz")


# ----------------------------------------------------------------------------- units


def test_millimetres_and_tonnes_are_converted(tmp_path: Path) -> None:
    market(tmp_path / "K.mtx", 1e-3 * FREE.K, None)  # N/mm
    market(tmp_path / "M.mtx", 1e-3 * FREE.M, None)  # t
    files = tmp_path / "K.mtx", tmp_path / "M.mtx"
    body = ao.read_matrices(*files, nodes=1e3 * FREE.nodes, length=1e-3, mass=1e3)
    assert body.mass == pytest.approx(FREE.mass)
    np.testing.assert_allclose(body.nodes, FREE.nodes)
    audit = body.audit()
    np.testing.assert_allclose(audit.centre, (0.05, 0.01, 0.005))
    np.testing.assert_allclose(audit.frequencies, FREE.frequencies(8), rtol=1e-6, atol=1e-3)
    assert audit.density == pytest.approx(2700.0)
    assert max(audit.rigid_residual) < 1e-12
    assert not audit.doubts
    assert "rigid motion rz" in str(audit)


BY_COMPONENT = np.arange(FREE.n_dofs).reshape(-1, 3).T.ravel()


def single(matrix: Any) -> Any:
    """The matrix as single precision holds it."""
    rounded = matrix.astype(np.float32).astype(float)
    return 0.5 * (rounded + rounded.T)


@each(
    "changed, words",
    [
        (lambda K, M, x: (K, M, 1e3 * x), r"waves at 5\.91e\+06 m/s: coordinates in millimetres"),
        (lambda K, M, x: (K / 1e3, M / 1e3, 1e3 * x), "Give length=1e-3 and mass=1e3"),
        (lambda K, M, x: (K / 1e3, M / 1e3, x), r"is 2\.7 kg/m³: M in tonnes .* Give mass=1e3"),
        (lambda K, M, x: (K, M / 1e3, x), "of no solid; K in N/m beside M in tonnes"),
        (lambda K, M, x: (K / 1e3, M, x), "else, K in N/mm beside M in kg"),
        (lambda K, M, x: (K, M, np.random.default_rng(0).permutation(x)), "^K.*order"),
        (lambda K, M, x: (K, M, x * [1.0, 1.3, 1.0]), "^K"),
        (lambda K, M, x: (K[BY_COMPONENT][:, BY_COMPONENT], M, x), "^K"),
        (lambda K, M, x: (single(K), M, x), "^K.*digits"),
    ],
)
def test_wrong_units_order_and_digits_are_said(changed: Any, words: str, tmp_path: Path) -> None:
    stiffness, inertia, nodes = changed(FREE.K, FREE.M, FREE.nodes)
    market(tmp_path / "K.mtx", stiffness, None)
    market(tmp_path / "M.mtx", inertia, None)
    with pytest.warns(AOImpactWarning) as caught:
        ao.read_matrices(tmp_path / "K.mtx", tmp_path / "M.mtx", nodes=nodes)
    assert re.search(words, "\n".join(str(one.message) for one in caught))


def test_waves_are_those_of_the_material() -> None:
    """√((λ + 2μ)/ρ), whatever the elements."""
    exact = np.sqrt(70e9 * (1 - 0.3) / (1 + 0.3) / (1 - 2 * 0.3) / 2700.0)
    for kind in ("tetra10", "wedge", "hexahedron20"):
        mesh = ao.box_mesh((0.3, 0.02, 0.1), (5, 2, 1), kind=kind)
        body = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700.0))
        assert body.audit(frequencies=0).speed == pytest.approx(exact, rel=1e-9)


@each(
    "length, mass, words",
    [
        (1e-3, 1e3, ""),
        (1e-3, 1.0, r"is \S+ kg/m³: M in tonnes and K in N/mm\? Give mass=1e3"),
        (1e-3, 1e6, "M in grams"),
        (1.0, 1.0, "coordinates in millimetres"),
        (1e-6, 1e3, "coordinates in metres"),
    ],
)
def test_units_of_a_body_that_is_held_are_looked_at_too(
    length: float, mass: float, words: str, tmp_path: Path
) -> None:
    market(tmp_path / "K.mtx", 1e-3 * K, None)
    market(tmp_path / "M.mtx", 1e-3 * M, None)
    given = {"nodes": NODES * [1.0, 1e3, 1e3, 1e3], "dofs": LABELS}
    files = tmp_path / "K.mtx", tmp_path / "M.mtx"
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        ao.read_matrices(*files, **given, length=length, mass=mass)
    said = "\n".join(str(one.message) for one in caught)
    assert re.search(words, said) if words else not said


def test_a_body_of_soft_rubber_is_taken_at_its_word() -> None:
    """Its material says what it is; waves at 200 m/s are those of no metal in other units."""
    rubber = ao.FEModel.from_mesh(BAR.mesh, ao.Material(5e6, 0.48, 1100.0), order=2)
    audit = rubber.audit(frequencies=0)
    assert audit.speed == pytest.approx(200.0, rel=0.01)
    assert not audit.doubts


# ----------------------------------------------------------------------- order and digits


@each("nu, digits", [(0.33, 9), (0.25, 10)])
def test_few_digits_are_enough_for_the_elastic_frequencies(nu: float, digits: int) -> None:
    """Rounding leaves rigid motions a stiffness below zero; the elastic ones do not feel it."""
    mesh = ao.box_mesh((0.1, 0.03, 0.01), (10, 3, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=nu, rho=2700.0))
    stiffness = body.K.copy()
    stiffness.data = np.array([float(f"{value:.{digits - 1}e}") for value in stiffness.data])
    rounded = ao.FEModel(K=stiffness, M=body.M, nodes=body.nodes)
    found = rounded.frequencies(8)
    assert found[:6].max() < 20.0
    assert found[6:] == pytest.approx(body.frequencies(8)[6:], rel=1e-5)


# --------------------------------------------------------------- what is left out or put in


def grown(matrix: Any, at: list[tuple[int, int, float]], more: int) -> Any:
    """The matrix with rows and columns added, and entries in them."""
    n = matrix.shape[0] + more
    rows, cols, values = (list(part) for part in zip(*at, strict=True))
    both = (matrix.row.tolist() + rows + cols, matrix.col.tolist() + cols + rows)
    values = matrix.data.tolist() + values + [0.0 if i == j else v for i, j, v in at]
    return sp.coo_array(sp.csr_array(sp.coo_array((values, both), shape=(n, n))))


def test_abaqus_held_dofs_are_left_out(tmp_path: Path) -> None:
    n = len(LABELS)
    K36 = grown(K, [(n, n, 1e36), (n + 1, n + 1, 1e36)], 2)
    M36 = grown(M, [(n, n, 1.0), (n + 1, n + 1, 1.0)], 2)
    labels = np.concatenate([LABELS, [[101, 1], [101, 2]]])
    body = ao.read_matrices(*written("abaqus", tmp_path, K36, M36, labels), nodes=NODES)
    assert body.n_dofs == n
    np.testing.assert_allclose(body.frequencies(4), BAR.frequencies(4), rtol=1e-9)


def test_internal_dofs_without_mass_are_condensed(tmp_path: Path) -> None:
    """A spring k to an internal dof, and another on to the ground, are k/2 to the ground."""
    n, k = len(LABELS), 1e7
    with_two = grown(K, [(n, n, 2 * k), (0, n, -k), (0, 0, k)], 1)
    with_one = grown(K, [(0, 0, 0.5 * k)], 0)
    labels = np.concatenate([LABELS, [[-1, 1]]])
    empty = grown(M, [(n, n, 0.0)], 1)
    empty = sp.coo_array(sp.csr_array(empty)[: n + 1])
    body = ao.read_matrices(*written("abaqus", tmp_path, with_two, empty, labels), nodes=NODES)
    place = {tuple(label): i for i, label in enumerate(body.labels.tolist())}
    rows = [place[tuple(label)] for label in LABELS.tolist()]
    np.testing.assert_allclose(
        body.K[rows][:, rows].toarray(), with_one.toarray(), rtol=1e-12, atol=1.0
    )


def test_displacements_without_mass_are_refused(tmp_path: Path) -> None:
    keep = (M.row != 7) & (M.col != 7)
    light = sp.coo_array((M.data[keep], (M.row[keep], M.col[keep])), shape=M.shape)
    node, component = LABELS[7]
    with pytest.raises(
        ao.InputError, match=rf"1 of 72 dofs have no mass, .* {node}\.{component}: is"
    ):
        ao.read_matrices(*written("abaqus", tmp_path, K, light, LABELS))


@each("units", [(1.0, 1.0), (1e-3, 1e3)])
def test_rotations_scale_with_the_length_squared(
    units: tuple[float, float], tmp_path: Path
) -> None:
    """A cantilever's tip, Euler and Bernoulli: k = EI/l³ (12, -6l; -6l, 4l²), ρA l/420 (...)."""
    EI, line, arm = 210.0, 0.8, 0.5
    length, mass = units
    T = np.diag([1.0, 1.0 / length])  # a moment per angle has one length more
    k = T @ (EI / arm**3 * np.array([[12, -6 * arm], [-6 * arm, 4 * arm**2]])) @ T / mass
    m = T @ (line * arm / 420 * np.array([[156, -22 * arm], [-22 * arm, 4 * arm**2]])) @ T / mass
    labels = np.array([[2, 3], [2, 5]])
    files = written("abaqus", tmp_path, sp.coo_array(k), sp.coo_array(m), labels)
    body = ao.read_matrices(*files, length=length, mass=mass)
    # One cubic element: 3.5327 for 3.5160, and 34.807 for 22.034.
    expected = np.array([3.5327, 34.807]) / arm**2 * np.sqrt(EI / line) / (2 * np.pi)
    np.testing.assert_allclose(body.frequencies(2), expected, rtol=2e-5)
    tip = body.contact(node=2, direction=(0, 0, 1))
    assert ao.antioscillators(tip, n=1).k0 == pytest.approx(3 * EI / arm**3, rel=1e-9)
