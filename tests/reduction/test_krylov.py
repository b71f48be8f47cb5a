"""Scene-fitted anti-oscillators: few give the full model's force, and what a subspace keeps."""

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
from paperbodies import BALL_MASS, LAW, LENGTH, WIDTH, beam_model
from rows import each

import aoimpact as ao
from aoimpact import box_mesh
from aoimpact.linalg import METHODS
from aoimpact.reduction import KrylovSpace

from slender import beam, joined, rod

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)

needs_pardiso = pytest.mark.skipif(
    not METHODS["pardiso"].is_installed(), reason="py-mkl-pardiso is not there"
)


def fitted(K, M, dof, n, **options):
    return ao.antioscillators(ao.FEModel(K=K, M=M).contact(dof=dof), n, method="krylov", **options)


def laplace_receptance(body, b, s):
    """U = bᵀX for F = 1 at the frequency i s: real, smooth, as in an impact of 10/s."""
    dense = body.K.toarray(), body.M.toarray()
    return np.array([b @ la.solve(dense[0] + x**2 * dense[1], b, assume_a="pos") for x in s])


def star_at(star, s):
    """The star's receptance at i s, from its masses and springs."""
    inertia = star.m0 + sum(k / (k / m + s**2) for m, k in zip(star.m, star.k, strict=True))
    return 1 / (star.k0 + s**2 * inertia)


# ------------------------------------------------------------------------- the paper's two bodies


@pytest.fixture(scope="module")
def paper_beam():
    tip = beam_model().contact(point=(LENGTH / 2, WIDTH / 2, WIDTH), direction=(0, 0, -1), radius=0)
    whole = ao.antioscillators(tip)
    return tip, beam_force(whole), whole


def beam_force(target):
    hit = ao.simulate(ao.rigid(mass=BALL_MASS), target, 1.0, law=LAW, duration=250e-6)
    return hit.at(np.linspace(0, 250e-6, 501)).force


@pytest.mark.slow
def test_few_antioscillators_give_the_force_on_the_papers_beam(paper_beam):
    """The paper takes 28 by their mass for .3 %; largest difference over 250 µs to all of them."""
    tip, full, _ = paper_beam
    space = KrylovSpace(tip, contact_time=90e-6)
    error = {
        n: np.abs(beam_force(space.antioscillators(n)) - full).max() / full.max()
        for n in (3, 5, 8, 28)
    }
    assert error[3] <= 0.03
    assert error[5] <= 0.012
    assert error[8] <= 0.003
    assert error[28] <= 0.0008
    assert space.solves == 29  # one factorisation, and each of the four models


@pytest.mark.slow
def test_the_bodys_own_contact_time_does_as_well(paper_beam):
    tip, full, _ = paper_beam
    star = ao.antioscillators(tip, 5, method="krylov")
    assert np.abs(beam_force(star) - full).max() <= 0.012 * full.max()


@pytest.mark.slow
def test_contact_time_need_not_be_known_well(paper_beam):
    """Half and twice the true one, 90 µs."""
    tip, full, _ = paper_beam
    for contact_time in (45e-6, 180e-6):
        star = ao.antioscillators(tip, 8, method="krylov", contact_time=contact_time)
        assert np.abs(beam_force(star) - full).max() <= 0.005 * full.max()


# ------------------------------------------------------------------------------- what is kept


@pytest.fixture(scope="module")
def block():
    """A free block struck off its centre line."""
    mesh = box_mesh((0.03, 0.02, 0.02), (4, 3, 3), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, STEEL)
    return body.contact(point=(0.03, 0.02, 0.02 / 3), direction=(1, 0, 0), radius=0)


def test_a_free_body_keeps_its_mass_and_the_motion_of_its_centre(block):
    """Seen from the contact its mass is 1/Σr² of its rigid motions; its centre by its velocity."""
    whole = ao.antioscillators(block, 0)
    for n in (1, 3, 8):
        star = ao.antioscillators(block, n, method="krylov", contact_time=20e-6)
        assert star.k0 == 0.0
        assert star.mass == pytest.approx(STEEL.rho * 12e-6, rel=1e-10)
        assert star.static_mass == pytest.approx(whole.static_mass, rel=1e-10)
        # Oscillators that vibrate about a centre at rest: their weights are their masses' shares.
        body = star.modal
        assert body.whole.centre @ body.whole.moving == pytest.approx(1.0, rel=1e-10)
        np.testing.assert_allclose(body.whole.centre[body.omega > 0.0], 0.0, atol=1e-10)


