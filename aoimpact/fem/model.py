"""Finite-element models of linear elastic bodies, from a mesh or from given matrices."""

from __future__ import annotations

import math
import uuid
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from ..base import (
    HUGE,
    FilePath,
    FloatArray,
    Frozen,
    InputError,
    IntArray,
    Kept,
    called,
    checked,
    finite_array,
    integer,
    integers,
    nonnegative,
    sp,
    text,
    unit_vector,
    warn,
)
from ..linalg import (
    FEW_SOLUTIONS,
    LARGEST,
    LinearSolver,
    Pencil,
    Solver,
    check_mass,
    check_stiffness,
    checked_solver,
    linear_solver,
    lowest,
    m_orthonormal,
    null_space,
    symmetric_pair,
    unresisted_motions,
    warn_of_rounding,
    with_int32,
)
from ..mesh import Mesh, Surface, boundary, rigid_motions
from .assembly import kept_rows_columns, stiffness_mass
from .composition import AnyMaterial, Materials, OneMaterial, materials_of, pieces, thin_groups
from .damping import Damping, damping_or_none
from .doubts import (
    check_joints,
    warn_of_curved_offsets,
    warn_of_locking,
    warn_of_separate_parts,
)
from .labels import axes_of, checked_labels, node_numbers
from .mechanism import Mechanism, mechanism_in, mechanism_of
from .supports import Mounted, SpringSupport, Support, added_mass, free_dofs, spring_stiffness

if TYPE_CHECKING:
    from ..contact import ContactPoint
    from .audit import Audit
    from .frequencyresponse import FrequencyResponse
    from .statics import Grounding


# Values above which coordinates are probably in millimetres. `_HEAVY`: mass, kg. `_LONG`: length,
# m. `_COARSE`: edge of an element, m.
_HEAVY, _LONG, _COARSE = 1e5, 100.0, 1.0

# Largest elastic force under a rigid motion, relative to the sizes of its terms, with which a body
# counts as free: K may be printed with few digits.
FEW_DIGITS = 1e-6

# Cache of a body's contact patches and reduced models. `_DOFS`: number of entries times dofs, for
# half a gigabyte if an entry has 64 vectors. `_LEAST`, `_MOST`: limits of the number of entries;
# `_LEAST` is enough for two models and their patches.
_DOFS, _LEAST, _MOST = 2**20, 4, 32

# `_BODIES`: this process's bodies by their `mark`. `_RECEIVED`: the last bodies received from a
# process that sends a body with each task, kept so that its tasks share the cached results.
_BODIES: WeakValueDictionary[str, FEModel] = WeakValueDictionary()
_RECEIVED: deque[FEModel] = deque(maxlen=2)


