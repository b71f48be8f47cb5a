"""Files of other programs, written from their manuals: what the readers are tried on."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
import scipy.sparse as sp

# Digits after the first that each format prints; 17: all.
PRINTED = {
    "market": 17,
    "market-general": 17,
    "market-array": 17,
    "npz": 17,
    "calculix": 13,
    "abaqus": 15,
    "abaqus-full": 15,
    "labels": 15,
    "coordinate": 15,
    "dmig": 9,
    "op4-text": 15,
    "op4-text-sparse": 15,
    "op4-text-bigmat": 15,
    "op4": 17,
    "op4-big-endian": 17,
    "op4-sparse": 17,
    "op4-bigmat": 17,
    "op4-64": 17,
}


def lower(matrix: Any) -> Any:
    """The lower triangle row by row, as programs write it: the diagonal is the last of each row."""
    rows = sp.csr_array(sp.tril(sp.coo_array(matrix)))
    rows.sum_duplicates()
    return rows.tocoo()


def market(path: Path, matrix: Any, labels: Any) -> None:
    with path.open("wb") as stream:
        scipy.io.mmwrite(stream, sp.coo_array(matrix), symmetry="symmetric", precision=17)


def market_general(path: Path, matrix: Any, labels: Any) -> None:
    with path.open("wb") as stream:
        scipy.io.mmwrite(stream, sp.coo_array(matrix), symmetry="general", precision=17)
    path.write_text(path.read_text().replace("e-", "D-").replace("e+", "D+"))  # as of Fortran


def market_array(path: Path, matrix: Any, labels: Any) -> None:
    with path.open("wb") as stream:
        scipy.io.mmwrite(stream, matrix.toarray(), symmetry="symmetric", precision=17)


def npz(path: Path, matrix: Any, labels: Any) -> None:
    with path.open("wb") as stream:
        sp.save_npz(stream, matrix.tocsr())


def calculix(path: Path, matrix: Any, labels: Any) -> None:
    upper = lower(matrix)
    entries = zip(upper.col + 1, upper.row + 1, upper.data, strict=True)
    path.write_text("".join(f"{i} {j} {value:21.13e}\n" for i, j, value in entries))
    path.with_suffix(".dof").write_text("".join(f"{node}.{c}\n" for node, c in labels))


def coordinate(path: Path, matrix: Any, labels: Any) -> None:
    full = sp.coo_array(matrix)
    entries = zip(full.row + 1, full.col + 1, full.data, strict=True)
    path.write_text("".join(f"{i:10d}{j:10d}  {value:.15e}\n" for i, j, value in entries))


def _nodal(path: Path, matrix: Any, labels: Any, comma: str) -> None:
    lines = ["**", "** WRITTEN BY A TEST"]
    for i, j, value in zip(matrix.row, matrix.col, matrix.data, strict=True):
        words = [*labels[i], *labels[j], f"{value:.15e}"]
        lines.append(f"{comma} ".join(map(str, words)))
    path.write_text("\n".join([*lines, ""]))


def abaqus(path: Path, matrix: Any, labels: Any) -> None:
    _nodal(path, lower(matrix), labels, ",")


def abaqus_full(path: Path, matrix: Any, labels: Any) -> None:
    _nodal(path, sp.coo_array(matrix), labels, ",")


def labels(path: Path, matrix: Any, labels: Any) -> None:
    _nodal(path, lower(matrix), labels, "")


def dmig(path: Path, matrix: Any, labels: Any, name: str = "KAAX") -> None:
    half = lower(matrix).tocsc()
    lines = ["$ a comment", f"DMIG    {name:8}{0:8d}{6:8d}{2:8d}{0:8d}"]
    for j in range(half.shape[1]):
        node, component = labels[j]
        lines.append(f"DMIG*   {name:16}{node:16d}{component:16d}")
        for at in range(half.indptr[j], half.indptr[j + 1]):
            node, component = labels[half.indices[at]]
            value = f"{half.data[at]:.9E}".replace("E", "D").rjust(16)
            lines.append(f"*       {node:16d}{component:16d}{value}")
    path.write_text("\n".join([*lines, ""]))


def strings(column: Any) -> list[tuple[int, Any]]:
    """First row and values of the runs of numbers that are not zero."""
    at = np.flatnonzero(column)
    parts = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
    return [(int(part[0]), column[part]) for part in parts if len(part)]


def op4_text(
    path: Path, matrix: Any, labels: Any, *, big: bool = False, dense: bool = True
) -> None:
    full, n = matrix.toarray(), matrix.shape[0]
    lines = [f"{n:8d}{-n if big else n:8d}{6:8d}{2:8d}{'KAA':8}1P,3E23.15"]

    def numbers(values: Any) -> None:
        printed = [f"{value:23.15E}" for value in values]
        lines.extend("".join(printed[i : i + 3]) for i in range(0, len(printed), 3))

    for j in range(n):
        runs = strings(full[:, j])
        if dense:
            first, last = runs[0][0], runs[-1][0] + len(runs[-1][1])
            lines.append(
                f"{j + 1:8d}{first + 1:8d}{2 * (last - first):8d}"[:16] + f"{last - first:8d}"
            )
            numbers(full[first:last, j])
            continue
        extra = 2 if big else 1
        lines.append(f"{j + 1:8d}{0:8d}{sum(2 * len(v) + extra for _, v in runs):8d}")
        for row, values in runs:
            length = 2 * len(values) + 1
            lines.append(f"{length:8d}{row + 1:8d}" if big else f"{row + 1 + 65536 * length:8d}")
            numbers(values)
    lines += [f"{n + 1:8d}{1:8d}{1:8d}", f"{1.0:23.15E}", ""]
    path.write_text("\n".join(lines))


def op4(
    path: Path,
    matrix: Any,
    labels: Any,
    *,
    order: str = "<",
    big: bool = False,
    dense: bool = True,
    word: int = 4,
) -> None:
    full, n = matrix.toarray(), matrix.shape[0]
    letter = "i" if word == 4 else "q"
    per = 8 // word
    out = bytearray()

    def record(content: bytes) -> None:
        mark = struct.pack(order + "i", len(content))
        out.extend(mark + content + mark)

    def integers(*values: int) -> bytes:
        return struct.pack(f"{order}{len(values)}{letter}", *values)

    def doubles(values: Any) -> bytes:
        return np.asarray(values).astype(f"{order}f8").tobytes()

    record(integers(n, -n if big else n, 6, 2) + b"KAA".ljust(2 * word))
    for j in range(n):
        runs = strings(full[:, j])
        if dense:
            first, last = runs[0][0], runs[-1][0] + len(runs[-1][1])
            content = doubles(full[first:last, j])
            record(integers(j + 1, first + 1, len(content) // word) + content)
            continue
        content = b""
        for row, values in runs:
            length = per * len(values) + 1
            head = integers(length, row + 1) if big else integers(row + 1 + 65536 * length)
            content += head + doubles(values)
        record(integers(j + 1, 0, len(content) // word) + content)
    record(integers(n + 1, 1, per) + doubles([1.0]))
    path.write_bytes(bytes(out))


def _of(function: Callable[..., None], **given: Any) -> Callable[..., None]:
    return lambda path, matrix, labels: function(path, matrix, labels, **given)


WRITERS: dict[str, Callable[[Path, Any, Any], None]] = {
    "market": market,
    "market-general": market_general,
    "market-array": market_array,
    "npz": npz,
    "calculix": calculix,
    "abaqus": abaqus,
    "abaqus-full": abaqus_full,
    "labels": labels,
    "coordinate": coordinate,
    "dmig": dmig,
    "op4-text": op4_text,
    "op4-text-sparse": _of(op4_text, dense=False),
    "op4-text-bigmat": _of(op4_text, dense=False, big=True),
    "op4": op4,
    "op4-big-endian": _of(op4, order=">", dense=False),
    "op4-sparse": _of(op4, dense=False),
    "op4-bigmat": _of(op4, dense=False, big=True),
    "op4-64": _of(op4, word=8, order=">"),
}

# Those that say which dofs their rows are.
LABELLED = ("calculix", "abaqus", "abaqus-full", "labels", "dmig")


def written(kind: str, folder: Path, K: Any, M: Any, labels: Any) -> tuple[Path, Path]:
    """Write both matrices in a format; return their files."""
    suffix = {"calculix": (".sti", ".mas")}.get(kind, (".txt", ".txt"))
    files = folder / f"stiffness{suffix[0]}", folder / f"inertia{suffix[1]}"
    WRITERS[kind](files[0], K, labels)
    WRITERS[kind](files[1], M, labels)
    if kind == "dmig" or kind.startswith("op4"):
        _rename(files[1])
    return files


def _rename(file: Path) -> None:
    file.write_bytes(file.read_bytes().replace(b"KAA", b"MAA"))