def test_receptance_is_right_over_the_band(block):
    """Real frequencies up to 1/s T = 1, and the imaginary ones of an impact, from 1/T to 30/T."""
    T = 20e-6
    star = ao.antioscillators(block, 12, method="krylov", contact_time=T)
    s = np.geomspace(1.0, 30.0, 9) / T
    np.testing.assert_allclose(
        star_at(star, s), laplace_receptance(block.body, block.b, s), rtol=1e-6
    )
    omega = np.linspace(0.05, 2 * np.pi, 15) / T
    K, M = block.body.K.toarray(), block.body.M.toarray()
    full = [block.b @ la.solve(K - w**2 * M, block.b, assume_a="sym") for w in omega]
    np.testing.assert_allclose(star.receptance(omega), full, rtol=1e-6)


@pytest.mark.filterwarnings("ignore:.*with_mesh")
def test_vectors_fitted_to_large_models_know_a_short_answer_to_its_last_digits():
    """A wave runs up a rod for a tenth of the time that it takes to the other end."""
    K, M = rod(800, fixed=[0])
    tip = ao.FEModel(K=K, M=M).contact(dof=799)
    space = KrylovSpace(tip, contact_time=0.1, sharpened=True)
    hits = [
        ao.simulate(
            projectile=ao.rigid(mass=0.02),
            target=star,
            law=ao.Hertz(k=5e3),
            velocity=1.0,
            duration=0.12,
            solver=ao.Adaptive(rtol=1e-10),
            energies=False,
        )
        for star in (space.of_vectors(140), ao.antioscillators(tip))
    ]
    few, full = (hit.at(hits[1].t).pushes[0] for hit in hits)
    np.testing.assert_allclose(few, full, atol=1e-8 * full.max())
    # The same space, however it has grown.
    small = KrylovSpace(tip, contact_time=0.1, sharpened=True)
    for n in (5, 30, 60, 140):
        grown = small.of_vectors(n).star
    np.testing.assert_allclose(grown.m, space.of_vectors(140).star.m, rtol=1e-9)


@each("contact_time", [0.06, 1.0, 1e3])
def test_a_held_body_keeps_its_static_mode(contact_time):
    """However short the impact, φ_st = x/L of a clamped rod: k0 = EA/L = 1, m_st = M/3."""
    K, M = rod(100, fixed=[0])
    for n in (0, 1, 4):
        star = fitted(K, M, 99, n, contact_time=contact_time)
        assert star.n == n
        assert star.k0 == pytest.approx(1.0, rel=1e-9)
        assert star.static_mass == pytest.approx(1 / 3, rel=1e-4)
        assert fitted(K, M, 99, n, contact_time=0.06, duration=1e3).k0 == pytest.approx(1.0)


def test_a_partly_free_body_keeps_its_static_mode():
    """A beam on a pin and a roller may slide along them; struck across, it does not."""
    ends = [(lambda x: (x[:, 0] < 1e-9) & (x[:, 2] < 1e-9), "xz")]
    ends += [(lambda x: (x[:, 0] > 0.2 - 1e-9) & (x[:, 2] < 1e-9), "z")]
    body = ao.FEModel.from_mesh(box_mesh((0.2, 0.02, 0.02), (10, 2, 2)), STEEL, fixed=ends)
    assert body.rigid_modes.shape[1] == 1
    tip = body.contact(point=(0.1, 0.01, 0.02), direction=(0, 0, -1), radius=0)
    exact = ao.antioscillators(tip, 0)
    for contact_time in (2e-5, 1e-3):  # by the factors of K, and by those of K + s²M
        star = ao.antioscillators(tip, 3, method="krylov", contact_time=contact_time)
        assert star.k0 == pytest.approx(exact.k0, rel=1e-7)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:displacement of target may be off")  # by elements that lock
def test_vibration_long_after_the_blow_takes_a_duration(paper_beam):
    """Over 20 ms, two hundred blows' lengths, the contact's displacement is the whole star's."""
    tip, _, whole = paper_beam
    u = []
    for star in (
        ao.antioscillators(tip, 30, method="krylov", contact_time=90e-6, duration=20e-3),
        whole,
    ):
        hit = ao.simulate(ao.rigid(mass=BALL_MASS), star, 1.0, law=LAW, duration=20e-3)
        u.append(hit.at(np.linspace(0, 20e-3, 2001)).target.displacement)
    assert np.abs(u[0] - u[1]).max() <= 0.005 * np.abs(u[1]).max()


