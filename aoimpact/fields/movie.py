"""Moving pictures of deformed bodies, by PyVista without a window."""

from __future__ import annotations

import importlib
import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..base import (
    AOImpactError,
    FloatArray,
    InputError,
    IntArray,
    Scale,
    file_path,
    nonnegative,
    optional_package,
    positive,
    scale_for,
    with_unit,
)
from ..mesh import Mesh
from .deformed import outlines

# By itself the largest displacement is drawn as this share of the picture's bodies, rounded down to
# a round factor: 3 to 8 % show the motion and leave the shape.
_SHOWN = 0.08

# Stresses above this share of all that are shown keep the colour of it: those under the contact
# would leave the rest of the body in one colour.
_COLOURED = 98.0

# Frames from which a file with 256 colours takes these.
_SAMPLED = 16

# Pixels; a video needs multiples of 16.
_WIDE, _HIGH = 960, 720

# Where the time stands, and how far the bodies are moved to the left to make room for the colours.
_CORNER, _LEFT = (16, 676), 0.1

# How long a trial picture may take on a busy machine, s.
_PATIENCE = 300.0

# From where the bodies are looked at: two axes across the direction of travel, and from above.
_VIEW = (0.55, -0.75, 0.5)


@dataclass(frozen=True, eq=False)
class MovingBody:
    """The picture of a body.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        Of its surface, undeformed and in its place, m.
    faces : list of arrays
        Numbers of the points around each face.
    displacement : ndarray, shape (k, n, 3)
        m.
    von_mises : ndarray, shape (k, n), or None
        Pa; None of a rigid body.
    """

    points: FloatArray
    faces: Sequence[IntArray]
    displacement: FloatArray
    von_mises: FloatArray | None

    @classmethod
    def of_mesh(
        cls,
        mesh: Mesh,
        displacement: FloatArray,
        von_mises: FloatArray | None,
        placed: Callable[[FloatArray], FloatArray] = lambda vectors: vectors,
        shift: FloatArray | float = 0.0,
    ) -> MovingBody:
        """Return the surface of a mesh; `placed` turns its vectors, and `shift` moves it then.

        Parameters
        ----------
        mesh : Mesh
        displacement : ndarray, shape (k, n_nodes, 3)
        von_mises : ndarray, shape (k, n_nodes), or None
        placed : callable, optional
        shift : ndarray, shape (3,), optional
        """
        faces = outlines(mesh)
        used, numbers = np.unique(np.concatenate(faces), return_inverse=True)
        parts = np.split(numbers, np.cumsum([len(face) for face in faces])[:-1])
        return cls(
            placed(mesh.nodes[used]) + shift,
            parts,
            placed(displacement[:, used]),
            None if von_mises is None else von_mises[:, used],
        )


def movie_path(path: str | os.PathLike[str]) -> Path:
    """Return the path of a movie, which must end in .gif or .mp4 and lie in a folder that is there.

    Raises
    ------
    InputError
        If not.
    """
    file = file_path("path", path)
    if file.suffix.lower() not in (".gif", ".mp4"):
        raise InputError(f"path must end in .gif or .mp4, got {str(file)!r}")
    if not file.parent.is_dir():
        raise InputError(f"path={str(file)!r}: there is no folder {str(file.parent)!r}")
    return file


def write_movie(
    path: str | os.PathLike[str],
    bodies: Sequence[MovingBody],
    times: FloatArray,
    *,
    down: FloatArray,
    scale: float | None = None,
    fps: float = 15.0,
) -> Path:
    """Draw bodies at some times and write them as a movie.

    Parameters
    ----------
    path : path
        Ending in .gif or .mp4.
    bodies : sequence of MovingBody
    times : ndarray, shape (k,)
        s; a frame each.
    down : ndarray, shape (3,)
        What points down in the picture.
    scale : float, optional
        How many times displacements are enlarged.
    fps : float, optional
        Frames a second.

    Returns
    -------
    Path

    Raises
    ------
    MissingPackageError
        If PyVista or, for .mp4, imageio and imageio-ffmpeg are not installed.
    InputError
        If the path is no place for a movie.
    AOImpactError
        If this machine cannot draw in three dimensions.
    """
    file = movie_path(path)
    speed = positive("fps", fps, unit="Hz")
    factor = enlargement(bodies) if scale is None else nonnegative("scale", scale)
    otherwise = "write files for ParaView, body.to_vtu(path)"
    pyvista = optional_package("pyvista", "movie", otherwise)
    video = file.suffix.lower() == ".mp4"
    if video:
        for name in ("imageio", "imageio_ffmpeg"):
            optional_package(name, "a movie of type .mp4", "take .gif")
        imageio = importlib.import_module("imageio.v3")
    if not can_draw():
        raise AOImpactError(
            "movie: this machine cannot draw in three dimensions without a window; install EGL or "
            "OSMesa (Debian: libegl1, libosmesa6), or write files for ParaView, body.to_vtu(path)"
        )
    with pyvista.vtk_verbosity("off"):
        frames = list(_frames(pyvista, bodies, times, factor, down))
    if video:
        imageio.imwrite(file, frames, fps=speed, plugin="FFMPEG", macro_block_size=16)
    else:
        _write_gif(file, frames, speed)
    return file


