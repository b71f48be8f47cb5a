"""Fields over time as files that ParaView opens: one .vtu a time, and a .pvd that lists them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..base import FloatArray, InputError, file_path
from ..mesh import Mesh, meshio_of_all_kinds


def write_series(
    path: str | os.PathLike[str],
    mesh: Mesh,
    times: FloatArray,
    data: Mapping[str, FloatArray],
    of_cells: Mapping[str, FloatArray] | None = None,
) -> Path:
    """Write data at the nodes, and return the path of the .pvd file.

    Parameters
    ----------
    path : path
        Its suffix, .vtu or .pvd or none, does not count.
    mesh : Mesh
    times : ndarray, shape (k,)
        s; the timesteps that ParaView shows.
    data : mapping of str to ndarray, shape (k, n_nodes, ...)
    of_cells : mapping of str to ndarray, shape (k, n_cells), optional
        Data of the elements.

    Raises
    ------
    InputError
        If the folder is not there.
    """
    from xml.sax.saxutils import quoteattr  # would bring urllib and ssl with it

    meshio = meshio_of_all_kinds()
    given = file_path("path", path)
    stem = given.with_suffix("") if given.suffix.lower() in (".vtu", ".pvd") else given
    if not stem.parent.is_dir():
        raise InputError(f"path={str(given)!r}: there is no folder {str(stem.parent)!r}")
    digits = len(str(len(times) - 1))
    names = [f"{stem.name}_{i:0{digits}d}.vtu" for i in range(len(times))]
    for i, name in enumerate(names):
        # Double precision in binary: what is read back is what was written, to the last bit.
        meshio.Mesh(
            mesh.nodes,
            [(block.kind, block.cells) for block in mesh.blocks],
            point_data={key: np.ascontiguousarray(values[i]) for key, values in data.items()},
            cell_data={
                key: [values[i, block.numbers] for block in mesh.blocks]
                for key, values in (of_cells or {}).items()
            },
        ).write(stem.parent / name, file_format="vtu", binary=True)
    entries = [
        f'    <DataSet timestep="{float(time)!r}" group="" part="0" file={quoteattr(name)}/>'
        for time, name in zip(times, names, strict=True)
    ]
    head = '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">'
    lines = ['<?xml version="1.0"?>', head, "  <Collection>", *entries, "  </Collection>"]
    listing = stem.parent / f"{stem.name}.pvd"
    listing.write_text("\n".join([*lines, "</VTKFile>", ""]), encoding="utf-8")
    return listing
