"""Displacement, velocity and stress of a whole body at chosen times, pictures and files."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..base import (
    FilePath,
    FloatArray,
    InputError,
    choice,
    file_path,
    integer,
    nonnegative,
    optional_package,
    positive,
    scale_for,
    sp,
    warn,
    with_unit,
)
from ..fem import (
    AnyMaterial,
    FEModel,
    Stress,
    beam_von_mises,
    body_stress_rows,
    checked_layer,
    gauss_stress,
    nodal_stress,
    thickness_of_cells,
)
from ..mesh import Mesh, meshio_of_all_kinds, plane_of

# Default ratio of the largest drawn displacement to the bodies' size, which shows the motion and
# keeps the shape recognisable. The factor on displacements is rounded down, so that the ratio is
# .03 to .08.
_SHOWN = 0.08

# Percentile of stress at which the colours end: if they ended at the peak under a contact, the rest
# of the body would be in one colour.
_COLOURED = 98.0

# Size of a picture, pixels; videos need multiples of 16.
_WINDOW = 960, 720

_OTHERWISE = "write files for ParaView: to_vtu(path)"

DOWN = (0.0, 0.0, -1.0)

# Direction to the camera: components along two axes perpendicular to `down`, and against `down`.
_VIEW = (0.55, -0.75, 0.5)


@dataclass(frozen=True, eq=False)
class Shown:
    """A body in a picture.

    Attributes
    ----------
    mesh : Mesh
    points : ndarray, shape (n_nodes, 3)
        Coordinates of the undeformed mesh's nodes, m.
    displacement : ndarray, shape (k, n_nodes, 3)
        Displacement of the nodes at k times, m.
    von_mises : ndarray, shape (k, n_nodes)
        Von Mises stress, Pa; NaN for a rigid body.
    """

    mesh: Mesh
    points: FloatArray
    displacement: FloatArray
    von_mises: FloatArray


def picture(
    bodies: Sequence[Shown],
    times: FloatArray,
    *,
    down: Sequence[float] | FloatArray = DOWN,
    scale: float | None = None,
) -> tuple[Any, Callable[[int], None]]:
    """Return a picture of bodies, and the function that draws the bodies at one of the times.

    Parameters
    ----------
    bodies : sequence of Shown
    times : ndarray, shape (k,)
        Times, s.
    down : sequence of float
        Direction that points down.
    scale : float, optional
        Factor on displacements; by default that of `enlargement`.

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
    with pyvista.vtk_verbosity("off"):  # VTK warns if there is no screen
        plotter = pyvista.Plotter(off_screen=True, window_size=_WINDOW)
        plotter.render()
    largest = np.concatenate([body.von_mises.max(axis=0) for body in bodies])
    most = float(np.nanpercentile(largest, _COLOURED))
    (pressure, unit), grids = scale_for(most, "Pa"), list[Any]()

    def draw(which: int) -> None:
        for body, grid in zip(bodies, grids, strict=True):
            grid.points = body.points + factor * body.displacement[which]
            grid.point_data["stress"] = pressure * body.von_mises[which]
        time = with_unit(float(times[which]), "s", 3)
        caption = f"t = {time}     displacement × {factor:g}"
        plotter.add_text(caption, font_size=12, color="black", name="caption")

    for body in bodies:
        cells = [(block.kind, block.cells) for block in body.mesh.blocks]
        grids.append(pyvista.from_meshio(meshio_of_all_kinds().Mesh(body.points, cells)))
        grids[-1].point_data["stress"] = pressure * body.von_mises[0]
        plotter.add_mesh(
            grids[-1],
            scalars="stress",
            clim=(0.0, pressure * most or 1.0),
            nan_color="lightgray",
            scalar_bar_args={"title": f"von Mises ({unit})"},
            show_edges=True,
            edge_opacity=0.35,
        )
    up = -np.asarray(down) / np.linalg.norm(down)
    towards = _VIEW @ np.vstack([plane_of(up), up])
    passed = [body.points + factor * body.displacement for body in bodies]
    everywhere = np.concatenate([places.reshape(-1, 3) for places in passed])
    plotter.set_background("white")
    plotter.camera_position = [tuple(towards), (0.0, 0.0, 0.0), tuple(up)]
    plotter.reset_camera(bounds=np.stack([everywhere.min(0), everywhere.max(0)], 1).ravel())
    return plotter, draw


