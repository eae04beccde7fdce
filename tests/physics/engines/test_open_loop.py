"""Replays agree with a plain loop over the C engine that takes the same steps."""

from functools import cache

import jax
import mujoco
import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change, Values, encode, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopRollout, OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, Window, window_of
from estexp_jax.recordings.settings import apply_settings
from estexp_jax.runs import count_compilations
from tests.physics.reference import converged

EFFECTS = catalogue(["viscous_friction", "command_delay", "sensor_bias"])

# Two links, a servo and a motor; readings of all three stages, of forces with one and with three values.
XML = """
<mujoco model="links">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.005" integrator="{integrator}"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" damping="0.05" armature="0.002"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.02" mass="0.6" contype="0" conaffinity="0"/>
      <body name="hand" pos="0 0 -0.25">
        <joint name="elbow" axis="0 1 0" damping="0.01" stiffness="0.2" frictionloss="0.02"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02" mass="0.2" contype="0" conaffinity="0"/>
        <site name="tip" pos="0 0 -0.2"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="servo" joint="shoulder" kp="6" kv="0.1"/>
    <motor name="push" joint="elbow" gear="0.5" ctrlrange="-1 1"/>
  </actuator>
  <sensor>
    <actuatorfrc name="effort" actuator="push"/>
    <jointpos name="angle" joint="shoulder"/>
    <accelerometer name="acc" site="tip"/>
    <jointvel name="speed" joint="elbow"/>
  </sensor>
</mujoco>
"""
EFFORT, ANGLE, ACC, SPEED = 0, 1, slice(2, 5), 5
SETTINGS = ({}, {"actuator.servo.kp": 3.0}, {"body.hand.mass": 0.35, "option.gravity": (0.0, 0.0, -5.0)})


@cache
def robots(integrator: str) -> tuple[Robot, ...]:
    """The robot of each of three recordings, the first as in the MJCF."""
    nominal = Robot.from_string(XML.format(integrator=integrator), "links.xml")
    return tuple(apply_settings(nominal, settings) for settings in SETTINGS)


NOW = {"engine": "mjx"}


@pytest.fixture(autouse=True, params=["mjx", "lanes", "c"])
def engine(request: pytest.FixtureRequest) -> str:
    """Every test is run with each engine."""
    NOW["engine"] = request.param
    return request.param


def subject(integrator: str = "Euler") -> OpenLoopSimulator:
    return _subject(integrator, NOW["engine"])


@cache
def _subject(integrator: str, engine: str) -> OpenLoopSimulator:
    each = robots(integrator)
    return open_loop_simulator(each[0], EFFECTS, each, width=6, block=64, engine=engine)


