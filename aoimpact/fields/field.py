"""How a struck body moves and which stress it carries, at chosen times."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray, InputError, choice, integer, warn, with_unit
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
from ..mesh import Mesh
from .picture import DOWN, Shown, picture, write_movie, write_series

# Relative error from which on a history warns.
_BADLY_WRONG = 0.2

# Times of the record at which the largest value is looked for.
LOOKS = 200


@dataclass(frozen=True, eq=False)
class Field:
    """The whole body at some times.

    Attributes
    ----------
    body : FEModel
    times : ndarray, shape (k,)
        s.
    displacement, velocity, rotation : ndarrays, shape (k, n_nodes, 3)
        m, m/s and, of the nodes of shells and beams, rad.

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
    rotation: FloatArray
    # Under contacts: the elements' part of the displacement, and the half-space's stress at places.
    of_elements: FloatArray = field(repr=False)
    _half_space: Callable[[FloatArray], FloatArray] = field(repr=False)
    _error: Callable[[], FloatArray | None] = field(repr=False)

    @cached_property
    def error(self) -> FloatArray | None:
        """Error by the body's model, relative to the largest over the record, (k,).

        It is found by one more run, with a finer model; None of a full model.
        """
        return self._error()

    @property
    def _dofs(self) -> FloatArray:
        """Displacements and rotations of all nodes, shape (k, all dofs)."""
        dofs = np.concatenate([self.displacement, self.rotation], axis=1)
        return dofs.reshape(len(self.times), -1)

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
            return Stress(found_at.components(found_at.rows @ self._dofs.T), mesh.nodes)
        evaluate = nodal_stress if place == "nodes" else gauss_stress
        found = evaluate(mesh, material, self.of_elements)
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
            return write_series(path, mesh, self.times, data)
        data["rotation"] = self.rotation
        for side in ("middle", "bottom"):
            data[f"stress_{side}"] = self.stress(layer=side).components
        thickness = thickness_of_cells(mesh, material)
        own = {
            "thickness": np.broadcast_to(thickness, (len(self.times), mesh.n_cells)),
            "von_mises_of_beams": beam_von_mises(mesh, material, self._dofs),
        }
        return write_series(path, mesh, self.times, data, own)

    def _shown(self) -> Shown:
        """Return the body as it is drawn: without its mean displacement where it has no support."""
        mesh, _ = solid(self.body, "a picture")
        moved, free = self.displacement, self.body.free
        if free is None or np.count_nonzero(free < moved[0].size) == moved[0].size:
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
        plotter, draw = picture([self._shown()], self.times, scale=scale)
        draw(number)
        return plotter

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
        return write_movie(path, fps, lambda: ([self._shown()], DOWN), self.times, scale)


def solid(body: FEModel, what: str) -> tuple[Mesh, AnyMaterial]:
    """Return the body's mesh and material; `what` needs them."""
    if body.mesh is None or body.material is None:
        raise InputError(
            f"{what} needs elements and a material, and this body was given by its matrices K and "
            "M: make it with FEModel.from_mesh(mesh, material)"
        )
    return body.mesh, body.material


def warn_if_wrong(what: str, times: FloatArray, error: FloatArray | None) -> None:
    """Warn where a history may be badly wrong; `error` is relative, None where not known."""
    if error is None or not (error > _BADLY_WRONG).any():
        return
    first, worst = float(times[int(np.argmax(error > _BADLY_WRONG))]), float(np.nanmax(error))
    warn(
        f"{what} may be off by {worst:.0%} of the largest, from t = {with_unit(first, 's')} on: "
        "the model gives the force, but not the free vibration afterwards; give quantity= a motion "
        f"or stress of the body, or make its model with duration={times[-1]:.2g} and a larger n"
    )
