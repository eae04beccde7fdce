"""Laws of the fit: it never worsens, keeps its bounds, finds what is there, and goes on where it was stopped."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from estexp_jax.discovery.fitting import fit
from estexp_jax.discovery.hypotheses import Free, Hypothesis, claiming, parameters_only
from estexp_jax.discovery.slopes import DAMPINGS, Fit, movable, rescaled
from estexp_jax.discovery.walks import Walk, data_costs, heeded
from estexp_jax.physics.effects.registry import catalogue, effect
from tests.discovery.planted import CASES, case_of, finished, nominal, problem_of

PRICE = 1.0
"""Of values of the model, where the best hypothesis leaves some ten deviations."""
PLACES = ("coulomb_friction", "shaft"), ("command_delay", "servo"), ("sensor_bias", "angle"), ("body_mass", "arm")


@pytest.fixture(scope="module")
def setting():
    robot, plant, seed = CASES["coulomb_friction@shaft"]
    case = case_of(robot, plant, seed)
    problem = problem_of(case)
    parameters = parameters_only(case.robot, problem.replayer.catalogue)
    problem = problem.about((parameters, parameters.start()))
    hypotheses = [parameters, *(claiming(case.robot, parameters, [place]) for place in PLACES)]
    return problem, problem.windows_of(case.indices("train")), hypotheses


def random_starts(hypotheses, seed):
    rng = np.random.default_rng(seed)
    return [(h, [np.array([rng.uniform(f.low, f.high) for f in h.free])]) for h in hypotheses]


def spread(problem, h):
    robot = problem.replayer.robot
    own = [h.with_values((e, s), v) for e, s in h.places for v in effect(e).initial_guesses(robot, s, problem.seen)]
    return [h.start(), *own]


def run(problem, tasks, windows, iterations, stage):
    return finished(fit(problem, tasks, windows, PRICE, stage=stage, iterations=iterations))


def test_more_steps_never_worsen_a_fit_and_never_leave_the_bounds(setting):
    problem, windows, hypotheses = setting
    tasks = random_starts(hypotheses, 71)
    costs = []
    for iterations in (0, 1, 2, 4):
        fits = run(problem, tasks, windows, iterations, f"law {iterations}")
        costs.append([f.cost for f in fits])
        for f in fits:
            assert all(p.low <= v <= p.high for p, v in zip(f.hypothesis.free, f.vector, strict=True))
    assert np.all(np.diff(costs, axis=0) <= 0.0)
    assert np.all(np.array(costs[-1]) < 0.5 * np.array(costs[0]))


def test_derivatives_mended_by_a_step_explain_that_step(setting):
    _, windows, hypotheses = setting
    h, rng = hypotheses[0], np.random.default_rng(77)
    shape = (2, 5)
    at = Fit(h, h.start(), 2.0)
    walk = Walk(at, movable(h), rng.standard_normal(shape), rng.standard_normal((*shape, len(h.free))), 0.0)
    before, step = walk.residual, 0.1 * np.array([f.size for f in h.free])
    shown = 0.1 * rng.standard_normal((2, *shape))
    shown[1] *= 5.0
    walk.step_to([at.vector + step, at.vector - step], shown)
    assert walk.at.vector == pytest.approx(at.vector + step) and walk.at.cost == pytest.approx(np.sum(shown[0] ** 2))
    assert walk.derivative @ step == pytest.approx(shown[0] - before)


def test_a_hypothesis_without_parameters_stays_what_it_is(setting):
    problem, windows, _ = setting
    (found,) = run(problem, [(Hypothesis((), ()), [np.zeros(0)])], windows, 3, "nothing free")
    assert found.vector.shape == (0,) and 0.0 < found.cost < np.inf


class Rugged:
    """A comparison whose residuals turn up and down, so that most steps lead uphill."""

    def __init__(self) -> None:
        self.memory: dict[str, Any] = {}
        self.counted = [0]
        self.replayer, self.parting = SimpleNamespace(robot=nominal("one")), False

    def residuals(self, members, windows) -> np.ndarray:
        size = np.array([f.size for f in members[0][0].free])
        places = np.array([(vector - h.start()) / size for h, vector in members])
        return np.concatenate([1.1 + np.sin(37.0 * places), 0.3 * np.cos(91.0 * places)], axis=1)[:, None]


def test_a_step_uphill_is_not_taken(setting):
    _, windows, hypotheses = setting
    tasks, rugged = random_starts(hypotheses[:1] * 20, 74), Rugged()
    costs = [[f.cost for f in run(rugged, tasks, windows, n, f"rugged {n}")] for n in range(5)]
    assert np.all(np.diff(costs, axis=0) <= 0.0)


def test_the_cost_is_the_squared_residuals_and_the_price(setting):
    problem, windows, hypotheses = setting
    [found] = run(problem, random_starts(hypotheses[:1], 72), windows, 0, "cost")
    price = PRICE * sum(
        ((v - f.neutral) / f.spread) ** 2 for f, v in zip(found.hypothesis.free, found.vector, strict=True)
    )
    squares = np.sum(problem.residuals([found.member], windows).astype(float) ** 2)
    assert found.cost == pytest.approx(squares + price, rel=1e-4)


def test_the_best_of_several_starts_is_pursued(setting):
    problem, windows, hypotheses = setting
    near = hypotheses[1].start()
    near[-1] = 0.15
    far = hypotheses[1].start()
    far[-1] = hypotheses[1].free[-1].high
    [found] = run(problem, [(hypotheses[1], [far, near, far])], windows, 0, "starts")
    assert found.vector == pytest.approx(near)


def test_the_true_effect_is_fitted_to_its_value(setting):
    problem, windows, hypotheses = setting
    found = run(problem, [(h, spread(problem, h)) for h in hypotheses], windows, 8, "all")
    best = min(found, key=lambda f: f.cost)
    assert best.hypothesis.label == "coulomb_friction@shaft"
    assert found[0].cost > 4.0 * best.cost  # parameters alone
    there = problem.about(best.member)
    [again] = run(there, [(best.hypothesis, [best.vector])], windows, 8, "corrected at the fit")
    assert again.vector[-1] == pytest.approx(0.15, rel=0.1)


def test_what_a_stage_of_the_same_name_found_for_other_hypotheses_is_not_taken(setting):
    """A checkpoint may be of another version of the program, whose search went another way."""
    problem, windows, hypotheses = setting
    run(problem, random_starts(hypotheses[:2], 73), windows, 1, "one name")
    other = random_starts(hypotheses[2:3], 74)
    [found], [fresh] = (run(problem, other, windows, 1, stage) for stage in ("one name", "another name"))
    assert found.cost == fresh.cost and np.array_equal(found.vector, fresh.vector)


def test_a_first_look_moves_only_what_was_claimed_last(setting):
    problem, windows, hypotheses = setting
    tasks = [(h, spread(problem, h)) for h in hypotheses[1:]]
    looked = finished(fit(problem, tasks, windows, PRICE, stage="look", iterations=3, newest_only=True))
    for found in looked:
        free = found.hypothesis.free
        own = np.array([(f.effect, f.site) == found.hypothesis.places[-1] for f in free])
        np.testing.assert_array_equal(found.vector[~own], found.hypothesis.start()[~own])
    unmoved = run(problem, tasks, windows, 0, "unmoved")
    assert any(a.cost < 0.5 * b.cost for a, b in zip(looked, unmoved, strict=True))


def test_a_fit_that_was_stopped_goes_on_where_it_was(setting):
    problem, windows, hypotheses = setting
    tasks = random_starts(hypotheses[:2], 73)
    whole = run(problem, tasks, windows, 3, "whole")
    steps = fit(problem, tasks, windows, PRICE, stage="stopped", iterations=3)
    next(steps)
    next(steps)
    steps.close()
    resumed = run(problem, tasks, windows, 3, "stopped")
    assert [f.cost for f in resumed] == [f.cost for f in whole]
    assert all(np.array_equal(a.vector, b.vector) for a, b in zip(resumed, whole, strict=True))


def test_first_looks_at_walking_robots_leap_where_slopes_mean_nothing():
    hypothesis = Hypothesis(
        (("viscous_friction", "knee"),),
        (
            Free("armature", "knee", "I", 0, 0, -1.0, 1.0, 0.0, 0.03),
            Free("viscous_friction", "knee", "c", 0, 0, 0.0, 5.0, 0.0, np.inf),
        ),
    )
    flat = np.zeros((2, 3)), np.zeros((2, 3, 2))
    at, moving = Fit(hypothesis, np.array([0.01, 0.4]), 4.0), np.array([False, True])
    usual, leaping = (Walk(at, moving, *flat, 0.0, leaps=leaps) for leaps in (False, True))
    assert len(usual.candidates()) == len(DAMPINGS)
    tried = leaping.candidates()[len(DAMPINGS) :]
    np.testing.assert_allclose(tried, [[0.01, 0.16], [0.01, 1.0]])
    residuals = np.ones((len(DAMPINGS) + 2, 2, 3))
    residuals[-1] = 0.1
    leaping.step_to(leaping.candidates(), residuals)
    assert leaping.at.vector == pytest.approx([0.01, 1.0])


def test_windows_in_which_robots_part_neither_rule_slopes_nor_costs():
    residuals = np.full((3, 5, 4), 0.5)
    residuals[1, 2] = 50.0
    residuals[2] = 5.0
    plain, robust = data_costs(residuals, False), data_costs(residuals, True)
    assert plain == pytest.approx([5.0, 4.0 + 1e4, 500.0])
    assert robust == pytest.approx([5.0, 4.0 + 4.0, 500.0]), "what is off everywhere counts in full"
    hypothesis = Hypothesis((), (Free("armature", "knee", "I", 0, 0, -1.0, 1.0, 0.0, 0.1),))
    derivative = np.ones((5, 4, 1))
    derivative[2] = -30.0
    at = Fit(hypothesis, np.zeros(1), 1.0)
    weights = heeded(at, derivative)
    assert weights == pytest.approx([1.0, 1.0, 0.1, 1.0, 1.0])
    np.testing.assert_array_equal(heeded(at, 0.0 * derivative), 1.0)
    residual = np.ones((5, 4))
    ruled, free = (Walk(at, np.array([True]), residual, derivative, 1e-9, weights=w) for w in (None, weights))
    first = [walk.candidates()[0][0] for walk in (ruled, free)]
    assert first[0] > 0.0 > first[1], "four windows of five say less"


def test_what_no_motion_tells_is_left_as_the_model_has_it():
    """All masses, motors and frictions by one factor: a heavier link was told as half as much heavier beside it."""
    robot = nominal("two")
    parameters = parameters_only(robot, catalogue(["viscous_friction", "motor_weakness", "body_mass"]))
    claims = ("body_mass", "lower"), ("coulomb_friction", "elbow"), ("sensor_delay", "lower_angle")
    hypothesis = claiming(robot, parameters, claims)
    true = {"body_mass": 0.2, "coulomb_friction": 0.1, "sensor_delay": 0.01}
    vector = np.array([true[f.effect] if np.isinf(f.spread) else 0.0 for f in hypothesis.free])
    sign = np.array([-1.0 if f.loss else 1.0 for f in hypothesis.free])
    present = np.array([f.present for f in hypothesis.free])
    factors = np.array([1.0 if f.effect == "sensor_delay" else 0.85 for f in hypothesis.free])
    scaled = sign * (factors * (present + sign * vector) - present)
    [back] = rescaled(Fit(hypothesis, scaled, 1.0))
    assert back == pytest.approx(vector, abs=1e-12) and not np.allclose(scaled, vector, atol=1e-3)
    assert rescaled(Fit(hypothesis, vector, 1.0)) == [], "nothing is nearer"
    free = [f for f in hypothesis.free if f.effect == "sensor_delay"]
    assert rescaled(Fit(Hypothesis((claims[2],), tuple(free)), np.array([0.01]), 1.0)) == [], "no scale at all"


def test_a_parameter_that_changes_nothing_stays_where_it_is():
    axes = [Free("external_force", "cart", a, 0, i, -14.0, 14.0, 0.0, np.inf) for i, a in enumerate("xz")]
    rng = np.random.default_rng(74)
    for rounding in (0.0, 1e-9):
        derivative = rng.standard_normal((5, 40, 2)) * [1.0, rounding]
        residual = derivative @ [0.5, 0.0] + 0.01 * rng.standard_normal((5, 40))
        at = Fit(Hypothesis((), tuple(axes)), np.array([0.1, 2.0]), float(np.sum(residual**2)))
        found = np.array(Walk(at, np.array([True, True]), residual, derivative, 0.0).candidates())
        assert found[0, 0] == pytest.approx(-0.4, abs=0.01)
        assert (found[:, 1] == 2.0).all()
