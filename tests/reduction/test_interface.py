"""Bodies touched in several places: their modes give the full receptance between the ports."""

import numpy as np
import pytest
import scipy.linalg as la

import aoimpact as ao
from aoimpact import Rayleigh, box_mesh

from slender import beam, rod

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
T = 20e-6


def block_tips(fixed=None):
    """A block struck on its end face and, the same way, pushed from behind."""
    mesh = box_mesh((0.03, 0.02, 0.02), (4, 3, 3), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=fixed)
    return [
        body.contact(point=(0.03, 0.02, 0.02 / 3), direction=(1, 0, 0), radius=0),
        body.contact(point=(0.0, 0.02 / 3, 0.02 / 3), direction=(1, 0, 0), radius=0),
    ]


@pytest.fixture(scope="module")
def free():
    return block_tips()


@pytest.fixture(scope="module")
def held():
    return block_tips(fixed=[("ymin", "xyz")])


def full_receptance(tips, x):
    """B^T (K + x M)^-1 B."""
    B = np.stack([tip.b for tip in tips])
    K, M = tips[0].body.K.toarray(), tips[0].body.M.toarray()
    return B @ la.solve(K + x * M, B.T)


@pytest.mark.parametrize("which", ["free", "held"])
def test_receptance_between_the_ports_is_the_bodys(which, request):
    tips = request.getfixturevalue(which)
    model = ao.interface(tips, 30, contact_time=T)
    r = model.participation
    for s in np.array([3.0, 10.0, 20.0]) / T:
        projected = (r / (model.omega**2 + s**2)) @ r.T
        full = full_receptance(tips, s**2)
        assert np.abs(projected - full).max() <= 1e-6 * np.abs(full).max()
    for omega in np.array([0.5, 2.0, 5.0]) / T:
        full = full_receptance(tips, -(omega**2))
        assert np.abs(model.receptance(omega) - full).max() <= 1e-6 * np.abs(full).max()


def test_one_port_is_the_star(free):
    """The star of the same subspace, seen through its natural modes."""
    model = ao.interface(free[:1], 6 + 5, contact_time=T, duration=T)
    star = ao.antioscillators(free[0], 5, method="krylov", contact_time=T)
    omega = np.linspace(0.1, 5.0, 9) / T
    np.testing.assert_allclose(model.receptance(omega)[:, 0, 0], star.receptance(omega), rtol=1e-8)


def test_a_free_body_has_its_rigid_motions_and_its_mass(free):
    model = ao.interface(free, 14, contact_time=T)
    assert (model.omega[:6] == 0.0).all()
    assert (model.omega[6:] > 0.0).all()
    mass = 7800 * 12e-6
    assert model.mass == pytest.approx(mass, rel=1e-10)
    # Translating at 1 m/s: all of the kinetic energy, and 1 m/s at the centre and at both ports.
    rates, centre = model.whole.moving, model.whole.centre
    assert rates @ rates == pytest.approx(mass, rel=1e-10)
    assert centre @ rates == pytest.approx(1.0, rel=1e-10)
    np.testing.assert_allclose(model.participation @ rates, 1.0, rtol=1e-10)
    along = np.tile([1.0, 0.0, 0.0], model.body.n_dofs // 3)
    np.testing.assert_allclose(model.expand(rates), along, atol=1e-9)
    # Vibration leaves the centre of mass where it is.
    np.testing.assert_allclose(centre[6:], 0.0, atol=1e-9)


def test_ports_that_move_alike_are_one():
    """A beam struck at midspan by two bodies: the second adds no vector."""
    K, M = beam(20, fixed=[0, 40])
    body = ao.FEModel(K=K, M=M)
    middle = body.contact(dof=19)
    twice = ao.interface([middle, middle], 8, contact_time=0.1, duration=0.1)
    once = ao.interface([middle], 8, contact_time=0.1, duration=0.1)
    np.testing.assert_allclose(twice.omega, once.omega, rtol=1e-8)
    np.testing.assert_allclose(twice.participation[0], twice.participation[1])


def test_damping_is_the_bodys():
    """One port of a damped body: the damped star's receptance."""
    K, M = beam(20, fixed=[0, 40])
    tip = ao.FEModel(K=K, M=M, damping=Rayleigh(alpha=0.1, beta=1e-4)).contact(dof=19)
    model = ao.interface([tip], 8, contact_time=0.1)
    star = ao.antioscillators(tip, 7, method="krylov", contact_time=0.1)
    omega = np.linspace(0.0, 200.0, 9)
    np.testing.assert_allclose(model.receptance(omega)[:, 0, 0], star.receptance(omega), rtol=1e-7)
    assert model.damping == star.damping == Rayleigh(alpha=0.1, beta=1e-4)


def test_ports_that_excite_few_modes():
    """A free rod of five nodes, struck at its middle one, has three symmetric modes."""
    K, M = rod(4)
    with pytest.warns(ao.AOImpactWarning, match=r"^n"):
        assert ao.interface([ao.FEModel(K=K, M=M).contact(dof=2)], 5, contact_time=5.0).n == 3


def test_without_nodes_the_centre_of_mass_is_not_known():
    K, M = beam(6, fixed=[0, 12])
    model = ao.interface([ao.FEModel(K=K, M=M).contact(dof=5)], 3)
    assert model.known_mass is None
    with pytest.raises(ao.InputError, match=r"^coordinates"):
        model.expand(np.ones(4))
