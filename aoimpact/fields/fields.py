"""How a struck body moves and which stress it carries: points over time, fields at chosen times."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray, InputError, choice, integer, warn
from ..fem import (
    AnyMaterial,
    FEModel,
    Layer,
    Strain,
    Stress,
    beam_von_mises,
    body_stress_rows,
    checked_layer,
    gauss_stress,
    nodal_stress,
    thickness_of_cells,
)
from ..mesh import Mesh
from . import vtu
from .channel import Channel
from .historyerror import Compared, warn_if_wrong
from .picture import Picture, Shown, movie_path

if TYPE_CHECKING:
    from .response import Response


@dataclass(frozen=True, eq=False)
class Filtered(Compared):
    """Acceleration behind the filter of a channel.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    channel : Channel
        Its frequency class or corner, Hz.
    """

    t: FloatArray
    channel: Channel
    _acceleration: FloatArray = field(repr=False)

    @property
    def acceleration(self) -> FloatArray:
        """Acceleration, m/s², in the shape of `Probe.displacement`; warns where it may be wrong.

        It and its error are NaN over the filter's settling time before the end of the record; see
        `Probe.filtered`.
        """
        warn_if_wrong("filtered acceleration", self.t, self.error)
        return self._acceleration


class At(NamedTuple):
    """Places and axes of a measured motion; see `Response.motion_at`."""

    places: FloatArray
    axes: FloatArray
    rows: Any


@dataclass(frozen=True, eq=False)
class Probe:
    """Motion, strain and stress of one place of a body over time.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    points : ndarray, shape (3,) or (p, 3)
        Where, on the undeformed body, m.
    """

    t: FloatArray
    points: FloatArray
    _displacement: FloatArray = field(repr=False)
    _velocity: FloatArray = field(repr=False)
    _follows: Callable[[], bool] = field(repr=False)
    _response: Response = field(repr=False)
    _at: At = field(repr=False)
    _weights: sp.csr_array = field(repr=False)  # of the nodes at the points
    _layer: Layer = field(repr=False)

    @property
    def displacement(self) -> FloatArray:
        """Displacement, m, shape (n, p, 3).

        Without the axis p for a single point, and without the last one for a given direction, along
        which it is then measured. Warns where it may be badly wrong; see `error`.
        """
        if not self._follows():
            warn_if_wrong("displacement", self.t, self.error.get("displacement"))
        return self._displacement

    @property
    def velocity(self) -> FloatArray:
        """Velocity, m/s, in the shape of `displacement`."""
        warn_if_wrong("velocity", self.t, self.error.get("velocity"))
        return self._velocity

    @cached_property
    def acceleration(self) -> FloatArray:
        """Acceleration, m/s², in the shape of `displacement`, as the body's model has it.

        By central differences over a thousandth of the shortest contact, or over two fixed steps.

        Warns
        -----
        AOImpactWarning
            It has no finite bandwidth, and no error that could be known: an impact excites modes up
            to any frequency, each with as much acceleration. `filtered` converges.
        """
        warn(
            "acceleration has no finite bandwidth after an impact: it grows with the number of "
            "modes of the model, and has no error; take probe.filtered(cfc=1000), or "
            "quantity=AccelerationAt(point, direction, cfc=1000)"
        )
        return self._response.acceleration(self._at, self.t).reshape(self._displacement.shape)

    def filtered(self, cfc: float | None = None, *, corner: float | None = None) -> Filtered:
        """Return the acceleration behind a filter.

        SAE J211-1, appendix C: a Butterworth filter of two poles, forward and backward, so that no
        phase is shifted. Before the record the body is at rest or moves steadily. What follows the
        record is not known, so that the acceleration is NaN over the filter's settling time before
        the end, the class's period: 1 ms for CFC 1000. Take a `duration` longer by that.

        Parameters
        ----------
        cfc : float, optional
            Channel frequency class, Hz: 60, 180, 600 or 1000 in the standard; any other by the same
            formula. The signal is 3 dB down at 1.65 times the class.
        corner : float, optional
            In place of the class, the frequency where the signal is 3 dB down, Hz.

        Raises
        ------
        InputError
            If neither or both are given, or the record is shorter than the settling time.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(mass=0.01), ao.full(tip), velocity=0.1,
        ...     law=ao.Linear(k=1e5), duration=2e-3, solver=ao.Newmark(dt=5e-6))
        >>> probe = hit.target.probe((0.05, 0.005, 0.0), (0, 0, 1), dt=1e-5)
        >>> probe.filtered(cfc=1000).acceleration.shape == probe.t.shape
        True
        """
        channel, shape = Channel(cfc=cfc, corner=corner), self._displacement.shape
        return self._response.filtered(self._at, self.t, shape, channel)

    @cached_property
    def error(self) -> Mapping[str, FloatArray]:
        """Errors by the body's model, relative to the largest value, of shape (n,).

        ``error["displacement"]`` and ``error["velocity"]`` are those of these histories; see
        `BodyResult.error`. ``error["stress"]`` and ``error["strain"]`` are that of the whole field,
        as of `Field.error`. It is empty of a full model.
        """
        return self._response.errors(self._at.rows, self.t)

    @cached_property
    def stress(self) -> Stress:
        """The stress over time, of shape (n, p, 6), or (n, 6) for a single point.

        Averaged at the nodes as `Field.stress`, between them by the elements' shape functions.

        Raises
        ------
        InputError
            If the body has no elements and material: it was given by K and M.
        """
        warn_if_wrong("stress", self.t, self.error.get("stress"))
        return Stress(self._tensor(strain=False), self.points)

    @cached_property
    def strain(self) -> Strain:
        """The strain over time, in the shape of `stress`; shears are those of the tensor.

        Raises
        ------
        InputError
            If the body has no elements and material: it was given by K and M.
        """
        warn_if_wrong("strain", self.t, self.error.get("strain"))
        return Strain(self._tensor(strain=True), self.points)

    def _tensor(self, *, strain: bool) -> FloatArray:
        """Stress or strain, shape (n, p, 6), or (n, 6) for a single point."""
        place = self._weights, self.t, self._layer
        found = self._response.stress(*place, strain=strain)
        return found.reshape(len(self.t), *self.points.shape[:-1], 6)


@dataclass(frozen=True, eq=False)
class Field(Compared):
    """The whole body at some times.

    Attributes
    ----------
    body : FEModel
    times : ndarray, shape (k,)
        s.
    displacement, velocity : ndarrays, shape (k, n_nodes, 3)
        m and m/s.

    Notes
    -----
    Its `error` is in the norm of strain energy, relative to the largest over the record. The force
    may be right where this is large: a model fitted to a short contact need not vibrate as the body
    does afterwards. The errors of mesh and contact (`Result.error`) add to it.
    """

    body: FEModel
    times: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    # Under contacts: the elements' part of the displacement, and the half-space's stress at places.
    _of_elements: FloatArray | None = field(default=None, repr=False)
    _half_space: Callable[[FloatArray], FloatArray] | None = field(default=None, repr=False)
    _rotation: FloatArray | None = field(default=None, repr=False)

    @property
    def rotation(self) -> FloatArray:
        """Rotations of the nodes of shells and beams, rad, in the shape of `displacement`."""
        return np.zeros_like(self.displacement) if self._rotation is None else self._rotation

    @property
    def of_elements(self) -> FloatArray:
        """The displacement without the half-space's under contacts, in the shape of `displacement`.

        :meta private:
        """
        return self.displacement if self._of_elements is None else self._of_elements

    def __repr__(self) -> str:
        times = ", ".join(f"{time:.6g}" for time in self.times[:4])
        more = ", …" if len(self.times) > 4 else ""
        return f"Field(t = {times}{more} s of {self.body!r})"

    def stress(self, at: str = "nodes", *, layer: Any = None, part: str | None = None) -> Stress:
        """Return the stress.

        Under a contact of solids it is that of Hertz's pressure in closed form; the rest is that of
        the elements.

        Parameters
        ----------
        at : {"nodes", "gauss"}, optional
            "nodes": extrapolated from the Gauss points and averaged over the elements that meet
            there, components of shape (k, n_nodes, 6); where materials meet, over those of the
            stiffest. "gauss": at the Gauss points of the elements' stiffness, components of shape
            (k, n_cells, n_gauss, 6), in a mixed mesh with nan where an element has fewer. Shells
            and beams have it at the nodes.
        layer : str, (int, str) or (float, float), optional
            In shells "top", where the elements' normals point, "middle" or "bottom"; by itself the
            top. (3, "bottom") is the lower face of the fourth ply from the bottom, and stress there
            is along the ply's axes: xx along the fibres, and nan where a body has no such ply.
            In beams by itself where von Mises' stress is largest in the section. "top" and "bottom"
            are the sides along the section's z axis, "left" and "right" those along y, "middle" is
            the centroid, and (y, z) any place in the section, m. A round beam without an
            orientation has no sides.
        part : str, optional
            The group of elements whose stress it is, nan at other nodes: of a stiffener on a skin,
            or of one of several members at a joint. By itself, where shells and beams meet that of
            the stiffest shell, and of beams that of the member with the largest.

        Raises
        ------
        InputError
            If the body has no elements and material: it was given by K and M; or there is no such
            `layer` or `part`.

        Warns
        -----
        AOImpactWarning
            If a reduced model may give it badly wrong; see `error`.

        Notes
        -----
        Stress of a beam is that of axial force, bending about both axes, torsion and shear force:
        exact of round sections and rectangles under torsion (Saint-Venant), by Zhuravskii's formula
        under shear. Of a `BeamSection` it is direct stress alone, at its points.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(mass=0.01), tip, velocity=0.1, law=ao.Linear(k=1e5))
        >>> stress = hit.target.field([1e-4]).stress()
        >>> stress.von_mises.shape == (1, len(bar.nodes))
        True
        """
        warn_if_wrong("stress", self.times, self.error)
        place = choice("at", at, ("nodes", "gauss"))
        mesh, material = solid(self.body, "stress")
        where = checked_layer(layer, part)
        if mesh.thin or part is not None:
            if place != "nodes":
                raise InputError(f'at={at!r}: stress of shells and beams is known at="nodes"')
            every = sp.eye_array(mesh.n_nodes, format="csr")
            found_at = body_stress_rows(mesh, material, every, where)
            dofs = np.concatenate([self.displacement, self.rotation], axis=1)
            values = found_at.rows @ dofs.reshape(len(self.times), -1).T
            return Stress(found_at.components(values), mesh.nodes)
        evaluate = nodal_stress if place == "nodes" else gauss_stress
        moved = self.of_elements
        found = evaluate(mesh, material, moved)
        if self._half_space is None:
            return found
        added = self._half_space(found.points.reshape(-1, 3)).reshape(found.components.shape)
        return Stress(found.components + added, found.points)

    def to_vtu(self, path: str | os.PathLike[str]) -> Path:
        """Write one .vtu file for each time, and a .pvd file that lists them, for ParaView.

        At the nodes: displacement (m), velocity (m/s), stress (xx, yy, zz, xy, yz, xz), von_mises
        and principal, all Pa. Of shells and beams also rotation (rad), stress_middle and
        stress_bottom, with stress on the top of shells and where it is largest in beams. Of
        elements the thickness (m) of shells, and von_mises_of_beams (Pa), the largest of each.

        Parameters
        ----------
        path : path
            "beam", "beam.vtu" or "beam.pvd" gives beam.pvd and beam_0.vtu, beam_1.vtu …, in a
            folder that is there.

        Returns
        -------
        Path
            Of the .pvd file.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(mass=0.01), tip, velocity=0.1, law=ao.Linear(k=1e5))
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
            return vtu.write_series(path, mesh, self.times, data)
        data["rotation"] = self.rotation
        for side in ("middle", "bottom"):
            data[f"stress_{side}"] = self.stress(layer=side).components
        own = {
            "thickness": np.broadcast_to(
                thickness_of_cells(mesh, material), (len(self.times), mesh.n_cells)
            )
        }
        own["von_mises_of_beams"] = self._of_beams()
        return vtu.write_series(path, mesh, self.times, data, own)

    def _of_beams(self) -> FloatArray:
        """Largest von Mises' stress of each beam element, Pa, (k, n_cells); 0 of others."""
        mesh, material = solid(self.body, "stress")
        dofs = np.concatenate([self.displacement, self.rotation], axis=1)
        return beam_von_mises(mesh, material, dofs.reshape(len(self.times), -1))

    @property
    def _free(self) -> bool:
        """True if no support holds any displacement."""
        free = self.body.free
        assert free is not None
        n = self.displacement[0].size
        return bool(np.count_nonzero(free < n) == n)

    def _shown(self) -> Shown:
        """Return the body as it is drawn: without its mean displacement where it has no support."""
        mesh, _ = solid(self.body, "a picture")
        moved = self.displacement
        if self._free:
            moved = moved - moved.mean(axis=1, keepdims=True)
        return Shown(mesh, mesh.nodes, moved, self.stress().von_mises)

    def plot(self, *, which: int = 0, scale: float | None = None) -> Any:
        """Draw the deformed body, coloured by von Mises' stress.

        Enlargement and colours are the same at all times of the field. The mean displacement of a
        body without supports is left out: it would fly out of the picture.

        Parameters
        ----------
        which : int, optional
            Which of the times.
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
        >>> hit = ao.simulate(ao.rigid(mass=0.01), tip, velocity=0.1, law=ao.Linear(k=1e5))
        >>> hit.target.field([1e-4]).plot().screenshot("bar.png")  # doctest: +SKIP
        """
        number = integer("which", which, low=0, high=len(self.times) - 1)
        return Picture([self._shown()], self.times, scale=scale).draw(number)

    def movie(
        self, path: str | os.PathLike[str], *, scale: float | None = None, fps: float = 15.0
    ) -> Path:
        """Write a movie of the body, a frame a time, as `plot` draws it.

        `Result.movie` shows both bodies of an impact.

        Parameters
        ----------
        path : path
            Ending in .gif or .mp4.
        scale : float, optional
            As for `plot`.
        fps : float, optional
            Frames a second.

        Returns
        -------
        Path

        Raises
        ------
        MissingPackageError
            If PyVista, imageio or, for .mp4, imageio-ffmpeg are not installed.
        InputError
            If the body has no elements, or the path is no place for a movie.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(mass=0.01), tip, velocity=0.1, law=ao.Linear(k=1e5))
        >>> field = hit.target.field([1e-4, 2e-4])
        >>> path = field.movie("bar.gif")  # doctest: +SKIP
        """
        file, speed = movie_path(path, fps)
        return Picture([self._shown()], self.times, scale=scale).write(file, speed)


def solid(body: FEModel, what: str) -> tuple[Mesh, AnyMaterial]:
    """Return the body's mesh and material; `what` needs them."""
    if body.mesh is None or body.material is None:
        raise InputError(
            f"{what} needs elements and a material, and this body was given by its matrices K and "
            "M: make it with FEModel.from_mesh(mesh, material)"
        )
    return body.mesh, body.material
