"""Models no larger than the answer asked for needs: its true error is what was allowed."""

import functools
import math

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.answer import Answer
from aoimpact.errors import held_warnings
from aoimpact.krylov import KrylovSpace
from aoimpact.paper_beam import LAW, LENGTH, WIDTH, beam_model
from aoimpact.paper_sphere import BALL_MASS

from twelve import ALUMINIUM, ENDS, IMPACTS, STEEL, beam, cube, law

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4)


def whole(body):
    """All of a body's anti-oscillators."""
    return ao.antioscillators(body) if isinstance(body, ao.ContactPoint) else body


# ------------------------------------------------------------------------------ the paper's scene


@pytest.fixture(scope="module")
def paper():
    tip = beam_model().contact(point=(LENGTH / 2, WIDTH / 2, WIDTH), direction=(0, 0, -1))
    sphere = ao.AOModel(m0=0.001 * BALL_MASS, m=[0.999 * BALL_MASS], k=[275.7e6])
    return functools.partial(ao.simulate, projectile=sphere, target=tip, law=LAW, velocity=1.0)


def test_a_rigid_sphere_gives_the_beams_displacement(paper):
    """The paper's conclusion: for the structure's displacement the projectile may be rigid."""
    hit = paper(duration=20e-3, quantity="target_displacement", rtol=3e-2)
    assert hit.models[0].label == "rigid"
    full = paper(target=whole(paper.keywords["target"]), duration=20e-3)
    assert Answer("target_displacement").difference(hit, full) <= 3e-2


def test_a_rigid_sphere_does_not_give_the_force(paper):
    for quantity in ("force", "peak_force"):
        hit = paper(duration=250e-6, quantity=quantity, rtol=3e-2)
        assert hit.models[0].label == "AO(1)"
        assert hit.projectile.label == "AO(1)"


def test_error_says_what_models_and_what_time_integration_add(paper):
    hit = paper(duration=250e-6, quantity="force", rtol=1e-2)
    assert 1e-4 < hit.error.reduction <= 1e-2
    assert hit.error.time <= 1e-3
    full = paper(target=whole(paper.keywords["target"]), duration=250e-6)
    assert Answer("force").difference(hit, full) <= 1e-2


def test_quantity_and_tolerance_have_defaults(paper):
    by_default = paper(duration=250e-6, rtol=1e-2)
    same = paper(duration=250e-6, quantity="force")
    assert by_default.peak_force == same.peak_force
    assert paper(target=ao.rigid(mass=1.0), duration=250e-6).models is None


# ------------------------------------------------------------------- true errors, and least orders


@pytest.mark.slow
@pytest.mark.parametrize("name", IMPACTS)
def test_true_error_is_within_the_tolerance(name):
    projectile, target, contact_law, velocity, duration = IMPACTS[name]()
    run = functools.partial(ao.simulate, law=contact_law, velocity=velocity, duration=duration)
    full = run(projectile=whole(projectile), target=whole(target))
    asked = [(quantity, rtol) for quantity in ("force", "rebound") for rtol in TOLERANCES]
    for quantity, rtol in [*asked, ("target_displacement", 1e-2)]:
        hit = run(projectile=projectile, target=target, quantity=quantity, rtol=rtol)
        assert Answer(quantity).difference(hit, full) <= rtol, (quantity, rtol)
        assert hit.error.reduction <= rtol


@pytest.mark.slow
def test_order_is_at_most_two_above_the_least_in_nine_of_ten():
    """The least is found by trying all pairs of orders against the whole bodies."""
    excess = []
    for make in IMPACTS.values():
        projectile, target, contact_law, velocity, duration = make()
        run = functools.partial(ao.simulate, law=contact_law, velocity=velocity, duration=duration)
        full = run(projectile=whole(projectile), target=whole(target))
        for rtol in (1e-1, 1e-2):
            hit = run(projectile=projectile, target=target, rtol=rtol)
            taken = sum(model.n for model in hit.models)
            bodies = [
                models_up_to(body, full.contact_duration, taken) for body in (projectile, target)
            ]
            excess.append(taken - least_sum(bodies, run, full, rtol, taken))
    assert np.mean(np.array(excess) <= 2) >= 0.9


def models_up_to(body, contact_time, most):
    if isinstance(body, ao.AOModel):
        return [body]
    space = KrylovSpace(body, contact_time=contact_time)
    models = [space.antioscillators(n) for n in range(most + 1)]
    return [ao.rigid(mass=math.inf), *models] if models[0].held else models


