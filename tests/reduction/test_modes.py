"""The modal truncation, and that it is a star in other coordinates."""

import numpy as np
import pytest

import aoimpact as ao

from slender import beam, joined, rod


def test_modes_of_a_clamped_rod():
    """f_j = (j - ½)/2 · c/L."""
    body = ao.FEModel(**dict(zip("KM", rod(400, fixed=[0]), strict=True)))
    modes = ao.modal(body.contact(dof=399), 3)
    np.testing.assert_allclose(modes.frequencies, [0.25, 0.75, 1.25], rtol=1e-4)


@pytest.mark.parametrize("fixed", [[], [0]], ids=["free", "held"])
@pytest.mark.parametrize("n", [1, 2, 7, 31])
@pytest.mark.filterwarnings("ignore:receptance:aoimpact.AOImpactWarning")
def test_the_star_of_a_modal_model_has_its_receptance(fixed, n):
    K, M = rod(31, fixed=fixed)
    modes = ao.modal(ao.FEModel(K=K, M=M).contact(dof=30), n)
    omega = np.linspace(0.1, 200, 50)
    expected = [np.sum(modes.participation[0] ** 2 / (modes.omega**2 - w**2)) for w in omega]
    np.testing.assert_allclose(modes.star.receptance(omega), expected, rtol=1e-7)
    assert modes.star.n == n - 1
    assert modes.label == f"modal({n})"


def test_all_modes_and_all_antioscillators_are_one_model():
    K, M = beam(12, fixed=[0, 24])
    tip = ao.FEModel(K=K, M=M).contact(dof=5)
    by_modes = ao.modal(tip, K.shape[0]).star
    by_constraint_modes = ao.antioscillators(tip, order="frequency")
    assert by_modes.n == by_constraint_modes.n
    np.testing.assert_allclose(by_modes.m, by_constraint_modes.m, rtol=1e-6)
    np.testing.assert_allclose(by_modes.k, by_constraint_modes.k, rtol=1e-6)
    assert by_modes.m0 == pytest.approx(by_constraint_modes.m0, rel=1e-6)
    assert by_modes.k0 == pytest.approx(by_constraint_modes.k0, rel=1e-9)


def test_few_modes_are_too_stiff_at_the_contact():
    """The compliance that the modes left out would add is missing: k0 lies above the true one."""
    K, M = rod(60, fixed=[0])
    tip = ao.FEModel(K=K, M=M).contact(dof=59)
    stiffness = [ao.modal(tip, n).star.k0 for n in (1, 2, 4, 8, 60)]
    assert (np.diff(stiffness) < 0).all()
    assert stiffness[-1] == pytest.approx(1.0, rel=1e-9)
    # Σ_{j>n} r_j²/ω_j² ≈ 2/π² Σ 1/(j-½)²: the slow convergence that the paper complains of.
    left_out = 1 - 1 / stiffness[3]
    assert left_out == pytest.approx(2 / np.pi**2 / 8, rel=0.02)


def test_modes_of_one_frequency_act_as_one():
    """Two equal rods joined at their struck ends: half of the modes never move the contact."""
    K, M = rod(20, fixed=[0])
    one = ao.modal(ao.FEModel(K=K, M=M).contact(dof=19), 20).star
    both = ao.modal(ao.FEModel(*joined(K, M, 19, 2)).contact(dof=0), 39).star
    assert both.n == one.n
    np.testing.assert_allclose(both.m, 2 * one.m, rtol=1e-7)
    np.testing.assert_allclose(both.k, 2 * one.k, rtol=1e-7)


def test_expansion_of_a_modal_star_lies_in_its_modes():
    K, M = rod(25)
    modes = ao.modal(ao.FEModel(K=K, M=M).contact(dof=25), 6)
    coordinates = np.random.default_rng(0).standard_normal(6)
    full = modes.star.expand(coordinates)
    assert full[25] == pytest.approx(coordinates[0])
    inside = modes.modes @ (modes.modes.T @ (M @ full))
    np.testing.assert_allclose(full, inside, atol=1e-10)
    star = modes.star
    assert full @ (M @ full) == pytest.approx(
        star.m0 * coordinates[0] ** 2 + star.m @ coordinates[1:] ** 2, rel=1e-9
    )


def test_modes_that_do_not_move_the_contact_are_no_model():
    K, M = beam(10, fixed=[0, 20])
    tip = ao.FEModel(K=K, M=M).contact(dof=10)  # slope at midspan: still in every symmetric mode
    with pytest.raises(ao.InputError, match="modes"):
        _ = ao.modal(tip, 1).star


def test_part_of_the_rigid_motions_is_no_model():
    """Which of them come first is arbitrary, and so is what moves at the contact."""
    chain = ao.FEModel(K=np.zeros((3, 3)), M=np.eye(3))  # three masses that nothing holds together
    with pytest.warns(ao.AOImpactWarning, match=r"^n"):
        ao.modal(chain.contact(dof=1), 2)
