"""What is wrong with a log is told by what the nominal model says of it, whatever physics that lacks."""

import numpy as np
import pytest

from estexp_jax.estimation.log_faults import found_faults, untold_joints
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot
from tests.estimation.rubbing_servo import rubbing_log, servo
from tests.estimation.two_links import XML, arm, faulty, log_of

READINGS, COMMANDS = "channels_exchanged@q_shoulder with=q_elbow", "channels_exchanged@m_shoulder with=m_elbow"
REAL = {
    "as modelled": {},
    "with friction": {"friction": 0.1},
    "heavier": {"mass": 0.55},
    "damped": {"damping": 0.45},
}


EACH = [pytest.param(name, marks=[pytest.mark.slow] if name in ("heavier", "damped") else []) for name in REAL]


def told(recording, motor="position"):
    return {f.change.place: f.change.parameters for f in found_faults(arm(motor), recording)[0]}


@pytest.mark.parametrize("motor", ["position", "motor"])
@pytest.mark.parametrize("real", EACH)
def test_physics_that_the_model_lacks_is_no_fault_of_the_log(motor, real):
    assert told(log_of(arm(motor, **REAL[real])), motor) == {}


@pytest.mark.parametrize("motor", ["position", "motor"])
@pytest.mark.parametrize("real", EACH)
@pytest.mark.parametrize("faults", [(READINGS,), (COMMANDS,), (READINGS, COMMANDS)], ids=["read", "commanded", "both"])
def test_exchanged_channels_are_told_from_each_other(motor, real, faults):
    robot = arm(motor)
    wanted = {change.place: change.parameters for change in (parse_change(text, robot) for text in faults)}
    assert told(faulty(robot, log_of(arm(motor, **REAL[real])), *faults), motor) == wanted


@pytest.mark.parametrize("real", EACH)
@pytest.mark.parametrize("fault", ["command_lead lead=0.025", "clock_scale@* factor=1.006"])
def test_displaced_commands_and_two_clocks_are_told_with_their_size(real, fault):
    robot = arm()
    change = parse_change(fault, robot)
    found = told(faulty(robot, log_of(arm(**REAL[real]), length=12.0), fault))
    [name] = change.parameters
    assert list(found) == [change.place]
    tolerance = 0.004 if name == "lead" else 0.001
    assert found[change.place][name] == pytest.approx(change.parameters[name], abs=tolerance)


@pytest.mark.parametrize("seed", [9, pytest.param(12, marks=pytest.mark.slow)])
def test_an_early_clock_is_told_behind_dry_friction_that_hides_it(seed):
    rubbing = rubbing_log(seed, friction=0.45)
    assert found_faults(servo(), rubbing)[0] == ()
    [found] = found_faults(servo(), faulty(servo(), rubbing, "command_lead lead=0.02"))[0]
    assert found.change.parameters == {"lead": pytest.approx(0.02, abs=0.004)}


def test_dry_friction_is_no_late_command():
    assert found_faults(servo(), rubbing_log(3, seconds=5.6))[0] == ()


@pytest.mark.parametrize("factor", [0.9, 1.1])
@pytest.mark.parametrize("motor", ["position", "motor"])
def test_a_clock_that_runs_fast_is_told_where_nothing_else_is_wrong(motor, factor):
    robot = arm(motor)
    found = told(faulty(robot, log_of(robot), f"clock_scale factor={factor}"), motor)
    assert found == {"clock_scale": {"factor": pytest.approx(factor, abs=0.03)}}


def test_a_log_is_given_back_without_what_is_undone():
    robot, right = arm(), log_of(arm())
    found, mended = found_faults(robot, faulty(robot, right, READINGS))
    assert len(found) == 1 and found[0].probability > 0.99
    np.testing.assert_array_equal(mended.sensor, right.sensor)
    late = faulty(robot, right, "command_lead lead=-0.03")
    found, mended = found_faults(robot, late)
    assert [f.change.effect for f in found] == ["command_lead"] and mended is late  # a delay, perhaps


def test_only_what_is_asked_for_is_looked_for():
    recording = faulty(arm(), log_of(arm()), READINGS)
    assert found_faults(arm(), recording, {"no_signal"}) == ((), recording)


def test_joints_that_nothing_tells_apart_are_named():
    side_by_side = XML.replace('<body pos=".25 0 0"><joint name="elbow"/><geom/></body></body>', "</body>").replace(
        "</worldbody>", '<body pos="0 1 1"><joint name="elbow"/><geom/></body></worldbody>'
    )
    gain = 'kp="20" kv=".5"'
    twins = Robot.from_string(side_by_side.format(motor="position", gain=gain, friction=0, mass=0.4, damping=0.2))
    assert untold_joints(twins, log_of(twins)) == [("q_shoulder", "m_shoulder")]
    assert untold_joints(arm(), log_of(arm())) == []


def test_what_cannot_be_replayed_has_no_fault_that_replays_show():
    silent = faulty(arm(), log_of(arm()), READINGS)
    silent.sensor[:, 0] = np.nan
    assert found_faults(arm(), silent)[0] == () and untold_joints(arm(), silent) == []
