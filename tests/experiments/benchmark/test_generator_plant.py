"""The generator's plant: its equations are MuJoCo's, every effect acts, and none does what it must not."""

from functools import cache

import mujoco
import numpy as np
import pytest

from experiments.benchmark.generator.case import Planted
from experiments.benchmark.generator.catalogue import CATALOGUE, parameters, places
from experiments.benchmark.generator.effect import Moment, Queue, bristle
from experiments.benchmark.generator.equations import by_hand
from experiments.benchmark.generator.excitation import controller, motion
from experiments.benchmark.generator.joints import Gap, Swirl
from experiments.benchmark.generator.making import build
from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.plant import Plant, clock
from experiments.benchmark.generator.robots import ROBOTS, layout
from experiments.benchmark.generator.scales import scales


@pytest.mark.parametrize("robot", ["planar", "cartpole"])
def test_the_equations_by_hand_are_mujocos(robot):
    model, rng = ROBOTS[robot].model, np.random.default_rng(0)
    model.body_ipos[1:] += 0.02 * rng.standard_normal((2, 3)) * [1.0, 0.0, 1.0]
    model.opt.gravity[:] = [1.0, 0.0, -9.0]
    mujoco.mj_setConst(model, mujoco.MjData(model))
    data = mujoco.MjData(model)
    for _ in range(5):
        data.qpos[:], data.qvel[:], force = rng.standard_normal(2), rng.standard_normal(2), rng.standard_normal(2)
        data.qfrc_applied[:] = force
        mujoco.mj_forward(model, data)
        mine = by_hand(model, robot).acceleration(data.qpos.tolist(), data.qvel.tolist(), force.tolist())
        np.testing.assert_allclose(mine, data.qacc, rtol=1e-9)


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_effect_changes_how_its_robot_moves_and_breaks_nothing(name):
    kind = CATALOGUE[name]
    robot = next(r for r in ("planar", "leg", "quadruped") if places(name, r))
    if kind.kind == "sensor" or name == "time_step":
        pytest.skip("changes what is read")
    found = [_moved(robot, planted) for planted in ((), (Planted(name, places(name, robot)[0], 0.6),))]
    assert np.isfinite(found[1]).all()
    assert np.abs(found[0] - found[1]).max() > 1e-4


@cache
def _moved(name, planted):
    robot, rng = ROBOTS[name], np.random.default_rng(3)
    motors = Motors.of(robot.model, layout(name))
    effects = [build(p, name, motors, np.random.default_rng(4)) for p in planted]
    plant = Plant(robot, robot.model, motors, effects)
    moved = motion("gait" if name == "quadruped" else "sines", np.array(robot.reach), 0.8, rng)
    rows = clock(0.8, 100.0, 0.0, plant.step, rng)
    return plant.run(controller(robot, motors, moved, "feedback", 0.9, rng), rows, None, 0.3)[0].q


def test_an_effect_may_begin_half_way():
    robot, rng = ROBOTS["planar"], np.random.default_rng(3)
    motors, traces = Motors.of(robot.model, layout("planar")), []
    for start in (0.5, 9.0):
        effect = build(Planted("body_mass", 1, 0.5), "planar", motors, rng)
        effect.start = start
        plant, ask = Plant(robot, robot.model, motors, [effect]), lambda t, q, w: [np.sin(5 * t), 0.1]
        traces.append(plant.run(ask, np.arange(100) * 0.01, None, 0.1)[0])
    same = np.abs(traces[0].q - traces[1].q).max(axis=1)
    assert same[traces[0].time < 0.5].max() == 0.0 and same[-1] > 1e-3


def test_a_motor_that_is_off_cools():
    robot, rng = ROBOTS["planar"], np.random.default_rng(3)
    motors = Motors.of(robot.model, layout("planar"))
    fade = build(Planted("motor_fade", 1, 0.6), "planar", motors, rng)
    plant, heats = Plant(robot, robot.model, motors, [fade]), []

    def ask(t, q, w):
        heats.append((t, fade.heat))
        return [0.3, 0.3]

    plant.run(ask, np.arange(100) * 0.01, (0.5, 2.0), 0.1)
    time, heat = np.array(heats).T
    cooling = time > 0.52
    np.testing.assert_allclose(
        heat[cooling], heat[cooling][0] * np.exp(-(time[cooling] - time[cooling][0]) / fade.tau), rtol=1e-3
    )
    assert heat[time < 0.5].max() > 0.0 and np.all(np.diff(heat[(time > 0.0) & (time < 0.5)]) > 0.0)


def test_a_bristle_slides_at_its_level_and_a_queue_waits():
    force = 0.0
    for _ in range(100):
        force = bristle(force, -0.3, 2.0, 1e3, 1e-3)
    assert force == pytest.approx(-2.0)
    assert bristle(1.0, 0.0, 2.0, 1e3, 1e-3) == pytest.approx(1.0)
    queue = Queue(3e-3)
    assert [queue.push(float(k), 1e-3) for k in range(6)] == [0, 0, 0, 0, 1, 2]


def test_a_gap_passes_nothing_until_it_is_crossed():
    place = layout("planar")
    gap = Gap({"half_gap": 0.02}, place, 0, Motors.of(ROBOTS["planar"].model, place))
    model = ROBOTS["planar"].model
    gap.edit(model)
    assert gap.passed(0.015, 0.0) == 0.0 and gap.passed(0.025, 0.0) > 0.0 and gap.passed(-0.035, 0.0) < 0.0
    assert gap.rotor + model.dof_armature[0] == pytest.approx(ROBOTS["planar"].model.dof_armature[0])


@pytest.mark.parametrize("w", [(2.0, 3.0), (2.0, -3.0), (-2.0, 3.0), (-2.0, -3.0)])
def test_what_couples_two_speeds_takes_power_and_gives_none(w):
    place = layout("planar")
    swirl = Swirl({"c": 0.1, "source": 1.0}, place, 0, Motors.of(ROBOTS["planar"].model, place))
    moment = Moment(0.0, 0.0, [0.0, 0.0], list(w), [0.0, 0.0], force=[0.0, 0.0])
    swirl.joint(moment)
    assert np.dot(moment.force, w) == pytest.approx(-0.1 * 2.0**2 * 3.0)


@pytest.mark.parametrize("robot", list(ROBOTS))
@pytest.mark.parametrize("name", ["speed_coupling", "crosstalk", "tied_outputs"])
def test_what_ties_one_joint_to_another_never_ties_it_to_itself(name, robot):
    """A cart's rail that was braked by its own speed had quadratic drag, which has a name."""
    rng = np.random.default_rng(5)
    for joint in places(name, robot):
        assert parameters(name, 0.1, robot, joint, rng)["source"] != joint


def test_a_stop_leaves_room_on_the_other_side_and_takes_some_where_the_joint_goes():
    for robot in ROBOTS.values():
        z, at = scales(robot.name), places("joint_limit", robot.name)
        for joint in at:
            stop = parameters("joint_limit", 0.5, robot.name, joint, np.random.default_rng(0))
            assert stop["low"] < z.low[joint] - 0.2 * (z.high[joint] - z.low[joint])
            assert z.low[joint] < stop["high"] < z.high[joint]
