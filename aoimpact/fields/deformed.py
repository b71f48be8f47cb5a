"""A picture of a deformed body in three dimensions, by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import FloatArray, InputTypeError, IntArray, nonnegative, scale_for, with_unit
from ..mesh import Mesh, boundary

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d import Axes3D


# By default the largest displacement is drawn as this share of the body's size, which shows the
# motion and leaves the shape.
_SHOWN = 0.1

# A plate's box is drawn at least this thick, as a share of its length; ticks along the length.
_THINNEST = 0.05
_SHORTEST = 0.25  # shorter axes have no ticks, which would overlap
_MOST_TICKS = 6


def plot_deformed(
    mesh: Mesh,
    moved: FloatArray,
    von_mises: FloatArray,
    time: float,
    ax: Axes3D | None = None,
    *,
    scale: float | None = None,
    all_times: FloatArray | None = None,
    **kwargs: Any,
) -> Axes3D:
    """Draw the surface of a deformed body, coloured by von Mises' stress; see `Field.plot`.

    Parameters
    ----------
    mesh : Mesh
    moved : ndarray, shape (n_nodes, 3)
        Displacement, m.
    von_mises : ndarray, shape (n_nodes,)
        Pa.
    time : float
        s.
    all_times : ndarray, shape (k, n_nodes), optional
        Von Mises' stresses, Pa, of all the pictures that are to have the same colours.
    """
    import matplotlib.pyplot as plt
    from mpl_toolkits.mplot3d import Axes3D
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    factor = _enlargement(moved, mesh.size, scale)
    if ax is None:
        ax = plt.figure(layout="constrained").add_subplot(projection="3d")
    elif not isinstance(ax, Axes3D):
        raise InputTypeError(
            "ax must be three-dimensional axes, such as plt.figure().add_subplot(projection='3d'), "
            f"got {type(ax).__name__}"
        )
    length = scale_for(mesh.size, "m")
    places = length.factor * (mesh.nodes + factor * moved)
    faces = outlines(mesh)
    shown = von_mises[None] if all_times is None else np.vstack([von_mises, all_times])
    means = np.stack([shown[:, face].mean(axis=1) for face in faces], axis=1)
    pressure = scale_for(float(means.max()), "Pa")
    style = {"edgecolor": "0.2", "linewidth": 0.2, "cmap": "viridis"} | kwargs
    drawn = Poly3DCollection([places[face] for face in faces], **style)
    drawn.set_array(pressure.factor * means[0])
    if not {"clim", "norm"} & style.keys():
        drawn.set_clim(0.0, pressure.factor * float(means.max()) or 1.0)
    ax.add_collection3d(drawn)
    beside = _frame(ax, places, length.unit)
    times = f"{float(f'{factor:.3g}'):g}"
    ax.set_title(
        f"t = {with_unit(time, 's')}; axes: position + {times} × displacement{beside}",
        fontsize="medium",
    )
    label = f"von Mises stress ({pressure.unit}), {_largest(drawn.get_array(), faces, mesh)}"
    ax.figure.colorbar(drawn, ax=ax, label=label, shrink=0.7, pad=0.12)
    return ax


def _largest(values: FloatArray, faces: list[IntArray], mesh: Mesh) -> str:
    """Place of the largest of the faces' values, which may lie on a side that is not seen."""
    unit = scale_for(mesh.size, "m")
    place = unit.factor * mesh.nodes[faces[int(np.argmax(values))]].mean(axis=0) + 0.0
    return f"largest near\n({', '.join(f'{x:.3g}' for x in place)}) {unit.unit}"


def outlines(mesh: Mesh) -> list[IntArray]:
    """The faces of the surface, each as the nodes on its edges, in order around it.

    A line goes there and back.
    """
    found: list[IntArray] = []
    for lines in (of.cells for of in mesh.blocks if of.kind == "line"):
        found.extend(lines[:, [0, 1, 0]])
    if len(found) == mesh.n_cells:
        return found
    surface = boundary(mesh)
    for number, (block, side) in enumerate(surface.sides):
        places = mesh.blocks[block].element.nodes[side.nodes]
        u, v = np.linalg.pinv(side.axes.T) @ (places - places[: side.n_corners].mean(axis=0)).T
        rim = np.flatnonzero(np.hypot(u, v) > 1e-9)  # but not the node in the face's middle
        around = side.nodes[rim[np.argsort(np.arctan2(v[rim], u[rim]))]]
        found.extend(mesh.cells[surface.cell[surface.side == number]][:, around])
    return found


def _enlargement(moved: FloatArray, size: float, scale: float | None) -> float:
    if scale is not None:
        return nonnegative("scale", scale)
    largest = float(np.linalg.norm(moved, axis=1).max())
    return _SHOWN * size / largest if largest > 0.0 else 1.0


def _frame(ax: Axes3D, places: FloatArray, unit: str) -> str:
    """Give the axes the limits and proportions of the body.

    Returns the extents along axes that are too short for ticks, to be written elsewhere.
    """
    from matplotlib.ticker import MaxNLocator

    low, high = places.min(axis=0), places.max(axis=0)
    longest = float((high - low).max())
    span = np.maximum(high - low, _THINNEST * longest)
    middle = 0.5 * (low + high)
    beside: list[str] = []
    for i, axis in enumerate((ax.xaxis, ax.yaxis, ax.zaxis)):
        axis.set_view_interval(middle[i] - 0.5 * span[i], middle[i] + 0.5 * span[i], ignore=True)
        if span[i] < _SHORTEST * longest:
            axis.set_ticks([])
            beside.append(f"{'xyz'[i]} from {low[i]:.3g} to {high[i]:.3g} {unit}")
            continue
        axis.set_major_locator(MaxNLocator(max(1, round(_MOST_TICKS * span[i] / longest))))
        axis.set_label_text(f"{'xyz'[i]} ({unit})")
        thin = longest / float(np.delete(span, i).max())  # pads are shares of the other spans
        axis.labelpad = thin * (10.0 if i < 2 else 18.0)
        axis.set_tick_params(pad=thin * (3.0 if i < 2 else 8.0))  # two axes end in one corner
    ax.set_box_aspect(span, zoom=0.92)  # labels of the axes have room
    return "\n" + ", ".join(beside) if beside else ""