def _write_gif(file: Path, frames: Sequence[Any], speed: float) -> None:
    """Write pictures with the same 256 colours, so that none changes its colour in between."""
    from PIL import Image  # of matplotlib

    sample = np.concatenate(frames[:: max(1, len(frames) // _SAMPLED)])
    palette = Image.fromarray(sample).quantize(256)
    pictures = [
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    ]
    lasting = 1000.0 / speed
    first, others = pictures[0], pictures[1:]
    first.save(file, save_all=True, append_images=others, duration=lasting, loop=0)


@cache
def can_draw() -> bool:
    """Return whether a picture can be drawn, as tried in another process: VTK crashes if not."""
    trial = (
        "import pyvista; plotter = pyvista.Plotter(off_screen=True, window_size=(64, 48));"
        "plotter.add_mesh(pyvista.Cube()); plotter.screenshot(return_img=True)"
    )
    command = [sys.executable, "-c", trial]
    done = subprocess.run(command, capture_output=True, check=False, timeout=_PATIENCE)
    return done.returncode == 0


def enlargement(bodies: Sequence[MovingBody]) -> float:
    """Return 1, 2 or 5 times a power of ten that makes displacements visible."""
    everything = np.concatenate([body.points for body in bodies])
    size = float(np.linalg.norm(np.ptp(everything, axis=0)))
    largest = max(float(np.linalg.norm(body.displacement, axis=-1).max()) for body in bodies)
    if largest == 0.0:
        return 1.0
    exact = _SHOWN * size / largest
    power = 10.0 ** math.floor(math.log10(exact))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= exact * (1.0 + 1e-9))


def _frames(
    pyvista: Any,
    bodies: Sequence[MovingBody],
    times: FloatArray,
    factor: float,
    down: FloatArray,
) -> Iterator[Any]:
    """Pictures, one a time, arrays of shape (height, width, 3)."""
    plotter = pyvista.Plotter(off_screen=True, window_size=(_WIDE, _HIGH))
    try:
        pressure, most = _pressure(bodies)
        drawn = [_added(plotter, pyvista, body, pressure, most) for body in bodies]
        _look(plotter, bodies, factor, down)
        for i, time in enumerate(times):
            for body, mesh in zip(bodies, drawn, strict=True):
                mesh.points = body.points + factor * body.displacement[i]
                if body.von_mises is not None:
                    mesh.point_data["stress"] = pressure.factor * body.von_mises[i]
            caption = f"t = {with_unit(float(time), 's', 3)}     displacement × {factor:g}"
            plotter.add_text(caption, position=_CORNER, font_size=12, color="black", name="text")
            yield np.array(plotter.screenshot(return_img=True))
    finally:
        plotter.close()


def _pressure(bodies: Sequence[MovingBody]) -> tuple[Scale, float]:
    """The unit of the stresses, and the largest one that has a colour of its own, in it."""
    largest = [body.von_mises.max(axis=0) for body in bodies if body.von_mises is not None]
    if not largest:
        return Scale(1.0, "Pa"), 1.0
    most = float(np.percentile(np.concatenate(largest), _COLOURED))
    pressure = scale_for(most, "Pa")
    return pressure, pressure.factor * most or 1.0


def _added(plotter: Any, pyvista: Any, body: MovingBody, pressure: Scale, most: float) -> Any:
    """Put a body into the picture, and return its surface, to be moved."""
    around = np.concatenate([np.concatenate([[len(face)], face]) for face in body.faces])
    mesh = pyvista.PolyData(np.array(body.points, dtype=float), faces=around)
    if body.von_mises is None:
        plotter.add_mesh(mesh, color="lightgray", smooth_shading=True)
        return mesh
    mesh.point_data["stress"] = pressure.factor * body.von_mises[0]
    plotter.add_mesh(
        mesh,
        scalars="stress",
        clim=(0.0, most),
        cmap="viridis",
        ambient=0.4,
        diffuse=0.6,
        show_edges=True,
        edge_color="dimgray",
        edge_opacity=0.35,
        line_width=0.5,
        scalar_bar_args={
            "title": f"von Mises\n({pressure.unit})\n",
            "vertical": True,
            "position_x": 0.86,
            "position_y": 0.15,
            "height": 0.7,
            "width": 0.07,
            "n_labels": 5,
            "fmt": "%.3g",
            "color": "black",
            "title_font_size": 20,
            "label_font_size": 18,
        },
    )
    return mesh


def _look(plotter: Any, bodies: Sequence[MovingBody], factor: float, down: FloatArray) -> None:
    """Look at all places that the bodies pass, with `down` pointing down."""
    plotter.set_background("white")
    up = -down / np.linalg.norm(down)
    least = np.zeros(3)
    least[np.argmin(np.abs(up))] = 1.0
    across = np.cross(up, least)
    across /= np.linalg.norm(across)
    basis = np.array([across, np.cross(up, across), up])
    passed = [body.points + factor * body.displacement for body in bodies]
    low = np.min([places.min(axis=(0, 1)) for places in passed], axis=0)
    high = np.max([places.max(axis=(0, 1)) for places in passed], axis=0)
    bounds = np.column_stack([low, high]).ravel()
    towards = _VIEW @ basis
    plotter.camera_position = [tuple(towards), (0.0, 0.0, 0.0), tuple(up)]
    plotter.reset_camera(bounds=bounds)
    plotter.camera.zoom(1.12)
    plotter.camera.SetWindowCenter(_LEFT, 0.0)
