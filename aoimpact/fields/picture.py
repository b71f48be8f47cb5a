"""Pictures of deformed bodies, still and moving, by PyVista, and files that ParaView opens."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..base import (
    FloatArray,
    InputError,
    file_path,
    nonnegative,
    optional_package,
    positive,
    scale_for,
    with_unit,
)
from ..mesh import Mesh, meshio_of_all_kinds

# Largest displacement by default, as a share of the bodies' size: it shows the motion and leaves
# the shape. It is rounded down to a round factor, so that 3 to 8 % are seen.
_SHOWN = 0.08

# Percentile of the stresses with the last colour: those under a contact would leave the rest of the
# body in one colour.
_COLOURED = 98.0

# Pixels; videos need multiples of 16.
_WINDOW = 960, 720

_OTHERWISE = "write files for ParaView: to_vtu(path)"

DOWN = (0.0, 0.0, -1.0)

# Direction to the camera: along two axes across the direction of travel, and against it.
_VIEW = (0.55, -0.75, 0.5)


@dataclass(frozen=True, eq=False)
class Shown:
    """A body in a picture.

    Attributes
    ----------
    mesh : Mesh
    points : ndarray, shape (n_nodes, 3)
        Places of its nodes, undeformed, m.
    displacement : ndarray, shape (k, n_nodes, 3)
        m.
    von_mises : ndarray, shape (k, n_nodes), or None
        Pa; None for a rigid body.
    """

    mesh: Mesh
    points: FloatArray
    displacement: FloatArray
    von_mises: FloatArray | None


def picture(
    bodies: Sequence[Shown],
    times: FloatArray,
    *,
    down: Sequence[float] | FloatArray = DOWN,
    scale: float | None = None,
) -> tuple[Any, Callable[[int], None]]:
    """Return a picture of bodies, and the function that draws them at one of the times.

    Parameters
    ----------
    bodies : sequence of Shown
    times : ndarray, shape (k,)
        s.
    down : sequence of float
        Direction that points down.
    scale : float, optional
        Factor on displacements; by default 1, 2 or 5 times a power of ten that shows them.

    Returns
    -------
    (pyvista.Plotter, callable)

    Raises
    ------
    MissingPackageError
        If PyVista is not installed.
    """
    factor = enlargement(bodies) if scale is None else nonnegative("scale", scale)
    pyvista = optional_package("pyvista", "a picture", _OTHERWISE)
    with pyvista.vtk_verbosity("off"):  # it warns where there is no screen
        plotter = pyvista.Plotter(off_screen=True, window_size=_WINDOW)
        plotter.render()
    largest = [body.von_mises.max(axis=0) for body in bodies if body.von_mises is not None]
    most = float(np.percentile(np.concatenate(largest), _COLOURED)) if largest else 0.0
    pressure, grids = scale_for(most, "Pa"), list[Any]()

    def draw(which: int) -> None:
        for body, grid in zip(bodies, grids, strict=True):
            grid.points = body.points + factor * body.displacement[which]
            if body.von_mises is not None:
                grid.point_data["stress"] = pressure.factor * body.von_mises[which]
        time = with_unit(float(times[which]), "s", 3)
        caption = f"t = {time}     displacement × {factor:g}"
        plotter.add_text(caption, font_size=12, color="black", name="caption")

    for body in bodies:
        cells = [(block.kind, block.cells) for block in body.mesh.blocks]
        grids.append(pyvista.from_meshio(meshio_of_all_kinds().Mesh(body.points, cells)))
        colours: dict[str, Any] = {"color": "lightgray"}
        if body.von_mises is not None:
            grids[-1].point_data["stress"] = pressure.factor * body.von_mises[0]
            colours = {
                "scalars": "stress",
                "clim": (0.0, pressure.factor * most or 1.0),
                "scalar_bar_args": {"title": f"von Mises ({pressure.unit})"},
                "show_edges": True,
                "edge_opacity": 0.35,
            }
        plotter.add_mesh(grids[-1], **colours)
    up = -np.asarray(down) / np.linalg.norm(down)
    across = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    across /= np.linalg.norm(across)
    towards = _VIEW @ np.array([across, np.cross(up, across), up])
    passed = [body.points + factor * body.displacement for body in bodies]
    everywhere = np.concatenate([places.reshape(-1, 3) for places in passed])
    plotter.set_background("white")
    plotter.camera_position = [tuple(towards), (0.0, 0.0, 0.0), tuple(up)]
    plotter.reset_camera(bounds=np.stack([everywhere.min(0), everywhere.max(0)], 1).ravel())
    return plotter, draw


def write_movie(
    path: str | os.PathLike[str],
    fps: float,
    shown: Callable[[], tuple[Sequence[Shown], Sequence[float] | FloatArray]],
    times: FloatArray,
    scale: float | None,
) -> Path:
    """Write a movie of bodies, with the direction that points down, a frame a time.

    Raises
    ------
    MissingPackageError
        If a package that draws or writes it is not installed.
    InputError
        If the path does not end in .gif or .mp4, or its folder is not there.
    """
    file, speed = _in_folder(path), positive("fps", fps, unit="Hz")
    kind = file.suffix.lower()
    if kind not in (".gif", ".mp4"):
        raise InputError(f"path must end in .gif or .mp4, got {str(file)!r}")
    optional_package("pyvista", "a movie", _OTHERWISE)
    optional_package("imageio", "a movie", "draw single pictures: field.plot(which=)")
    if kind == ".mp4":
        optional_package("imageio_ffmpeg", "a movie of type .mp4", "take .gif")
    bodies, down = shown()
    plotter, draw = picture(bodies, times, down=down, scale=scale)
    if kind == ".gif":
        plotter.open_gif(file, fps=speed)
    else:
        plotter.open_movie(file, framerate=speed)
    for which in range(len(times)):
        draw(which)
        plotter.write_frame()
    plotter.close()
    return file


def _in_folder(path: str | os.PathLike[str]) -> Path:
    file = file_path("path", path)
    if not file.parent.is_dir():
        raise InputError(f"path={str(file)!r}: there is no folder {str(file.parent)!r}")
    return file


def enlargement(bodies: Sequence[Shown]) -> float:
    """Return 1, 2 or 5 times a power of ten that makes displacements visible."""
    size = float(np.linalg.norm(np.ptp(np.concatenate([body.points for body in bodies]), axis=0)))
    largest = max(float(np.linalg.norm(body.displacement, axis=-1).max()) for body in bodies)
    if largest == 0.0:
        return 1.0
    exact = _SHOWN * size / largest
    power = 10.0 ** math.floor(math.log10(exact))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= exact * (1.0 + 1e-9))


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
    given = _in_folder(path)
    stem = given.with_suffix("") if given.suffix.lower() in (".vtu", ".pvd") else given
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
