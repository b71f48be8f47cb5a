"""Dofs without mass: a body of such matrices is the one in which they are condensed by hand."""

from __future__ import annotations

import functools
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

import aoimpact as ao

from slender import beam

# Their matrices are of no solid elements, in which a force at a node sinks in.
pytestmark = pytest.mark.filterwarnings("ignore:.*with_mesh:aoimpact.AOImpactWarning")

EI, LENGTH, LINE = 1e3, 0.5, 1.0  # N m², m, kg/m


@functools.cache
def bodies(elements: int, held: bool) -> tuple[ao.FEModel, ao.FEModel]:
    """A beam with lumped masses and massless rotations, and its deflections alone.

    Cubic elements; the first end is clamped or free. Condensed on a Cholesky factor.
    """
    K = EI / LENGTH**3 * beam(elements)[0].toarray()  # of deflections, and of slopes times L
    lumps = np.zeros(len(K))
    lumps[::2] = LINE * LENGTH / elements
    lumps[[0, -2]] *= 0.5
    M = np.diag(lumps)
    if held:
        K, M = K[2:, 2:], M[2:, 2:]
    across = K[1::2, ::2]
    condensed = K[::2, ::2] - across.T @ scipy.linalg.solve(K[1::2, 1::2], across, assume_a="pos")
    whole = ao.FEModel(sp.csr_array(K), sp.csr_array(M)) if elements > 8 else ao.FEModel(K, M)
    return whole, ao.FEModel(0.5 * (condensed + condensed.T), M[::2, ::2])


def tips(elements: int, held: bool) -> tuple[ao.ContactPoint, ao.ContactPoint]:
    whole, condensed = bodies(elements, held)
    return whole.contact(dof=whole.n_dofs - 2), condensed.contact(dof=condensed.n_dofs - 1)


# 400 elements have more dofs than dense matrices are made of; the digits that condensing costs K
# grow with the number of elements to the fourth power.
SIZES = pytest.mark.parametrize(("elements", "rtol"), [(8, 1e-9), (400, 2e-5)])


@SIZES
@pytest.mark.parametrize("held", [True, False])
def test_frequencies(elements: int, rtol: float, held: bool) -> None:
    whole, condensed = bodies(elements, held)
    found, wanted = whole.frequencies(5), condensed.frequencies(5)
    np.testing.assert_allclose(found, wanted, rtol=rtol, atol=1e-9 * wanted[-1])
    if held and elements == 400:  # 3.5160² and 22.0345² of Euler's cantilever
        closed = np.array([1.875104, 4.694091]) ** 2 / LENGTH**2 * np.sqrt(EI / LINE) / (2 * np.pi)
        np.testing.assert_allclose(found[:2], closed, rtol=2e-5)


@SIZES
@pytest.mark.parametrize("model", [lambda tip: tip, ao.full, functools.partial(ao.modal, n=6)])
def test_impacts(elements: int, rtol: float, model: Callable[[Any], Any]) -> None:
    """By models chosen for a tolerance, by Newmark's rule on K and M, and by natural modes."""
    found, wanted = (
        ao.simulate(ao.rigid(mass=0.1), model(tip), 1.0, law=ao.Hertz(k=1e8), duration=2e-3)
        for tip in tips(elements, True)
    )
    np.testing.assert_allclose(found.peak_force, wanted.peak_force, rtol=10 * rtol)
    np.testing.assert_allclose(found.impulse, wanted.impulse, rtol=10 * rtol)


def test_contact_on_a_dof_without_mass_has_no_contact_mass() -> None:
    """All anti-oscillators and the full model agree; what leaves compliance out is refused."""
    whole, _ = bodies(8, True)
    turned = whole.contact(dof=whole.n_dofs - 1)
    model = ao.antioscillators(turned)
    assert model.m0 == pickle.loads(pickle.dumps(model)).modal.star.m0 == 0.0
    # With all others at rest the dof has its own stiffness, less what massless ones give way.
    K = whole.K.toarray()[1::2, 1::2]
    own = 1.0 / np.linalg.inv(K)[-1, -1]
    np.testing.assert_allclose(model.k0 + model.k.sum(), own, rtol=1e-9)
    with pytest.warns(ao.AOImpactWarning, match="contact"):
        of_all, of_full = (
            ao.simulate(ao.rigid(mass=0.1), one, 1.0, law=ao.Hertz(k=1e8), duration=3e-3)
            for one in (model, ao.full(turned))
        )
    np.testing.assert_allclose(of_all.peak_force, of_full.peak_force, rtol=1e-3)
    for refused in (
        lambda: ao.modal(turned, 4),
        lambda: ao.antioscillators(turned, 4, method="krylov", contact_time=1e-3),
        lambda: ao.interface([turned], 4),
        lambda: ao.simulate(ao.rigid(mass=0.1), turned, 1.0, law=ao.Hertz(k=1e8)),
    ):
        with pytest.raises(ao.InputError, match="method="):
            refused()