@dataclass(frozen=True, eq=False, repr=False)
class FEModel(Frozen):
    """A linear elastic body: M ẍ + C ẋ + K x = f over its free degrees of freedom.

    Parameters
    ----------
    K, M : matrix, shape (n_dofs, n_dofs)
        Stiffness, N/m, and mass, kg, without constrained dofs: sparse or dense, real, symmetric and
        positive semidefinite, with no motion that has neither stiffness nor mass. Dofs without
        mass, such as the rotations of lumped matrices, are condensed statically.
    nodes : array_like, shape (n_nodes, 3), optional
        Coordinates, m. Without them contacts are given by `dof`.
    free : array_like of int, shape (n_dofs,), optional
        Dof of each row of K: 3·node + component for displacements, 3·n_nodes + 3·node + component
        for rotations. By default all displacements, in this order.
    damping : Rayleigh or ModalDamping, optional
        Damping, inherited by the models made from this one.
    name : str, optional
        Name of the body in results, tables and plots, inherited as well.
    labels : array_like of int, shape (n_dofs, 2), optional
        Node number and component of each row of K in the program that wrote K, for
        ``contact(node=)``. Components: 1, 2, 3 for displacements, 4, 5, 6 for rotations, 0 for dofs
        without direction.

    Attributes
    ----------
    mesh : Mesh or None
        Mesh of the body, if known.
    material : Material, Orthotropic, Shell, Laminate, Beam, Materials or None
        Material of the mesh; `Materials` if there are several.
    mass : float or None
        Mass of the whole body, kg, from 1ᵀM1. None if M does not determine it: without nodes and
        labels, or if M lacks constrained dofs.

    Raises
    ------
    InputError, InputTypeError
        If a matrix violates the conditions above, or the shapes do not match.

    Examples
    --------
    >>> import numpy as np
    >>> K, M = np.array([[2e6, -1e6], [-1e6, 1e6]]), np.diag([0.5, 0.5])
    >>> chain = ao.FEModel(K=K, M=M, name="chain")
    >>> chain.frequencies(2).round(1)  # Hz
    array([139.1, 364.2])
    >>> end = chain.contact(dof=1)
    """

    K: Any
    M: Any
    _: KW_ONLY
    nodes: FloatArray | Any = None
    free: IntArray | Any = None
    damping: Damping | None = None
    name: str = ""
    labels: IntArray | None = None
    mesh: Mesh | None = field(init=False, default=None)
    material: AnyMaterial | None = field(init=False, default=None)
    mass: float | None = field(init=False, default=None)
    # Stiffness of springs to the ground, N/m, shape (n_dofs,), included in K.
    springs: FloatArray | None = field(init=False, default=None)
    # Added masses over all dofs, kg, included in M.
    masses: Any = field(init=False, default=None)
    # True if K and M follow from mesh and material, added masses and springs.
    assembled: bool = field(init=False, default=False)
    # A combination of all motions without elastic force, for bodies given by K, M and nodes.
    _soft: FloatArray | None = field(init=False, default=None)
    # The body that a finer body was made from; None for other bodies.
    coarse: FEModel | None = field(init=False, default=None)
    # Indices of the dofs of `coarse` among the dofs of this body.
    own: ClassVar[slice | IntArray] = slice(None)

    def __post_init__(self) -> None:
        checked(self, name=text)
        K, M = symmetric_pair(self.K, self.M)
        motion = check_stiffness(K)
        check_mass(M, K)
        nodes, free = _checked_nodes(self.nodes, self.free, K.shape[0])
        labels = checked_labels(self.labels, K.shape[0])
        mass = None
        n_nodes = 0 if nodes is None else len(nodes)
        along = axes_of(free, labels, n_nodes)
        whole = free is not None and np.count_nonzero(free < 3 * n_nodes) == 3 * n_nodes
        soft = False
        if (
            along is not None and nodes is None and along.any(axis=0).all()
        ):  # in a free body, translations cause no elastic force apart from rounding
            force = np.abs(K @ along).max(initial=0.0)
            soft = bool(force <= FEW_DIGITS * np.abs(K.data).max(initial=0.0))
        if along is not None and (whole or soft):
            mass = _checked_total(np.einsum("ni,nj->ij", M @ along, along))
        damping = damping_or_none(self.damping)
        self._set(K=K, M=M, nodes=nodes, free=free, damping=damping, mass=mass, labels=labels)
        if nodes is not None:
            if mass is not None:
                _warn_of_units(mass, float(np.ptp(nodes, axis=0).max()))
            self._set(_soft=motion)

    def _set(self, **fields: Any) -> None:
        for name, value in fields.items():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
            object.__setattr__(self, name, value)

    @classmethod
    def from_mesh(
        cls,
        mesh: FilePath | Mesh | Any,
        material: AnyMaterial | Mapping[str, OneMaterial],
        fixed: Sequence[Support] | None = None,
        *,
        masses: Sequence[Mounted] | None = None,
        springs: Sequence[SpringSupport] | None = None,
        part: str | Sequence[str] | None = None,
        order: int | None = None,
        damping: Damping | None = None,
        name: str = "",
    ) -> FEModel:
        """Return the model of a meshed body: of solids, shells and beams.

        Parameters
        ----------
        mesh : path, meshio.Mesh or Mesh
            Mesh with coordinates in metres; see `read_mesh`.
        material : Material, Orthotropic, Shell, Laminate, Beam, or mapping of str to these
            One material for all elements, or one per named group of elements; every element needs
            exactly one. Surface elements are shells, line elements beams.
        fixed : sequence of (nodes, letters) or (nodes, letters, letters), optional
            Supports. Nodes: their numbers, the name of a node set of the mesh, or a function of the
            coordinates (n_nodes, 3) that returns one bool per node. First letters, of "x", "y" and
            "z": the constrained displacements. Second letters: the constrained rotations of shells
            and beams. Numbers are those of the file, ``mesh.node_labels``, or count from 0 in a
            mesh without labels. None leaves the body free.
        masses : sequence of (nodes, kg) or RigidMass, optional
            Added masses: nodes as in `fixed`, and their total mass, which acts in all directions
            and is shared equally by the nodes. On a face, equal shares are not uniform: with a
            single quadratic element, the first axial frequency is off by 0.3 %, with more elements
            by less. A `RigidMass` has a centre and moments of inertia as well.
        springs : sequence of (nodes, letters, N/m), optional
            Springs to the ground: nodes and directions as in `fixed`, and the total stiffness in
            each of the directions, shared equally by the nodes (see `masses`). There are no
            dashpots to the ground, as `damping` applies to whole modes.
        part : str or sequence of str, optional
            Named groups of elements that form the body, if the file contains several bodies.
        order : int, optional
            2 turns first-order elements into quadratic ones by midside nodes, which makes coarse
            meshes much more accurate; see `read_mesh`. Node sets include the new nodes, lists of
            numbers do not.
        damping : Rayleigh or ModalDamping, optional
            Damping, inherited by the models made from this one. Rayleigh damping also acts on added
            masses and springs.
        name : str, optional
            Name of the body in results, tables and plots, inherited as well.

        Raises
        ------
        InputError, InputTypeError
            If `material` is not a material or leaves out elements; if a support, mass or spring
            selects no node or unknown components; or if volumes, mass or stiffness overflow or
            vanish.
        MeshError
            If the mesh cannot be read, or has inverted, flat, duplicate or incompatible elements.

        Warns
        -----
        AOImpactWarning
            If the size or mass of the body, or the centre or inertia of a `RigidMass`, suggests
            that coordinates are in millimetres; if a mass lies on constrained nodes; if lists of
            node numbers contain corners without the midside nodes between them; if parts of the
            mesh share no node; or if first-order elements are nearly incompressible.

        Examples
        --------
        >>> bar = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1))
        >>> FEModel.from_mesh(bar, ao.Material(E=70e9, nu=0.3, rho=2700), fixed=[("xmin", "xyz")])
        FEModel(120 dofs, 44 nodes, 10 hexahedron, 0.027 kg, 12 dofs constrained)

        The bar on springs, with an added mass of 2 kg at its end:

        >>> FEModel.from_mesh(
        ...     bar,
        ...     ao.Material(E=70e9, nu=0.3, rho=2700),
        ...     masses=[("xmax", 2.0)],
        ...     springs=[("zmin", "xyz", 1e6)],
        ... )
        FEModel(132 dofs, 44 nodes, 10 hexahedron, 2.027 kg, 66 springs to the ground, free)
        """
        damped, name = damping_or_none(damping), text("name", name)
        from ..io import read_for  # inside, since `io` imports this folder

        solid = read_for(mesh, thin_groups(material), part=part, order=order)
        if part is not None and isinstance(material, Mapping):  # ignore groups of other parts
            here = {at: of for at, of in material.items() if called(at, solid.cell_sets)}
            material = here or material
        made_of = materials_of(solid, material)
        solids = sum(not block.element.thin for block in solid.blocks)
        surface = boundary(solid) if solids > 1 else None  # checks that elements fit together
        check_joints(solid, made_of)
        free = free_dofs(solid, fixed)
        heavier = added_mass(solid, masses, free)
        stiffer = spring_stiffness(solid, springs, free)
        with np.errstate(all="ignore"):
            K, M = stiffness_mass(solid, made_of)
            along_x = np.zeros(K.shape[0])
            along_x[: 3 * solid.n_nodes : 3] = 1.0
            own = mass = float(along_x @ (M @ along_x))
            if heavier is not None:
                heavier.resize(M.shape)
                mass += float(along_x @ (heavier @ along_x))
        _check_reach(mass, K, M, solid, made_of)
        parts = pieces(solid, made_of, OneMaterial)
        volume = own / sum(len(part.rows) * part.of.rho for part in parts)
        _warn_of_units(mass, solid.size, volume)
        warn_of_locking(solid, made_of)
        warn_of_curved_offsets(solid, made_of)
        warn_of_separate_parts(solid, heavier)
        # The matrices are valid by construction: the checks of __post_init__ are not needed.
        model = object.__new__(cls)
        model._set(**completed(K, M, heavier, stiffer, free), nodes=solid.nodes, free=free)
        model._set(mesh=solid, material=made_of, damping=damped, name=name)
        model._set(springs=stiffer, masses=heavier, assembled=True, mass=mass)
        if surface is not None:
            model._set(surface=surface)
        return model

    def with_mesh(
        self,
        mesh: FilePath | Mesh | Any,
        material: AnyMaterial | Mapping[str, OneMaterial],
    ) -> FEModel:
        """Return a body with the same K and M, and with the mesh that they were computed from.

        The mesh makes contact patches, Hertz's law and stress available for matrices of another
        program.

        Parameters
        ----------
        mesh : path, meshio.Mesh or Mesh
            Mesh with coordinates in metres. Nodes are matched by position; mesh nodes without a row
            of K count as constrained.
        material : Material, Orthotropic, or mapping of str to these
            Material as in `from_mesh`, for contact and stress only; K and M do not change.

        Raises
        ------
        InputError, InputTypeError
            If the body has no nodes or one that the mesh lacks, or `material` is not a material.
        MeshError
            If the mesh cannot be read.

        Examples
        --------
        >>> bar, steel = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1)), ao.Material(210e9, 0.3, 7800)
        >>> made = FEModel.from_mesh(bar, steel)
        >>> FEModel(K=made.K, M=made.M, nodes=bar.nodes).with_mesh(bar, steel)
        FEModel(132 dofs, 44 nodes, 10 hexahedron, 0.078 kg, free)
        """
        if self.nodes is None or self.free is None:
            raise InputError("with_mesh needs the body's nodes: give FEModel(nodes=)")
        from ..io import read_for  # inside, since `io` imports this folder

        solid = read_for(mesh, ())
        made_of = materials_of(solid, material)
        n = len(self.nodes)
        node, rotation = self.free // 3 % n, self.free // (3 * n)
        numbers = np.arange(n)
        numbers[node] = node_numbers(self.nodes, node, solid.nodes, solid.size)
        free = 3 * (numbers[node] + solid.n_nodes * rotation) + self.free % 3
        model = object.__new__(type(self))
        model._set(K=self.K, M=self.M, nodes=solid.nodes, free=free, labels=self.labels)
        model._set(mass=self.mass, mesh=solid, material=made_of)
        model._set(damping=self.damping, name=self.name)
        return model

    def __reduce__(self) -> Any:
        """Pickle without caches, and without K and M if they can be assembled from a mesh."""
        _BODIES[self.mark] = self
        state = {item.name: getattr(self, item.name) for item in fields(self)}
        if self.assembled:
            del state["K"], state["M"]
        return _received, (type(self), self.mark, state)

    @cached_property
    def mark(self) -> str:
        """Unique identifier of the body, preserved by pickling.

        :meta private:
        """
        return uuid.uuid4().hex

    @cached_property
    def kept(self) -> Kept:
        """Cache of patches and reduced models for further impacts on this body.

        :meta private:
        """
        return Kept(max(_LEAST, min(_MOST, _DOFS // self.n_dofs)))

    def __getattr__(self, name: str) -> Any:
        """Assemble K and M of an unpickled body with a mesh at their first use."""
        if name not in ("K", "M") or vars(self).get("material") is None:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        self._set(**self._matrices())
        return vars(self)[name]

    def _matrices(self) -> dict[str, Any]:
        """Return a dict of K, M and `held`, assembled from the mesh."""
        made: Any = self.shapes, self.material
        return completed(*stiffness_mass(*made), self.masses, self.springs, self.free)

    def __copy__(self, memo: Any = None) -> FEModel:
        """Copy the body with a new identity; attributes are immutable and shared."""
        copied = object.__new__(type(self))
        known = {name: of for name, of in vars(self).items() if name not in ("mark", "kept")}
        vars(copied).update(known)
        return copied

    __deepcopy__ = __copy__

    @property
    def n_dofs(self) -> int:
        """Number of free degrees of freedom."""
        return int(self.K.shape[0]) if self.free is None else len(self.free)

    def __repr__(self) -> str:
        n, fixed = 0, None
        if self.nodes is not None and self.free is not None:
            n = len(self.nodes)
            turning = np.unique(self.free[self.free >= 3 * n] // 3) - n
            if self.mesh is not None:
                turning = self.mesh.thin_nodes
            fixed = 3 * (n + len(turning)) - self.n_dofs
        springs = 0 if self.springs is None else np.count_nonzero(self.springs)
        parts = [
            self.name and repr(self.name),
            f"{self.n_dofs} dofs",
            n and f"{n} nodes",
            self.mesh and self.mesh.contents,
            isinstance(self.material, Materials) and f"{len(self.material.materials)} materials",
            self.mass is not None and f"{self.mass:.4g} kg",
            springs and f"{springs} springs to the ground",
            fixed is not None and (f"{fixed} dofs constrained" if fixed else "free"),
        ]
        return f"FEModel({', '.join(part for part in parts if part)})"

    def translation(self, direction: npt.ArrayLike) -> FloatArray:
        """Return a unit translation of the body on the free dofs, shape (n_dofs,).

        Parameters
        ----------
        direction : array_like, shape (3,)
            Direction, of any nonzero length.

        Raises
        ------
        InputError
            If the model has neither nodes nor labels.

        :meta private:
        """
        along = unit_vector("direction", direction)
        axes = axes_of(self.free, self.labels, self._n_places)
        if axes is None:
            raise InputError("a translation needs nodes: make the model with FEModel(..., nodes=)")
        return axes @ along

    @property
    def _n_places(self) -> int:
        """Number of rows of `nodes` that are nodes: added shape functions have rows, too."""
        if self.shapes is None:
            return 0 if self.nodes is None else len(self.nodes)
        return int(self.shapes.cells.max()) + 1

    @cached_property
    def _momentum(self) -> FloatArray | None:
        """M g on the free dofs, (n_dofs, 3), for unit translations g of all nodes along x, y, z."""
        if self.mass is None:
            return None
        found: FloatArray = self.M @ axes_of(self.free, self.labels, self._n_places)
        if self.assembled:
            ground, _, M = self.held
            M = M if self.masses is None else M + self.masses[:, ground]
            found += (M @ axes_of(ground, None, self._n_places))[self.free]
        return found

    def at_nodes(self, x: FloatArray, parts: int = 2) -> FloatArray:
        """Return values on the free dofs, (..., n_dofs), as nodal values, 0 on constrained dofs.

        Parameters
        ----------
        parts : int, optional
            2 for displacements and rotations, 1 for displacements only.

        Returns
        -------
        ndarray, shape (..., parts, n_nodes, 3)

        :meta private:
        """
        nodes: Any = self.nodes
        full = np.zeros((*x.shape[:-1], 6 * len(nodes)))
        full[..., self.free] = x
        return full.reshape(*x.shape[:-1], 2, *nodes.shape)[..., :parts, :, :]

    def on_dofs(self, field: FloatArray) -> FloatArray:
        """Return nodal values, ([parts,] n_nodes, 3), on the free dofs, shape (n_dofs,).

        :meta private:
        """
        nodes: Any = self.nodes
        full = np.zeros(6 * len(nodes))
        full[: field.size] = field.reshape(-1)
        return full[self.free]

    def com_functional(self, direction: npt.ArrayLike) -> FloatArray:
        """Return h, shape (n_dofs,), so that hᵀx is the displacement of the centre of mass.

        h = M g / m with g the unit translation of all nodes, including constrained ones.

        Parameters
        ----------
        direction : array_like, shape (3,)
            Direction of the displacement, of any nonzero length.

        Raises
        ------
        InputError
            If the model has neither nodes nor labels, or M was given without the constrained dofs.

        :meta private:
        """
        along = unit_vector("direction", direction)
        if self._momentum is None or self.mass is None:
            raise InputError(
                "the centre of mass is not known: give FEModel the nodes and matrices of the whole "
                "body, or make it with FEModel.from_mesh(mesh, material, fixed=...)"
            )
        return self._momentum @ along / self.mass

    @cached_property
    def rigid_modes(self) -> FloatArray:
        """M-orthonormal basis of the motions without elastic force, shape (n_dofs, r).

        With nodes: the rigid-body motions that K does not resist. Without nodes: the null space of
        K, from its lowest modes.
        """
        if self.nodes is not None:
            motions = rigid_motions(self.nodes, rotations=self._pencil.rotates)[self.free]
            modes = unresisted_motions(self.K, self.M, motions, self.springs)
        elif self.K.data.any():
            modes = null_space(self.K, self.M)
        else:
            modes = m_orthonormal(None, np.eye(self.n_dofs), self.M)
        modes.flags.writeable = False
        return modes

    @cached_property
    def mechanism(self) -> Mechanism | None:
        """Motions without elastic force that are not rigid-body motions; None if there are none.

        They are searched for if the body has a mesh, or has nodes and at most 10 000 dofs. Without
        nodes they are part of `rigid_modes`.
        """
        if self.surface is None or self._pencil.rotates:  # shells and beams have rigid joints
            if self._soft is None:
                return None
            return mechanism_in(self._soft, self.K, self.M, self.rigid_modes)
        return mechanism_of(self.surface, self.free, self.M, self.rigid_modes, self.springs)

    @cached_property
    def node_labels(self) -> IntArray | None:
        """Number of each node for users, shape (n_nodes,); None if numbers count from 0.

        Taken from `labels`, with -1 for nodes without a row of K, otherwise from the mesh.
        """
        if self.labels is not None and self.nodes is not None and self.free is not None:
            found = np.full(len(self.nodes), -1)
            found[self.free // 3 % len(self.nodes)] = self.labels[:, 0]
            return found
        return None if self.mesh is None else self.mesh.node_labels

    def inverse(
        self, s2: float = 0.0, *, solver: Solver = "auto", solutions: int = FEW_SOLUTIONS
    ) -> LinearSolver:
        """Return a factorised or otherwise prepared solver of (K + s²M) x = f.

        Parameters
        ----------
        s2 : float, optional
            s², (rad/s)²; must be positive for a free body.
        solver : str or callable, optional
            Method; see `linear_solver`.
        solutions : int, optional
            Rough number of right-hand sides to expect; see `linear_solver`.

        Examples
        --------
        >>> K, M = np.array([[2e6, -1e6], [-1e6, 1e6]]), np.diag([0.5, 0.5])
        >>> chain = ao.FEModel(K=K, M=M)
        >>> chain.inverse().solve(np.array([0.0, 1.0])).round(9)  # m, of 1 N at the end
        array([1.e-06, 2.e-06])
        """
        shift = nonnegative("s2", s2, unit="(rad/s)²")
        served = integer("solutions", solutions, low=0)
        key = shift, checked_solver(solver)
        if (found := self._living.get(key)) is None:
            found = linear_solver(self._pencil.at(shift), solver, solutions=served)
            self._living[key] = found
        return found

    @cached_property
    def _living(self) -> WeakValueDictionary[Any, LinearSolver]:
        """Solvers that are still in use elsewhere, by shift s² and argument `solver`."""
        return WeakValueDictionary()

    @cached_property
    def _pencil(self) -> Pencil:
        return Pencil(self.K, self.M, 0.0, self.nodes, self.free, self.mesh)

    def frequencies(self, n: int) -> FloatArray:
        """Return the `n` lowest natural frequencies, Hz, rigid-body modes included as 0.

        Parameters
        ----------
        n : int
            Number of frequencies, 1 … n_dofs.

        Examples
        --------
        >>> K, M = np.array([[2e6, -1e6], [-1e6, 1e6]]), np.diag([0.5, 0.5])
        >>> chain = ao.FEModel(K=K, M=M)
        >>> chain.frequencies(2).round(1)
        array([139.1, 364.2])
        """
        count = integer("n", n, low=1, high=self.n_dofs)
        omega2, modes = lowest(self.K, self.M, count, known=self.rigid_modes, invert=self.inverse)
        elastic = modes[:, self.rigid_modes.shape[1] :]
        warn_of_rounding(self.K, elastic, f"{elastic.shape[1]} elastic frequencies")
        if len(omega2) < count:
            raise InputError(f"n must be at most {len(omega2)}, got {count}: others have no mass")
        return np.sqrt(omega2) / (2.0 * np.pi)

    @cached_property
    def surface(self) -> Surface | None:
        """The boundary of the mesh; None without a mesh and for bodies of beams alone."""
        if self.mesh is None or {block.kind for block in self.mesh.blocks} == {"line"}:
            return None
        return boundary(self.mesh)

    @cached_property
    def shapes(self) -> Any:
        """The mesh of all shape functions of the body; it differs from `mesh` for a `FinerBody`.

        :meta private:
        """
        return self.mesh

    @property
    def given(self) -> FEModel:
        """The body itself; for a finer body, the body that was refined.

        :meta private:
        """
        return self.coarse or self

    def appended(self, x: FloatArray) -> FloatArray:
        """Return motions on the dofs of `given`, (n, ...), as motions of this body, (n_dofs, ...).

        :meta private:
        """
        return x

    def restricted(self, x: FloatArray) -> FloatArray:
        """Return motions of this body, (n_dofs, ...), restricted to the dofs of `given`.

        :meta private:
        """
        return x[self.own]

    def functional(self, x: FloatArray) -> FloatArray:
        """Return a linear functional of the dofs of `given`, (n,), as one of this body's dofs.

        :meta private:
        """
        found = np.zeros((self.n_dofs, *x.shape[1:]))
        found[self.own] = x
        return found

    def carried(self, values: FloatArray) -> FloatArray:
        """Return nodal values of `given`, (n, ...), interpolated to this body's shape functions.

        :meta private:
        """
        return values

    @cached_property
    def parent(self) -> IntArray:
        """Element of `given` that contains each element of the body, shape (n_cells,).

        :meta private:
        """
        return np.arange(0 if self.shapes is None else self.shapes.n_cells)

    def alike(self, *motions: FloatArray) -> tuple[FloatArray, Any]:
        """Return motions of this body or of `given`, each (n, k), on common dofs, and their K.

        :meta private:
        """
        return np.hstack(motions), self.K

    @cached_property
    def finer(self) -> FEModel | None:
        """The body with a refined mesh, for estimating the mesh error, or None.

        :meta private:
        """
        from .finer import finer_body

        return finer_body(self)

    @cached_property
    def held(self) -> tuple[IntArray, Any, Any]:
        """The constrained dofs, and their columns of the full K and M (all dofs).

        :meta private:
        """
        if (made_of := self.material) is None or self.free is None:
            raise InputError("only a mesh gives the rows of supports: use FEModel.from_mesh")
        return grounded(*stiffness_mass(self.shapes, made_of), self.free)

    # The following methods import modules when called, because those modules import this one.

    @cached_property
    def grounding(self) -> Grounding:
        """Supports and springs to the ground, for computing the forces that they carry.

        :meta private:
        """
        from .statics import Grounding

        return Grounding(self)

    def frf(
        self,
        *,
        excitation: ContactPoint,
        response: ContactPoint | None = None,
        frequencies: npt.ArrayLike,
        kind: str = "receptance",
    ) -> FrequencyResponse:
        """Return a frequency response function, with a bound of its error.

        Natural modes up to twice the highest frequency (ten times under `ModalDamping`) are
        superposed. All higher modes are included by a series of static solutions with a bounded
        remainder.

        Parameters
        ----------
        excitation : ContactPoint
            Point and direction of the force, from `contact`.
        response : ContactPoint, optional
            Point and direction of the motion; by default those of the excitation.
        frequencies : array_like, shape (n,)
            Frequencies, Hz.
        kind : {"receptance", "mobility", "accelerance"}, optional
            Displacement, velocity or acceleration per unit force.

        Returns
        -------
        FrequencyResponse
            Complex ``values`` for e^{iωt}, and ``error``, a bound in the same unit.

        Raises
        ------
        InputError, InputTypeError
            If a point belongs to another body, a frequency is negative, or it is 0 for a free body.

        Examples
        --------
        >>> K, M = np.array([[2e6, -1e6], [-1e6, 1e6]]), np.diag([0.5, 0.5])
        >>> chain = ao.FEModel(K=K, M=M)
        >>> end = chain.contact(dof=1)
        >>> chain.frf(excitation=end, frequencies=[0.0, 100.0]).values.real  # m/N
        array([2.00000000e-06, 4.03459906e-06])
        """
        from .frequencyresponse import frequency_response

        return frequency_response(self, excitation, response, frequencies, kind)

    def contact(
        self,
        *,
        point: npt.ArrayLike | None = None,
        direction: npt.ArrayLike | None = None,
        node: int | None = None,
        dof: int | None = None,
        b: npt.ArrayLike | None = None,
        radius: float | str = "auto",
        expected: float | None = None,
    ) -> ContactPoint:
        """Return the contact point of this body: a point, a patch, a dof, or any functional.

        Parameters
        ----------
        point : array_like, shape (3,), optional
            Coordinates, m, of a node or of any point on the surface of the mesh. Without a mesh,
            the nearest node within half the local distance between nodes is taken, with a warning
            if it lies elsewhere.
        direction : array_like, shape (3,), optional
            Direction of travel of the projectile, of any nonzero length, for projectile and target
            alike. By default the inward normal of the target's surface, or the outward normal of
            the projectile's.
        node : int, optional
            Node, instead of `point`: its label in the matrices (`labels`) or in the mesh file
            (``mesh.node_labels``), without labels its index in `nodes`.
        dof : int, optional
            Row of K, instead of `point` and `direction`.
        b : array_like, shape (n_dofs,), optional
            Functional b, instead of all arguments above: the contact's displacement is u = bᵀX, and
            its force f loads the body with b f. If b has a resultant of 1 and acts at a point of
            the surface, the compliance of the mesh is removed from the law as for other contacts.
        radius : float or "auto", optional
            Radius of the patch that carries the contact under Hertz's pressure, m. Results hardly
            depend on it between 1.2 contact radii and half the thickness of the body, since the
            compliance of the mesh under the patch is removed from the law. "auto" takes 1.4 times
            the `expected` contact radius, or the edge of an element, but at most a quarter of the
            thickness; `simulate` takes 1.4 times the contact radius of the impact. 0 loads a single
            node, equally good on coarse meshes. Bodies without a mesh have no patch.
        expected : float, optional
            Largest contact radius, m, for "auto"; √(Rδ) for Hertz's law.

        Returns
        -------
        ContactPoint

        Raises
        ------
        InputError
            If the point is not on the body, cannot move in the direction, has no normal (on an
            edge), or the patch reaches beyond the surface.

        Warns
        -----
        AOImpactWarning
            If another point than the given one is taken, or `b` is not a mean displacement: its
            resultant is not 1, or it has a couple.

        Examples
        --------
        The mean of two nodes' displacements along z:

        >>> import numpy as np
        >>> bar = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1))
        >>> body = FEModel.from_mesh(bar, ao.Material(E=70e9, nu=0.3, rho=2700))
        >>> b = np.zeros(body.n_dofs)
        >>> b[[3 * 20 + 2, 3 * 21 + 2]] = 0.5
        >>> body.contact(b=b)
        ContactPoint(functional of 2 dofs of a body of 132 dofs)
        """
        from ..contact import contact_point

        return contact_point(self, point, direction, node, dof, b, radius, expected)

    def audit(self, *, frequencies: int = 8) -> Audit:
        """Return mass, size, wave speed and frequencies, which reveal mistakes of units or files.

        Parameters
        ----------
        frequencies : int, optional
            Number of lowest natural frequencies to compute.

        Returns
        -------
        Audit
            Mass, centre of mass, extent, mean density, wave speed, relative ‖K r‖ of the rigid
            motions r, frequencies, and ``doubts``: implausible values with the likely mistake.
            Prints as a table.

        Examples
        --------
        >>> mesh = ao.box_mesh((1, 0.1, 0.1), (8, 1, 1))
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700))
        >>> audit = bar.audit(frequencies=0)
        >>> round(audit.mass, 6), audit.doubts
        (27.0, ())
        """
        from .audit import audited

        return audited(self, frequencies=integer("frequencies", frequencies, low=0))


def grounded(K: Any, M: Any, free: IntArray) -> tuple[IntArray, Any, Any]:
    """Return the constrained dofs, shape (g,), and their columns of K and M, (all dofs, g).

    Parameters
    ----------
    K, M : scipy.sparse.csr_array, shape (all dofs, all dofs)
        Matrices from `stiffness_mass`.
    free : ndarray of int
        Dofs that no support holds.
    """
    ground = np.setdiff1d(np.flatnonzero(np.diff(K.indptr)), free)
    return ground, K[ground].T, M[ground].T


def completed(
    K: Any, M: Any, masses: Any, springs: FloatArray | None, free: IntArray
) -> dict[str, Any]:
    """Return a dict of K and M on the free dofs, with added masses and springs, and `held`.

    The arrays of the given K and M, over all dofs, are overwritten.
    """
    held, kept = grounded(K, M, free), np.sort(free)
    M = M if masses is None else summed(M, masses)
    if len(free) < K.shape[0]:
        K, M = (kept_rows_columns(matrix, kept) for matrix in (K, M))
    if (kept != free).any():
        order = np.searchsorted(kept, free)
        K, M = (with_int32(of[order][:, order].sorted_indices()) for of in (K, M))
    K = K if springs is None else summed(K, sp.diags_array(springs, format="csr"))
    return {"K": K, "M": M, "held": held}


def summed(matrix: Any, other: Any) -> Any:
    """Return the sum of two CSR matrices, with indices sorted and of 32 bits if possible."""
    total = (matrix + other).tocsr()
    total.sort_indices()
    return with_int32(total)


def _checked_nodes(nodes: Any, free: Any, n_dofs: int) -> tuple[FloatArray | None, IntArray | None]:
    if nodes is None:
        if free is not None:
            raise InputError("free assigns rows to nodes' dofs, so needs nodes; give both or none")
        return None, None
    places = np.array(finite_array("nodes", nodes, shape=(None, 3), unit="m", most=HUGE))
    if free is None:
        if n_dofs != 3 * len(places):
            raise InputError(
                f"K has {n_dofs} rows, but {len(places)} nodes have {3 * len(places)} dofs; "
                "if supports were taken out, give free: for each row its dof 3·node + component"
            )
        return places, np.arange(n_dofs)
    dofs = integers("free", free, "integer dof numbers", shape=(n_dofs,))
    if dofs.min() < 0 or dofs.max() >= 6 * len(places):
        raise InputError(
            f"free must be within 0 … {3 * len(places) - 1} for displacements of {len(places)} "
            f"nodes; as many rotations follow, got {dofs.min()} … {dofs.max()}"
        )
    if len(np.unique(dofs)) != n_dofs:
        raise InputError(f"free must not repeat dofs, got {n_dofs - len(np.unique(dofs))} repeated")
    return places, dofs


def _checked_total(total: FloatArray) -> float:
    """Return the body's mass m from the 3 × 3 mass matrix of its translations, ideally m I."""
    mass = float(np.trace(total)) / 3.0
    if mass <= 0.0:
        raise InputError(f"M must have a positive total mass, got {mass:g} kg")
    gap = float(np.abs(total - mass * np.eye(3)).max())
    if gap > 1e-6 * mass:
        warn(
            f"M has {total[0, 0]:.4g}, {total[1, 1]:.4g} and {total[2, 2]:.4g} kg along x, y and "
            f"z, and {np.abs(total - np.diag(np.diag(total))).max():.3g} kg coupling them: are its "
            "rows in the order 3·node + component?"
        )
    return mass


def _check_reach(mass: float, K: Any, M: Any, mesh: Mesh, material: AnyMaterial) -> None:
    """Refuse a body whose mass or stiffness overflows or underflows."""
    stiffest = float(max(K.data.max(), -K.data.min()))  # nan and infinity fail the test below
    lightest = float(M.diagonal()[: 3 * mesh.n_nodes].min())
    least = 1.0 / LARGEST
    if not (lightest > least and mass < LARGEST and least < stiffest < LARGEST):
        raise InputError(
            f"the body is {mesh.size:.3g} m long, of {material}: its mass ({mass:g} kg) or "
            "stiffness overflows or vanishes; give coordinates in metres and the material in Pa "
            "and kg/m³"
        )


def _warn_of_units(mass: float, size: float, volume: float = 0.0) -> None:
    """Warn if the size, m, mass, kg, or mean volume of elements, m³, is implausibly large."""
    edge = math.cbrt(volume)
    if mass > _HEAVY or size > _LONG or edge > _COARSE:
        elements = f", with elements of {edge:.3g} m" if volume else ""
        warn(
            f"the body is {size:.4g} m long and weighs {mass:.4g} kg{elements}: coordinates are "
            "taken in metres; for millimetres use read_mesh(path, scale=1e-3)"
        )


def _received(kind: type[FEModel], mark: str, state: dict[str, Any]) -> FEModel:
    """Return this process's body with the given mark, otherwise a new one with the given state."""
    body = _BODIES.get(mark)
    if body is None:
        body = object.__new__(kind)
        body.__setstate__(state | {"mark": mark})
        _BODIES[mark] = body
        _RECEIVED.append(body)
    return body