def test_a_whole_subspace_is_the_body():
    """As many vectors as dofs: the receptance is the body's at every frequency."""
    K, M = rod(12, fixed=[0])
    star = fitted(K, M, 11, 11, contact_time=1.0)
    omega = np.linspace(0.1, 60, 30)
    dense = K.toarray(), M.toarray()
    full = [la.inv(dense[0] - w**2 * dense[1])[11, 11] for w in omega]
    np.testing.assert_allclose(star.receptance(omega), full, rtol=1e-7)
    every = ao.antioscillators(ao.FEModel(K=K, M=M).contact(dof=11), order="frequency")
    np.testing.assert_allclose(star.m, every.m, rtol=1e-7)


# -------------------------------------------------------------------------------- hard cases


def test_only_what_the_contact_excites():
    """A beam struck at midspan moves symmetrically: 19 oscillators, however many are asked for."""
    K, M = beam(20, fixed=[0, 40])
    every = ao.antioscillators(ao.FEModel(K=K, M=M).contact(dof=19), order="frequency")
    with pytest.warns(ao.AOImpactWarning, match=r"^n"):
        star = fitted(K, M, 19, 35, contact_time=0.1)
    np.testing.assert_allclose(star.frequencies, every.frequencies, rtol=1e-6)
    np.testing.assert_allclose(star.m, every.m, rtol=1e-5)


def test_a_contact_without_stiffness_is_a_mass():
    """A loose mass beside two on a spring: what is asked of it is not how fast its waves are."""
    spring = np.array([[1e6, -1e6], [-1e6, 1e6]])
    body = ao.FEModel(K=la.block_diag(0.0, spring), M=np.diag([2.0, 3.0, 4.0]))
    star = ao.antioscillators(body.contact(dof=0), 0, method="krylov", contact_time=1e-3)
    assert (star.n, star.k0) == (0, 0.0)
    np.testing.assert_allclose(star.m0, 2.0, rtol=1e-12)


def test_a_slightly_negative_stiffness_is_named():
    """K of a rod whose softest motion gives a little energy back, as K that was printed may."""
    K, M = (matrix.toarray() for matrix in rod(12, fixed=[0]))
    omega2, modes = la.eigh(K, M)
    soft = M @ modes[:, 0]
    K -= (omega2[0] + 1e-10 * omega2[-1]) * np.outer(soft, soft)
    tip = ao.FEModel(K=0.5 * (K + K.T), M=M).contact(dof=11)
    with pytest.raises(ao.SingularError):
        ao.antioscillators(tip, 4, method="krylov", contact_time=1e3)


def test_multiple_eigenvalues_of_symmetric_bodies():
    """Three equal rods on one struck mass: every constraint mode is threefold, and one is seen."""
    one = rod(30)
    star, single = (fitted(*of, 0, 10, contact_time=0.3) for of in (joined(*one, 0, 3), one))
    np.testing.assert_allclose(star.m, 3 * single.m, rtol=1e-6)
    np.testing.assert_allclose(star.k, 3 * single.k, rtol=1e-6)


def test_nearly_incompressible_material(block):
    mesh = box_mesh((0.03, 0.02, 0.02), (4, 3, 3), kind="hexahedron20")
    rubber = ao.Material(E=5e6, nu=0.4999, rho=1000)
    tip = ao.FEModel.from_mesh(mesh, rubber, fixed=[("xmin", "xyz")]).contact(
        point=(0.03, 0.02 / 3, 0.02 / 3), direction=(-1, 0, 0), radius=0
    )
    T = 2e-3
    star = ao.antioscillators(tip, 12, method="krylov", contact_time=T)
    s = np.geomspace(2.0, 30.0, 10) / T
    np.testing.assert_allclose(star_at(star, s), laplace_receptance(tip.body, tip.b, s), rtol=1e-5)


def test_elements_of_very_different_size():
    """A rod of a hundred elements between 1 and 1e-4 of the largest's length."""
    h = np.geomspace(1, 1e-4, 100)
    h /= h.sum()
    n = len(h)
    K, M = sp.lil_matrix((n + 1, n + 1)), sp.lil_matrix((n + 1, n + 1))
    for i, length in enumerate(h):
        here = slice(i, i + 2)
        K[here, here] += np.array([[1, -1], [-1, 1]]) / length
        M[here, here] += np.array([[2, 1], [1, 2]]) * length / 6
    body = ao.FEModel(K=K.tocsr()[1:, 1:], M=M.tocsr()[1:, 1:])
    tip = body.contact(dof=n - 1)
    star = ao.antioscillators(tip, 15, method="krylov", contact_time=1.0)
    s = np.geomspace(3.0, 30.0, 10)
    np.testing.assert_allclose(star_at(star, s), laplace_receptance(body, tip.b, s), rtol=1e-6)


