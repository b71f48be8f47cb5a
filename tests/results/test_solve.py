"""A contact that goes deeper than its law holds is named, with the cure that is its own."""

from __future__ import annotations

import pickle
from functools import cache

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800.0)
BALL, WALL = ao.rigid(mass=0.1), ao.rigid(mass=float("inf"))
WIDE = ao.Hertz.between(STEEL, 0.5, STEEL, float("inf"))
SOFT = ao.Hertz(k=1e8)
SHORT = ao.Tabulated([1e-6, 1e-5], [0.1, 1.0])
DEPTH = np.linspace(1e-6, 1e-2, 100)
LONG = ao.Tabulated(DEPTH, SOFT.k * DEPTH**1.5)
SOLVERS = [ao.Adaptive(), ao.Newmark(dt=2e-8, estimate=False)]


@cache
def block(radius: float) -> ao.AOModel:
    """A block of 100 by 100 by 50 mm, touched in the middle of its top."""
    mesh = ao.box_mesh((0.1, 0.1, 0.05), (6, 6, 2), kind="hexahedron20")
    place = ao.FEModel.from_mesh(mesh, STEEL).contact(point=(0.05, 0.05, 0.05), radius=radius)
    return ao.antioscillators(place, n=5, method="krylov", contact_time=30e-6)


def refused(scene: ao.Scene, solver: ao.Adaptive | ao.Newmark) -> ao.base.LawLimitError:
    with pytest.raises(ao.base.LawLimitError) as caught:
        scene.simulate(duration=40e-6, solver=solver)
    return caught.value


def two_strikes(first: float, second: float, laws: tuple[ao.ContactLaw, ...]) -> ao.Scene:
    """Two balls, each against a block of its own with that radius of patch, at 80 m/s."""
    scene = ao.Scene()
    for radius, law in zip((first, second), laws, strict=True):
        target = scene.add(block(radius) if radius else WALL)
        scene.connect(scene.add(BALL, velocity=80.0), target, law)
    return scene


@pytest.mark.parametrize("solver", SOLVERS, ids=["adaptive", "newmark"])
def test_of_two_patches_the_one_that_is_too_small_is_named(
    solver: ao.Adaptive | ao.Newmark,
) -> None:
    error = refused(two_strikes(0.02, 0.004, (WIDE, WIDE)), solver)
    assert error.contact == 1
    assert str(error).startswith("contact 1: ")
    assert "leaves nothing of the law; give the contact points radius=0.0" in str(error)
    again = pickle.loads(pickle.dumps(error))
    assert (again.contact, str(again)) == (1, str(error))


@pytest.mark.parametrize("solver", SOLVERS, ids=["adaptive", "newmark"])
def test_where_a_table_ends_the_cure_is_no_patch(solver: ao.Adaptive | ao.Newmark) -> None:
    error = refused(two_strikes(0.02, 0.0, (WIDE, SHORT)), solver)
    assert error.contact == 1
    assert "give deeper values" in str(error)
    assert "radius=" not in str(error)


@pytest.mark.parametrize("solver", SOLVERS, ids=["adaptive", "newmark"])
@pytest.mark.parametrize("short", range(5))
def test_the_number_is_that_of_the_scene_in_whatever_order_contacts_are_solved(
    short: int, solver: ao.Adaptive | ao.Newmark
) -> None:
    scene = ao.Scene()
    balls = [scene.add(BALL, velocity=float(-i)) for i in range(6)]
    for number, i in enumerate((0, 4, 2, 1, 3)):  # neighbours are far apart in this order
        scene.connect(balls[i], balls[i + 1], SHORT if number == short else LONG)
    assert refused(scene, solver).contact == short


def test_a_scene_that_rests_too_deep_says_it_of_the_rest() -> None:
    scene = ao.Scene(gravity=9.81)
    floor = scene.add(WALL)
    scene.connect(scene.add(BALL), floor, SOFT.within_patch(1e-10))
    scene.connect(scene.add(ao.rigid(mass=10.0)), floor, ao.Tabulated([1e-6, 1e-5], [0.1, 50.0]))
    with pytest.raises(ao.InputError, match=r"^preload"):
        scene.simulate(duration=1e-4, preload=True)