def write_movie(
    path: FilePath,
    fps: float,
    shown: Callable[[], tuple[Sequence[Shown], Sequence[float] | FloatArray]],
    times: FloatArray,
    scale: float | None,
) -> Path:
    """Write a movie with one frame per time; `shown` returns the bodies and the direction down.

    Raises
    ------
    MissingPackageError
        If a package that draws or writes movies is not installed.
    InputError
        If the path does not end in .gif or .mp4, or its folder does not exist.
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


def _in_folder(path: FilePath) -> Path:
    file = file_path("path", path)
    if not file.parent.is_dir():
        raise InputError(f"path={str(file)!r}: there is no folder {str(file.parent)!r}")
    return file


def enlargement(bodies: Sequence[Shown]) -> float:
    """Return the factor, 1, 2 or 5 times a power of ten, that makes displacements visible."""
    size = float(np.linalg.norm(np.ptp(np.concatenate([body.points for body in bodies]), axis=0)))
    largest = max(float(np.linalg.norm(body.displacement, axis=-1).max()) for body in bodies)
    if largest == 0.0:
        return 1.0
    exact = _SHOWN * size / largest
    power = 10.0 ** math.floor(math.log10(exact))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= exact * (1.0 + 1e-9))


def write_series(
    path: FilePath,
    mesh: Mesh,
    times: FloatArray,
    data: Mapping[str, FloatArray],
    of_cells: Mapping[str, FloatArray] | None = None,
) -> Path:
    """Write data at the nodes, and return the path of the .pvd file.

    Parameters
    ----------
    path : path
        File name, of which a suffix .vtu or .pvd is ignored.
    mesh : Mesh
    times : ndarray, shape (k,)
        Times that ParaView shows, s.
    data : mapping of str to ndarray, shape (k, n_nodes, ...)
    of_cells : mapping of str to ndarray, shape (k, n_cells), optional
        Data of the elements.

    Raises
    ------
    InputError
        If the folder does not exist.
    """
    from xml.sax.saxutils import quoteattr  # its import loads urllib and ssl

    meshio = meshio_of_all_kinds()
    given = _in_folder(path)
    stem = given.with_suffix("") if given.suffix.lower() in (".vtu", ".pvd") else given
    digits = len(str(len(times) - 1))
    names = [f"{stem.name}_{i:0{digits}d}.vtu" for i in range(len(times))]
    for i, name in enumerate(names):
        # Binary data in double precision are read back bit for bit.
        meshio.Mesh(
            mesh.nodes,
            [(block.kind, block.cells) for block in mesh.blocks],
            point_data={key: np.ascontiguousarray(values[i]) for key, values in data.items()},
            cell_data={
                key: [values[i, block.numbers] for block in mesh.blocks]
                for key, values in (of_cells or {}).items()
            },
        ).write(stem.parent / name, file_format="vtu", binary=True)
    entries = "".join(
        f'<DataSet timestep="{float(time)!r}" part="0" file={quoteattr(name)}/>\n'
        for time, name in zip(times, names, strict=True)
    )
    head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"><Collection>'
    listing = stem.parent / f"{stem.name}.pvd"
    listing.write_text(f"{head}\n{entries}</Collection></VTKFile>\n", encoding="utf-8")
    return listing


# Relative error of a history above which a warning is issued.
_BADLY_WRONG = 0.2

# Number of evenly spaced times of a record at which the largest value of a history is searched.
LOOKS = 200


@dataclass(frozen=True, eq=False)
class Field:
    """Motion and stress of a whole body at some times.

    Attributes
    ----------
    body : FEModel
    times : ndarray, shape (k,)
        Times, s.
    displacement, velocity, rotation : ndarrays, shape (k, n_nodes, 3)
        Motion of the nodes: m, m/s and, for the nodes of shells and beams, rad.

    Notes
    -----
    `error` is in the norm of strain energy, relative to the largest norm over the record. The
    contact force may be accurate although this error is large: a model fitted to a short contact
    need not vibrate as the body does after the contact. The errors of mesh and contact
    (`Result.error`) come in addition.
    """

    body: FEModel
    times: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    rotation: FloatArray
    # _response: `Response` that computes the field. _dofs: displacements of all nodes' dofs,
    # (k, dofs).
    _response: Any = field(repr=False)
    _dofs: FloatArray = field(repr=False)

    @cached_property
    def error(self) -> FloatArray | None:
        """Error due to the body's model, relative to the largest norm over the record, (k,).

        The error is the difference from the run with other elements; None for a full model.
        """
        found: FloatArray | None = self._response.field_error(self.times)
        return found

    def __repr__(self) -> str:
        times = ", ".join(f"{time:.6g}" for time in self.times[:4])
        more = ", …" if len(self.times) > 4 else ""
        return f"Field(t = {times}{more} s of {self.body!r})"

    def stress(self, at: str = "nodes", *, layer: Any = None, part: str | None = None) -> Stress:
        """Return the stress.

        The local stress under a contact of solids is that of Hertz's pressure in closed form; the
        rest is that of the elements.

        Parameters
        ----------
        at : {"nodes", "gauss"}, optional
            "nodes": extrapolated from the Gauss points and averaged over the elements at a node, of
            the stiffest material where materials meet; components of shape (k, n_nodes, 6).
            "gauss": at the Gauss points of the elements' stiffness; components of shape
            (k, n_cells, n_gauss, 6), nan for points that an element of a mixed mesh does not have.
            Shells and beams have only "nodes".
        layer : str, (int, str) or (float, float), optional
            Place within shells: "top" (the default), to which the elements' normals point, "middle"
            or "bottom". (3, "bottom") is the lower face of the fourth ply from the bottom, with
            stress along the ply's axes, xx along the fibres, and nan where there is no such ply.
            Place within beams: by default that of the largest von Mises stress in the section;
            "top" and "bottom" are the sides along the section's z axis, "left" and "right" those
            along y, "middle" is the centroid, and (y, z) any point of the section, m. A round beam
            without an orientation has no sides.
        part : str, optional
            Group of elements whose stress is taken, with nan at other nodes: a stiffener on a skin,
            or one of several members at a joint. By default, nodes of shells and beams have the
            stress of the stiffest shell, nodes of several beams that of the most stressed member.

        Raises
        ------
        InputError
            If the body was given by K and M, without elements and material, or there is no such
            `layer` or `part`.

        Warns
        -----
        AOImpactWarning
            If the stress computed by a reduced model may be badly wrong; see `error`.

        Notes
        -----
        The stress of a beam is due to axial force, bending about both axes, torsion and shear
        force. The stress is exact for round and rectangular sections in torsion (Saint-Venant), and
        by Zhuravskii's formula in shear. A `BeamSection` has only direct stress, at its points.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(0.01), ao.antioscillators(tip, 4), 0.1, law=ao.Linear(k=1e5))
        >>> stress = hit.target.field([1e-4]).stress()
        >>> stress.von_mises.shape == (1, len(bar.nodes))
        True
        """
        warn_if_wrong("stress", self.times, self.error)
        place = choice("at", at, ("nodes", "gauss"))
        of = self._response.body
        _, material = solid(of, "stress")
        where, mesh = checked_layer(layer, part), of.shapes
        if mesh.thin or part is not None:
            if place != "nodes":
                raise InputError(f'at={at!r}: stress of shells and beams is known at="nodes"')
            nodes: Any = self.body.nodes
            every = sp.eye_array(len(nodes), mesh.cells.max() + 1, format="csr")
            found_at = body_stress_rows(mesh, material, every, where)
            return Stress(found_at.components(found_at.rows @ self._dofs.T), nodes)
        evaluate = nodal_stress if place == "nodes" else gauss_stress
        moved = self._dofs.reshape(len(self.times), 2, -1, 3)[:, 0]
        found = evaluate(mesh, material, moved)
        places = found.points.reshape(-1, 3)
        added = self._response.half_space(places, self.times, rates=False)[2]
        return Stress(found.components + added.reshape(found.components.shape), found.points)

    def to_vtu(self, path: FilePath) -> Path:
        """Write one .vtu file for each time, and a .pvd file that lists them, for ParaView.

        Data of the nodes: displacement (m), velocity (m/s), stress (xx, yy, zz, xy, yz, xz),
        von_mises and principal, all Pa. Shells and beams also have rotation (rad), stress_middle
        and stress_bottom; their stress is on the top of shells and where it is largest in beams.
        Data of the elements: thickness (m) of shells, and von_mises_of_beams (Pa), the largest in
        each element.

        Parameters
        ----------
        path : path
            "beam", "beam.vtu" or "beam.pvd" gives beam.pvd and beam_0.vtu, beam_1.vtu …, in an
            existing folder.

        Returns
        -------
        Path
            The .pvd file.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(0.01), ao.antioscillators(tip, 4), 0.1, law=ao.Linear(k=1e5))
        >>> hit.target.field([1e-4]).to_vtu(folder / "bar").name
        'bar.pvd'
        """
        mesh, material = solid(self.body, "to_vtu")
        stress = self.stress()
        data = {
            "displacement": self.displacement,
            "velocity": self.velocity,
            "stress": stress.components,
            "von_mises": stress.von_mises,
            "principal": stress.principal,
        }
        if not mesh.thin:
            return write_series(path, mesh, self.times, data)
        data["rotation"] = self.rotation
        for side in ("middle", "bottom"):
            data[f"stress_{side}"] = self.stress(layer=side).components
        of, of_beams = self._response.body, np.zeros((len(self.times), mesh.n_cells))
        of_parts = beam_von_mises(of.shapes, of.material, self._dofs)
        np.maximum.at(of_beams.T, of.parent, of_parts.T)
        thickness = np.broadcast_to(thickness_of_cells(mesh, material), of_beams.shape)
        own = {"thickness": thickness, "von_mises_of_beams": of_beams}
        return write_series(path, mesh, self.times, data, own)

    def _shown(self) -> Shown:
        """Return the body as it is drawn, without its mean displacement if it has no support."""
        mesh, _ = solid(self.body, "a picture")
        moved, free = self.displacement, self.body.free
        if free is None or np.count_nonzero(free < moved[0].size) == moved[0].size:
            moved = moved - moved.mean(axis=1, keepdims=True)
        return Shown(mesh, mesh.nodes, moved, self.stress().von_mises)

    def plot(self, *, which: int = 0, scale: float | None = None) -> Any:
        """Draw the deformed body, coloured by von Mises' stress.

        Enlargement and colours are the same at all times of the field. The mean displacement of a
        body without supports is left out, as the body would otherwise fly out of the picture.

        Parameters
        ----------
        which : int, optional
            Index of the time.
        scale : float, optional
            Factor on displacements; by default 1, 2 or 5 times a power of ten that shows the
            largest of all times.

        Returns
        -------
        pyvista.Plotter
            Without a window: ``.screenshot("bar.png")`` writes the picture.

        Raises
        ------
        MissingPackageError
            If PyVista is not installed.
        InputError
            If the body has no elements.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(0.01), ao.antioscillators(tip, 4), 0.1, law=ao.Linear(k=1e5))
        >>> hit.target.field([1e-4]).plot().screenshot("bar.png")  # doctest: +SKIP
        """
        number = integer("which", which, low=0, high=len(self.times) - 1)
        plotter, draw = picture([self._shown()], self.times, scale=scale)
        draw(number)
        return plotter

    def movie(self, path: FilePath, *, scale: float | None = None, fps: float = 15.0) -> Path:
        """Write a movie of the body with one frame per time, drawn as in `plot`.

        `Result.movie` shows both bodies of an impact.

        Parameters
        ----------
        path : path
            Ending in .gif or .mp4.
        scale : float, optional
            As in `plot`.
        fps : float, optional
            Frames per second.

        Returns
        -------
        Path

        Raises
        ------
        MissingPackageError
            If PyVista, imageio or, for .mp4, imageio-ffmpeg are not installed.
        InputError
            If the body has no elements, or no movie can be written to the path.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(0.01), ao.antioscillators(tip, 4), 0.1, law=ao.Linear(k=1e5))
        >>> field = hit.target.field([1e-4, 2e-4])
        >>> path = field.movie("bar.gif")  # doctest: +SKIP
        """
        return write_movie(path, fps, lambda: ([self._shown()], DOWN), self.times, scale)


def solid(body: FEModel, what: str) -> tuple[Mesh, AnyMaterial]:
    """Return the body's mesh and material; raise InputError, naming `what`, if it has none."""
    if body.mesh is None or body.material is None:
        raise InputError(
            f"{what} needs elements and a material, and this body was given by its matrices K and "
            "M: make it with FEModel.from_mesh(mesh, material)"
        )
    return body.mesh, body.material


def warn_if_wrong(what: str, times: FloatArray, error: FloatArray | None) -> None:
    """Warn if a history may be badly wrong; `error` is relative, None if it is not known."""
    if error is None or not (error > _BADLY_WRONG).any():
        return
    first, worst = times[np.argmax(error > _BADLY_WRONG)], np.nanmax(error)
    warn(
        f"{what} may be off by {worst:.0%} of the largest, from t = {with_unit(first, 's')} on; "
        f"give it as quantity=, take smaller elements, or make the model with "
        f"duration={times[-1]:.2g} and a larger n"
    )