def test_a_contact_time_far_off_is_refused_or_harmless(block):
    with pytest.raises(ao.InputError, match=r"^contact_time"):
        ao.antioscillators(block, 3, method="krylov", contact_time=1e-8)
    # Much longer ones give the same first oscillators: those of the slow motion.
    mesh = box_mesh((0.03, 0.02, 0.02), (4, 3, 3), kind="hexahedron20")
    held = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])
    tip = held.contact(point=(0.03, 0.02, 0.02 / 3), direction=(-1, 0, 0), radius=0)
    for body in (block, tip):
        exact = ao.antioscillators(body, order="frequency")
        for contact_time in (1e-2, 1.0):
            slow = ao.antioscillators(body, 8, method="krylov", contact_time=contact_time)
            np.testing.assert_allclose(slow.frequencies[:2], exact.frequencies[:2], rtol=1e-4)
    with pytest.raises(ao.SingularError, match=r"^K"):
        ao.antioscillators(block, 8, method="krylov", contact_time=1e6)


def test_models_on_vectors_that_are_solved_roughly_are_as_exact():
    """At a node of a thin plate, the hardest for iterations; the truth is solved for directly."""
    mesh = box_mesh((0.1, 0.05, 0.005), (10, 5, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=ENDS)
    tip = body.contact(point=(0.04, 0.02, 0.005), direction=(0, 0, -1), radius=0)
    roughly, exactly = (
        KrylovSpace(tip, contact_time=50e-6, solver=name) for name in ("multigrid", "superlu")
    )
    s = roughly.shift * np.array([0.03, 0.1, 0.3, 1.0, 2.0, 4.0])
    true = laplace_receptance(body, tip.b, s)
    for n in (2, 4, 8, 16):
        one, other = (
            np.abs(star_at(space.antioscillators(n), s) / true - 1.0)
            for space in (roughly, exactly)
        )
        assert (one <= 1.1 * other + 1e-7).all()


ENDS = [("xmin", "xyz"), ("xmax", "xyz")]

CONSTRAINED = {
    "block": ((0.02, 0.02, 0.02), (4, 4, 4), "hexahedron20", 1e-5),
    "bar": ((0.5, 0.02, 0.02), (40, 1, 1), "hexahedron20", 9e-5),
    "bar of hexahedra": ((0.5, 0.02, 0.02), (40, 1, 1), "hexahedron", 9e-5),
    "bar of tetrahedra": ((0.3, 0.02, 0.02), (30, 1, 1), "tetra10", 9e-5),
    "plate": ((0.2, 0.2, 0.01), (8, 8, 1), "hexahedron20", 9e-5),
}


@each("name", CONSTRAINED)
@pytest.mark.parametrize(
    "solver", ["superlu", "multigrid", pytest.param("pardiso", marks=needs_pardiso)]
)
def test_constrained_bodies_keep_their_static_stiffness(name, solver):
    """With any solver, compact or slender; larger models ask for factors of K + s²M again."""
    size, divisions, kind, contact_time = CONSTRAINED[name]
    body = ao.FEModel.from_mesh(box_mesh(size, divisions, kind=kind), STEEL, fixed=ENDS)
    tip = body.contact(point=(size[0] / 2, size[1] / 2, size[2]), direction=(0, 0, -1), radius=0)
    exact = 1.0 / (tip.b @ body.inverse(0.0).solve(tip.b))
    space = KrylovSpace(tip, contact_time=contact_time, solver=solver)
    for n in (1, 4, 12):
        star = space.antioscillators(n)
        assert star.n == n
        assert star.k0 == pytest.approx(exact, rel=1e-8)


def test_a_mechanism_that_the_force_does_not_move_is_named():
    """A piece joined to a bar along one edge, about which it may swing."""
    bar = box_mesh((0.5, 0.02, 0.02), (40, 2, 2), kind="hexahedron20")
    piece = box_mesh((0.025, 0.02, 0.02), (2, 2, 2), kind="hexahedron20")
    nodes = np.vstack([bar.nodes, piece.nodes + np.array([0.25, 0.02, 0.02])])
    _, first, number = np.unique(nodes.round(9), axis=0, return_index=True, return_inverse=True)
    cells = np.vstack([bar.cells, piece.cells + len(bar.nodes)])
    mesh = ao.Mesh(nodes[first], number.ravel()[cells], "hexahedron20")
    fixed = [(lambda x: x[:, 0] < 1e-6, "xyz"), (lambda x: x[:, 0] > 0.5 - 1e-6, "xyz")]
    tip = ao.FEModel.from_mesh(mesh, STEEL, fixed=fixed).contact(
        point=(0.125, 0.01, 0.02), direction=(0, 0, -1), radius=0
    )
    with pytest.raises(ao.SingularError, match="mechanism"):
        ao.antioscillators(tip, 6, method="krylov", contact_time=9e-5)