def recording(index: int, rows: int = 80) -> Recording:
    """An uneven clock, random held commands, the push motor off for a while."""
    rng = np.random.default_rng(60 + index)
    time = 2.0 + np.cumsum(rng.uniform(0.003, 0.017, rows))
    ctrl = np.repeat(rng.uniform(-1.2, 1.2, (rows // 8 + 1, 2)), 8, axis=0)[:rows]
    enable = np.ones((rows, 2))
    enable[rows // 3 : rows // 2, 1] = 0.0
    readings = np.full((rows, 6), np.nan)
    return Recording(
        f"{index}.csv", time, ctrl, enable, readings, np.full((rows, 2), np.nan), np.full((rows, 2), np.nan)
    )


RECORDINGS = [recording(k) for k in range(3)]
START = InitialState(np.array([0.4, -0.3]), np.array([0.5, 1.0]))


def whole(index: int) -> Window:
    return window_of(RECORDINGS, index, (0, 79), 0.005, START)


def c_loop(
    robot: Robot, part: Window, delay: float = 0.0, start: InitialState = START
) -> tuple[np.ndarray, np.ndarray]:
    """Readings and configurations at the rows of a segment; force sensors as under the command before."""
    model = converged(robot.spec.copy().compile())
    data, gain, bias = mujoco.MjData(model), model.actuator_gainprm.copy(), model.actuator_biasprm.copy()
    data.qpos[:], data.qvel[:] = start.qpos, start.qvel
    log, steps = RECORDINGS[part.recording], part.steps
    forces = model.sensor_needstage == mujoco.mjtStage.mjSTAGE_ACC
    forces = np.repeat(forces, model.sensor_dim)
    readings, configurations = [], []
    for k in range(steps.n_steps + 1):
        now = min(k, steps.n_steps - 1)
        row = part.first + steps.row[now]
        model.opt.timestep = steps.length[now]
        moments = steps.start[now] - delay + steps.length[now] * (np.arange(400) + 0.5) / 400
        data.ctrl[:] = log.ctrl[np.maximum(np.searchsorted(log.time, moments, side="right") - 1, 0)].mean(axis=0)
        on, command = log.enable[row][:, None], data.ctrl.copy()
        if k in steps.sample:
            just_before = np.append(steps.start, steps.end)[k] - delay - 1e-6
            data.ctrl[:] = log.ctrl[max(np.searchsorted(log.time, just_before, side="right") - 1, 0)]
            mujoco.mj_forward(model, data)
            data.ctrl[:] = command
        before, place = data.sensordata.copy(), data.qpos.copy()
        model.actuator_gainprm[:], model.actuator_biasprm[:] = gain * on, bias * on
        mujoco.mj_step(model, data)
        if k in steps.sample:
            readings.append(np.where(forces, before, data.sensordata))
            configurations.append(place)
    return np.array(readings), np.array(configurations)


def values(*changes: Change) -> Values:
    return encode(robots("Euler")[0], EFFECTS, changes)


def run(lanes: list[Values], segments: list[Window], which: list[int], integrator: str = "Euler") -> OpenLoopRollout:
    return subject(integrator).replay(stack(lanes), segments, np.array(which))


def assert_agree(replay: OpenLoopRollout, lane: int, reference: tuple[np.ndarray, np.ndarray]) -> None:
    sensors, qpos = reference
    assert replay.qpos[lane] == pytest.approx(qpos, abs=2e-4)
    assert replay.sensors[lane][:, [ANGLE, EFFORT]] == pytest.approx(sensors[:, [ANGLE, EFFORT]], abs=3e-4)
    assert replay.sensors[lane][:, SPEED] == pytest.approx(sensors[:, SPEED], abs=5e-3)
    assert replay.sensors[lane][:, ACC] == pytest.approx(sensors[:, ACC], abs=2e-2 * np.abs(sensors[:, ACC]).max())


INTEGRATORS = (
    "Euler",
    pytest.param("implicitfast", marks=pytest.mark.slow),
    pytest.param("RK4", marks=pytest.mark.slow),
)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_an_uneven_clock_a_motor_that_is_off_and_settings_of_each_recording(integrator):
    replay = run([values()] * 3, [whole(k) for k in range(3)], [0, 1, 2], integrator)
    for lane, robot in enumerate(robots(integrator)):
        assert_agree(replay, lane, c_loop(robot, whole(lane)))
    apart = np.abs(replay.qpos[0] - c_loop(robots(integrator)[1], whole(0))[1]).max()
    assert apart > 0.05  # or the settings would not show


def test_the_motor_that_is_off_gives_no_force():
    [effort] = run([values()], [whole(0)], [0]).sensors[:, :, EFFORT]
    off = RECORDINGS[0].enable[:, 1] == 0.0
    assert np.all(effort[1:][off[:-1]] == 0.0) and np.all(effort[1:][~off[:-1]] != 0.0)


def test_a_force_sensor_shows_the_command_before():
    [effort] = run([values()], [whole(0)], [0]).sensors[:, :, EFFORT]
    command = np.clip(RECORDINGS[0].ctrl[:, 1], -1.0, 1.0) * RECORDINGS[0].enable[:, 1]
    assert effort[1:] == pytest.approx(command[:-1], abs=1e-6)


def test_a_delay_of_whole_steps_is_a_late_command():
    late = [Change("command_delay", name, {"delay": 0.02}) for name in ("servo", "push")]
    log = RECORDINGS[0]
    even = Recording("even.csv", np.arange(80) * 0.01, log.ctrl, np.ones((80, 2)), log.sensor, log.qpos, log.qvel)
    part = window_of([even], 0, (0, 79), 0.005, START)
    replay = run([values(), values(*late)], [part], [0, 0])
    shifted = np.concatenate([np.repeat(even.ctrl[:1], 2, axis=0), even.ctrl[:-2]])
    by_hand = Recording("late.csv", even.time, shifted, even.enable, even.sensor, even.qpos, even.qvel)
    other = run([values()], [window_of([by_hand], 0, (0, 79), 0.005, START)], [0])
    assert replay.qpos[1] == pytest.approx(other.qpos[0], abs=5e-5)  # the means of commands are rounded
    assert np.abs(replay.qpos[1] - replay.qpos[0]).max() > 0.05


def test_a_delay_reaches_back_before_a_window():
    late = [Change("command_delay", name, {"delay": 0.05}) for name in ("servo", "push")]
    part = window_of(RECORDINGS, 0, (30, 79), 0.005, START)
    replay = run([values(*late)], [part], [0])
    reference = c_loop(robots("Euler")[0], part, delay=0.05)
    assert replay.qpos[0] == pytest.approx(reference[1], abs=2e-3)
    assert np.abs(replay.qpos[0, :, 0] - c_loop(robots("Euler")[0], part)[1][:, 0]).max() > 0.1


def test_a_biased_encoder_starts_elsewhere_and_reads_the_same():
    sensed = InitialState(START.qpos, START.qvel, ((ANGLE, 0, 0),))
    part = window_of(RECORDINGS, 0, (0, 79), 0.005, sensed)
    replay = run([values(Change("sensor_bias", "angle", {"bias": 0.25}))], [part], [0])
    true = InitialState(START.qpos - [0.25, 0.0], START.qvel)
    sensors, qpos = c_loop(robots("Euler")[0], whole(0), start=true)
    assert replay.qpos[0] == pytest.approx(qpos, abs=2e-4)
    assert replay.sensors[0, :, ANGLE] == pytest.approx(sensors[:, ANGLE] + 0.25, abs=3e-4)


def test_lanes_do_not_depend_on_their_company():
    segments = [whole(0), whole(1), window_of(RECORDINGS, 2, (10, 25), 0.005, START)]
    lanes = [values(Change("viscous_friction", "elbow", {"c": 0.01 * k})) for k in range(8)]
    which = [0, 1, 2, 0, 1, 2, 0, 2]
    together = run(lanes, segments, which)
    order = np.random.default_rng(63).permutation(8)
    mixed = run([lanes[i] for i in order], segments, [which[i] for i in order])
    assert np.array_equal(mixed.sensors, together.sensors[order], equal_nan=True)
    alone = run([lanes[5]], segments, [2])
    assert np.array_equal(alone.qpos[0], together.qpos[5, : alone.qpos.shape[1]], equal_nan=True)


def test_beyond_a_segments_end_there_is_nothing():
    replay = run([values()] * 2, [whole(0), window_of(RECORDINGS, 1, (5, 14), 0.005, START)], [0, 1])
    for table in replay:
        assert np.isfinite(table[0]).all()
        assert np.isfinite(table[1, :10]).all() and np.isnan(table[1, 10:]).all()


def test_a_simulation_that_blows_up_leaves_its_neighbours_alone():
    broken = window_of(RECORDINGS, 0, (0, 79), 0.005, InitialState(np.array([np.nan, 0.0]), np.zeros(2)))
    replay = run([values()] * 2, [whole(0), broken], [0, 1])
    assert np.isnan(replay.qpos[1]).any()
    assert np.array_equal(replay.qpos[0], run([values()], [whole(0)], [0]).qpos[0])


def test_one_executable_serves_all():
    run([values(Change("viscous_friction", "elbow", {"c": 0.5}))], [whole(0)], [0])
    with count_compilations() as compiled:
        run([values(Change("viscous_friction", "elbow", {"c": 1.0}))] * 9, [whole(k) for k in range(3)], [0, 1, 2] * 3)
        run([values()], [window_of(RECORDINGS, 0, (3, 9), 0.001, START)], [0])
    assert compiled.count == 0


def test_a_kept_program_is_another_robots_or_the_same(tmp_path, engine):
    """Programs on disk: those of the same robot are found by another simulator; none is taken for another robot's."""
    if engine != "lanes":
        pytest.skip("only lanes keep programs")
    before = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue] (made at run time)
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    try:
        found = []
        for mass in ("0.2", "0.2", "0.3"):
            robot = Robot.from_string(XML.format(integrator="Euler").replace('mass="0.2"', f'mass="{mass}"'))
            simulator = open_loop_simulator(robot, EFFECTS, [robot] * 3, width=6, block=64, engine=engine)
            replay = simulator.replay(stack([values()]), [whole(0)], np.array([0]))
            found.append((replay.qpos, {p.name for p in (tmp_path / "steps").glob("*.program")}))
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
    first, same, heavier = found
    assert first[1] == same[1] < heavier[1]
    assert np.array_equal(first[0], same[0])
    assert not np.array_equal(first[0], heavier[0])
    assert found[0][0][0] == pytest.approx(c_loop(robots("Euler")[0], whole(0))[1], abs=2e-4)


def test_settings_that_change_the_models_structure_are_refused():
    nominal = robots("Euler")[0]
    other = Robot.from_string(
        XML.format(integrator="Euler").replace("<motor", "<motor name='more' joint='elbow'/><motor")
    )
    with pytest.raises(InputError, match="settings change"):
        open_loop_simulator(nominal, EFFECTS, [nominal, other])
