"""What is remembered from before a window, commands that go elsewhere, and readings that are late, stuck or drift."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from estexp_jax.physics.effects.changes import encode, parse_change, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopRollout, OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, StateEstimate, Window, window_of
from tests.physics.effects.twins import XML

ROBOT = Robot.from_string(XML, "twin.xml")
EFFECTS = catalogue(
    ["hysteresis", "motor_fade", "joint_compliance", "backlash", "actuator_lag", "tied_outputs"]
    + ["sensor_delay", "sensor_stuck", "law_drift"]
)
PERIOD, ROWS, MIDDLE = 0.005, 160, 100


@cache
def simulator(engine: str) -> OpenLoopSimulator:
    return open_loop_simulator(ROBOT, EFFECTS, [ROBOT], width=4, block=200, engine=engine)


def log(ctrl: np.ndarray | None = None) -> Recording:
    commands = np.repeat(np.random.default_rng(67).uniform(-0.8, 0.8, (10, 2)), ROWS // 10, axis=0)
    nothing = np.full((ROWS, 2), np.nan)
    ctrl = commands if ctrl is None else ctrl
    return Recording("log.csv", PERIOD * np.arange(ROWS), ctrl, np.ones((ROWS, 2)), nothing, nothing, nothing)


def part(first: int = 0, start: InitialState | None = None, recording: Recording | None = None) -> Window:
    start = InitialState(np.zeros(2), np.zeros(2)) if start is None else start
    return window_of([recording or log()], 0, (first, ROWS - 1), 0.0025, start)


NOW = {"engine": "lanes"}


@pytest.fixture(autouse=True, params=("lanes", "c"))
def engine(request: pytest.FixtureRequest) -> str:
    """Every test is run with each engine."""
    NOW["engine"] = request.param
    return request.param


def run(text: str, segment: Window) -> OpenLoopRollout:
    changes = [parse_change(t, ROBOT) for t in text.split(" + ")] if text else []
    return simulator(NOW["engine"]).replay(stack([encode(ROBOT, EFFECTS, changes)]), [segment], np.zeros(1, int))


@pytest.mark.parametrize(
    ("text", "share"),
    [
        ("hysteresis@elbow T=0.2 sigma=3", 0.1),
        ("motor_fade@servo loss=0.9 tau=0.3", 0.1),
        ("actuator_lag@servo tau=0.1", 0.05),
        ("joint_compliance@shoulder k=30 d=0.1 I=0.006", 0.3),
        ("backlash@shoulder half_gap=0.05", 0.3),
    ],
)
def test_what_happened_before_a_window_is_remembered(text: str, share: float) -> None:
    """A window goes on as the whole recording does, because hidden variables are rolled along it.

    Springs and gaps are rolled at the rows' times, between which the joint is taken to move evenly.
    """
    whole = run(text, part())
    path = StateEstimate(log().time, whole.qpos[0].astype(float), whole.qvel[0].astype(float))
    late = part(MIDDLE, InitialState(path.qpos[MIDDLE], path.qvel[MIDDLE]))
    wanted = whole.qpos[0, MIDDLE:]
    forgetful = np.abs(run(text, late).qpos[0] - wanted).max()
    remembering = np.abs(run(text, replace(late, path=path)).qpos[0] - wanted).max()
    assert forgetful > 4e-3, "there is something to remember"
    assert remembering < share * forgetful + 1e-4


def test_a_tied_motor_gets_the_others_command() -> None:
    tied = run("tied_outputs@push with=servo", part())
    by_hand = run("", part(recording=log(log().ctrl[:, [0, 0]])))
    np.testing.assert_array_equal(tied.qpos, by_hand.qpos)
    assert np.abs(tied.qpos - run("", part()).qpos).max() > 0.1


def test_a_late_sensor_shows_what_was() -> None:
    true, late = run("", part()), run("sensor_delay@bend delay=0.02", part())
    np.testing.assert_array_equal(late.qpos, true.qpos)
    np.testing.assert_array_equal(late.sensors[..., 0], true.sensors[..., 0])
    np.testing.assert_allclose(late.sensors[0, 4:, 1], true.sensors[0, :-4, 1], atol=1e-6)


def test_a_window_under_a_late_sensor_starts_where_the_robot_was() -> None:
    true = run("", part())
    read = true.qpos[0].astype(float).copy()
    read[4:, 1] = true.qpos[0, :-4, 1]
    speed = true.qvel[0].astype(float).copy()
    speed[4:, 1] = true.qvel[0, :-4, 1]
    late = part(MIDDLE, InitialState(read[MIDDLE], speed[MIDDLE], ((1, 1, 1),)))
    replay = run("sensor_delay@bend delay=0.02", replace(late, path=StateEstimate(log().time, read, speed)))
    np.testing.assert_allclose(replay.qpos[0], true.qpos[0, MIDDLE:], atol=1e-3)
    np.testing.assert_allclose(replay.sensors[0, :, 1], read[MIDDLE:, 1], atol=1e-3)


def test_a_drifting_sensor_gains_from_the_recordings_beginning_on() -> None:
    log_ = replace(log(), time=log().time + 7.0)
    true, drifts = run("", part(recording=log_)), run("law_drift@bend a=0.3", part(recording=log_))
    np.testing.assert_array_equal(drifts.qpos, true.qpos)
    np.testing.assert_array_equal(drifts.sensors[..., 0], true.sensors[..., 0])
    gained = drifts.sensors[0, :, 1] - true.sensors[0, :, 1]
    np.testing.assert_allclose(gained, 0.3 * (log_.time - 7.0), atol=1e-6)


def test_a_window_under_a_drifting_sensor_starts_where_the_robot_was() -> None:
    true, gained = run("", part()), 0.3 * log().time
    read, speed = true.qpos[0].astype(float), true.qvel[0].astype(float)
    read[:, 1] += gained
    speed[:, 1] += 0.3
    replay = run("law_drift@bend a=0.3", part(MIDDLE, InitialState(read[MIDDLE], speed[MIDDLE], ((1, 1, 1),))))
    np.testing.assert_allclose(replay.qpos[0], true.qpos[0, MIDDLE:], atol=1e-3)
    np.testing.assert_allclose(replay.sensors[0, :, 1], read[MIDDLE:, 1], atol=1e-3)


def test_another_start_stays_another_start_under_a_late_sensor() -> None:
    read = np.cumsum(np.full((ROWS, 2), 0.002), axis=0)
    path = StateEstimate(log().time, read, np.zeros((ROWS, 2)))
    starts = []
    for shift in (0.0, 0.05):
        begin = InitialState(read[MIDDLE] + [0.0, shift], np.array([0.0, 2.0 * shift]), ((1, 1, 1),))
        replay = run("sensor_delay@bend delay=0.02", replace(part(MIDDLE, begin), path=path))
        starts.append(np.array([replay.qpos[0, 0], replay.qvel[0, 0]]))
    np.testing.assert_allclose(starts[1] - starts[0], [[0.0, 0.05], [0.0, 0.1]], atol=1e-6)


def test_under_a_stuck_sensor_a_servo_starts_where_it_was_told_to_be() -> None:
    told = np.stack([0.3 + 0.8 * PERIOD * np.arange(ROWS), np.zeros(ROWS)], axis=1)
    start = InitialState(np.array([0.1, 0.7]), np.zeros(2), ((0, 0, 0), (1, 1, 1)))
    replay = run("sensor_stuck@angle value=0.7", part(MIDDLE, start, log(told)))
    servo = ROBOT.model.actuator_gainprm[0, 0] / -ROBOT.model.actuator_biasprm[0, 1]
    late = 0.8 * 0.02  # half of the time over which commands count
    assert replay.qpos[0, 0, 0] == pytest.approx(servo * (told[MIDDLE, 0] - late), abs=0.005)
    assert replay.qvel[0, 0, 0] == pytest.approx(servo * 0.8, rel=0.05)


def test_a_stuck_sensor_starts_at_home_and_stays() -> None:
    start = InitialState(np.array([0.1, 0.7]), np.zeros(2), ((0, 0, 0), (1, 1, 1)))
    replay = run("sensor_stuck@bend value=0.7", part(start=start))
    np.testing.assert_allclose(replay.sensors[0, :, 1], 0.7)
    np.testing.assert_allclose(replay.qpos[0, 0], [0.1, 0.0], atol=1e-6)