def least_sum(bodies, run, full, rtol, most):
    for wanted in range(most):
        for one in bodies[0]:
            for other in bodies[1]:
                if one.n + other.n != wanted or (math.isinf(one.m0) and math.isinf(other.m0)):
                    continue
                with held_warnings():
                    hit = run(projectile=one, target=other, solver=ao.Adaptive(rtol=1e-5))
                if Answer("force").difference(hit, full) <= rtol:
                    return wanted
    return most


def test_a_compact_block_may_be_a_rigid_wall():
    """For the rebound of a steel cube from a held aluminium block neither has to deform."""
    projectile, target, contact_law, velocity, duration = IMPACTS["compact on held compact"]()
    hit = ao.simulate(
        projectile=projectile,
        target=target,
        law=contact_law,
        velocity=velocity,
        duration=duration,
        quantity="rebound",
        rtol=1e-2,
    )
    assert [model.label for model in hit.models] == ["rigid", "wall"]


def test_a_named_point():
    """A quarter of the beam's length from the blow, for five contact times."""
    target = beam(ENDS)
    point = target.body.contact(point=(0.15 / 2, 0.01, 0.02), direction=(0, 0, -1))
    run = functools.partial(
        ao.simulate,
        projectile=ao.rigid(mass=0.06),
        law=law(STEEL, 0.01, ALUMINIUM),
        velocity=1.0,
        duration=6e-4,
    )
    hit = run(target=target, quantity=point, rtol=1e-2)
    full = run(target=whole(target))
    times = np.linspace(0, 6e-4, 200)
    mine, right = (each.target.displacement_of(point.b, times) for each in (hit, full))
    assert np.abs(mine - right).max() <= 1e-2 * np.abs(right).max()
    # The same point by the fields of the whole model.
    seen = full.target.probe(point=point.point, direction=(0, 0, -1), times=times)
    np.testing.assert_allclose(right, seen.displacement, atol=1e-4 * np.abs(right).max())


def test_the_linear_solver_is_the_users_and_named(own_solver):
    run = functools.partial(
        ao.simulate,
        projectile=cube(STEEL, 0.02),
        target=beam(ENDS),
        law=law(STEEL, 0.01, ALUMINIUM),
        velocity=1.0,
        duration=2e-4,
        rtol=5e-2,
    )
    hit = run(linear_solver=own_solver)
    assert set(own_solver.calls) == {375, 513}  # dofs of both bodies
    assert {model.origin.solver for model in hit.models} == {"Own"}
    assert "linear solver" in str(hit)
    assert "Own" in str(hit)
    same = run(linear_solver="superlu")
    assert "superlu" in str(same)
    assert hit.peak_force == pytest.approx(same.peak_force, rel=1e-7)


def test_scenes_take_a_linear_solver_too(own_solver):
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=0.06), velocity=1.0)
    scene.connect(ball, scene.add(beam(ENDS)), law(STEEL, 0.01, ALUMINIUM))
    run = scene.simulate(duration=2e-4, rtol=5e-2, linear_solver=own_solver)
    assert set(own_solver.calls) == {513}
    assert run.models[1].origin.solver == "Own"
    with pytest.raises(ao.InputError, match="give quantity or rtol"):
        scene.simulate(duration=2e-4, linear_solver="superlu")


# ------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"quantity": "strength"}, "quantity must be one of"),
        ({"quantity": "forse"}, "did you mean 'force'"),
        ({"quantity": 3}, "quantity"),
        ({"rtol": 0.0}, "rtol must be positive"),
        ({"rtol": 1.0}, "rtol must be from 1e-08 to below 1"),
        ({"rtol": 1e-12}, "rtol must be from 1e-08 to below 1"),
        ({"rtol": "small"}, "rtol"),
        ({"rtol": 1e-2, "linear_solver": "superlux"}, "did you mean 'superlu'"),
        ({"linear_solver": "superlu"}, "give quantity or rtol"),
    ],
)
def test_bad_arguments_are_named(paper, options, message):
    with pytest.raises(ao.AOImpactError, match=message):
        paper(duration=250e-6, **options)


def test_a_point_of_another_body_is_refused(paper):
    with pytest.raises(ao.InputError, match="on neither projectile nor target"):
        paper(duration=250e-6, quantity=cube(STEEL, 0.01))
