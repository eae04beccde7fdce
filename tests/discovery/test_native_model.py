"""The file of an explanation holds values as they were found, and says how far it is off when MuJoCo alone steps it."""

import numpy as np
import pytest

from estexp_jax.discovery.diagnosis import Case, NativeModel
from estexp_jax.discovery.native_model import Stepped, native_model, stepped_model
from estexp_jax.discovery.problem import Problem
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.engines.c.plain_replay import PlainReplay
from estexp_jax.physics.engines.mjx.native import mjx_refusal
from estexp_jax.physics.model.robot import Robot
from tests.discovery.planted import Plant, case_of, problem_of
from tests.physics.exported import motion, ours, robot_of

DELAY = Change("command_delay", "servo", {"delay": 0.04})
DEAF = Change("dead_band", "servo", {"half_width": 0.05})
HEAVIER = Change("body_mass", "arm", {"dm": 0.1})


@pytest.fixture(scope="module")
def late():
    case = case_of("one", Plant(delay=0.04), 7)
    return case, problem_of(case)


def _model(late: tuple[Case, Problem], claimed, others=(), refitted=(), finer=4, fine_only=False) -> NativeModel:
    return native_model(late[0], late[1], claimed, others, refitted, finer=finer, fine_only=fine_only, seed=0)


def test_the_file_of_a_late_command_predicts_what_the_findings_do(late):
    model, nothing = _model(late, [DELAY]), _model(late, [])
    assert model.changes == (DELAY,) and model.left_out == () and model.finer == 1
    assert model.errors["test"] < 0.15 * nothing.errors["test"]


def test_a_file_for_mjx_has_none_of_what_that_ignores(late):
    model = native_model(
        late[0], late[1], [DELAY, HEAVIER], [], [], finer=1, fine_only=False, seed=0, refusal=mjx_refusal
    )
    assert model.changes == (HEAVIER,) and [why for _, why in model.left_out] == ["MJX ignores delays"]


def test_values_that_were_fitted_beside_stay_unless_that_costs(late):
    assert _model(late, [DELAY], [Change("body_mass", "arm", {"dm": 1e-4})]).changes == (DELAY,)
    wrong = _model(late, [DELAY], [HEAVIER])
    assert wrong.changes == (DELAY,)


def test_what_mjcf_cannot_hold_is_left_out_and_the_rest_keeps_its_values(late):
    model = _model(late, [DELAY, DEAF], refitted=[HEAVIER])
    assert model.changes == (DELAY,) and model.stand_in is None
    [(change, why)] = model.left_out
    assert change == DEAF and "no element" in why


def test_a_stand_in_that_predicts_plainly_better_is_another_file(late):
    model = _model(late, [DEAF], refitted=[DELAY])
    assert model.changes == () or model.stand_in == (DELAY,)


def test_what_blows_up_is_as_bad_as_can_be_told(late):
    stepped = Stepped(*late)
    windows = stepped.some_of("train")[:2]
    light = stepped.costs([Change("body_mass", "arm", {"dm": -0.4999999})], 1, windows)
    assert np.isfinite(light).all() and (light > stepped.costs([DELAY], 1, windows)).all()


def test_a_step_that_is_wrong_is_the_files(late):
    assert _model(late, [DELAY], fine_only=True).finer == 4


@pytest.mark.parametrize("delay", [0.03, 0.0213])
def test_delays_are_exact_where_steps_are_cut_to_end_on_rows(delay: float):
    spec = robot_of("servos").spec.copy()
    spec.option.timestep = 0.003
    robot = Robot.from_spec(spec)
    window, change = motion(robot, 0.6), Change("command_delay", "lift", {"delay": delay})
    model = stepped_model(robot, [change], [window])
    assert model.opt.timestep == pytest.approx(0.02 / 7)
    alone = PlainReplay(robot, model).replay([window])
    np.testing.assert_allclose(alone.sensors, ours(robot, [change], window).sensors, atol=1e-6)
