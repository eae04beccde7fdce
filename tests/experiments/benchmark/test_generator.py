"""The generator is another hand, always draws the same, and without an effect its robots are the nominal ones."""

import ast
import sys
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

from experiments.benchmark.generator.answers import answer
from experiments.benchmark.generator.case import Plan, Planted
from experiments.benchmark.generator.catalogue import CATALOGUE, RELATIVES, UNKNOWN, parameters, places
from experiments.benchmark.generator.effect import Moment, Queue, bristle
from experiments.benchmark.generator.equations import by_hand
from experiments.benchmark.generator.excitation import controller, motion
from experiments.benchmark.generator.files import write_case
from experiments.benchmark.generator.joints import Gap, Swirl
from experiments.benchmark.generator.making import build, make
from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.plans import SHARES, counts, plans
from experiments.benchmark.generator.plant import Plant, clock
from experiments.benchmark.generator.readings import reading
from experiments.benchmark.generator.robots import ROBOTS, layout
from experiments.benchmark.generator.scales import scales
from experiments.benchmark.generator.sensing import channels

GENERATOR = Path(__file__).parents[3] / "experiments" / "benchmark" / "generator"


def test_it_shares_no_code_with_the_package():
    allowed = {"mujoco", "numpy", "scipy", *sys.stdlib_module_names}
    for path in GENERATOR.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                own = name.startswith("experiments.benchmark.generator")
                assert own or name.split(".")[0] in allowed, f"{path.name} imports {name}"


@pytest.mark.parametrize("robot", ["leg", "planar", "cartpole", "arm6", "scara"])
@pytest.mark.parametrize("hand", [False, True])
def test_without_effects_and_errors_a_robot_is_its_nominal_model(robot, hand):
    if hand and not ROBOTS[robot].by_hand:
        pytest.skip("not written out")
    case = make(Plan("null", robot, (), 5, hand), shorter=0.2, clean=True, refit=False)
    smeared = 1.5 if robot in ("arm6", "scara") else 0.5  # jumps of the command within a coarse nominal step
    assert max(case.visible.nominal.values()) < smeared, "beyond its own step error, in noise floors"


def test_a_late_sensor_shows_at_the_first_row_where_the_robot_was_before():
    case = make(Plan("single", "planar", (Planted("sensor_delay", 0, 0.4),), 8), shorter=0.3, refit=False)
    [effect], late = case.effects, case.effects[0].delay
    assert 0.02 < late < 0.03
    shoulder = channels(ROBOTS["planar"].model, layout("planar"))[0]
    for recorded in case.recorded:
        time, steps = recorded.rows.time, recorded.steps
        shown = reading(shoulder, recorded, time, [effect], case.plan.planted, "planar")
        ahead = np.interp(time + late, time, shown)[time < 0.2]  # what it shows a delay later is where it was
        assert np.abs(ahead - recorded.rows.q[time < 0.2, 0]).max() < 1e-3
        assert shown[0] == pytest.approx(steps.q[0, 0] - late * steps.w[0, 0], abs=0.5 * 60.0 * late**2)
        assert steps.time[0] == 0.0 and recorded.whole.time[0] == pytest.approx(-0.1, abs=2e-3)


def test_two_faults_of_one_sensor_both_show():
    planted = (Planted("sensor_delay", 0, 0.4), Planted("sensor_gain", 0, 0.4))
    case = make(Plan("pair", "planar", planted, 8), shorter=0.3, refit=False)
    late, weak = case.effects
    shoulder = channels(ROBOTS["planar"].model, layout("planar"))[0]
    recorded = case.recorded[0]
    time, steps = recorded.rows.time, recorded.whole
    shown = reading(shoulder, recorded, time, case.effects, case.plan.planted, "planar")
    before = np.interp(time - late.delay, steps.time, steps.q[:, 0])
    np.testing.assert_allclose(shown, weak.gain * before, atol=1e-3)
    assert np.abs(shown - before).max() > 0.01


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
    moved = motion("gait" if name == "quadruped" else "sines", np.array(robot.reach), 1.5, rng)
    rows = clock(1.5, 100.0, 0.0, plant.step, rng)
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


def test_equal_plans_give_equal_files_without_a_label(tmp_path):
    plan = Plan("single", "planar", (Planted("coulomb_friction", 1, 0.5),), 17)
    for folder in ("a", "b"):
        write_case(case := make(plan, shorter=0.14, refit=False), tmp_path / folder)
    names = sorted(p.name for p in (tmp_path / "a").iterdir())
    assert names == ["nominal.xml", "recordings.toml", "test_0.csv", "train_0.csv", "train_1.csv", "train_2.csv"]
    words = {*CATALOGUE, *SHARES, "unknown", "seed", "truth", "answer"} - {"null", "armature"}  # MJCF has armatures
    for name in names:
        text = (tmp_path / "a" / name).read_text()
        assert text == (tmp_path / "b" / name).read_text()
        assert not [w for w in words if w in text]
    known = answer(case)
    assert known["effects"][0]["effect"] == "coulomb_friction" and known["effects"][0]["name"] == "elbow"
    assert known["visibility"]["shown"] > 3.0


def test_a_joint_that_stands_still_and_is_seen_without_noise_says_nothing_of_what_is_visible():
    """Its speed, 0 in all rows, has neither a range nor noise."""
    case = make(Plan("hidden", "leg", (Planted("joint_limit", 0, 0.1),), 5), shorter=0.14)
    assert np.ptp(case.recorded[0].rows.w[:, 0]) == 0.0
    assert 0.0 < case.visible.floor < 1.0 and all(np.isfinite([*case.visible.nominal.values()]))
    assert all(np.isfinite([*case.visible.refit.values()]))


def test_a_bias_shows_where_the_motion_depends_on_the_position_alone():
    """Along a free rail every place is like every other, so that recordings begin elsewhere says nothing."""
    rail, knee = [
        make(Plan("single", robot, (Planted("sensor_bias", joint, 0.5),), 12), shorter=0.3)
        for robot, joint in (("cartpole", 0), ("leg", 2))
    ]
    assert max(rail.visible.nominal.values()) > 30.0 and min(rail.visible.refit.values()) < 3.0
    assert min(knee.visible.refit.values()) > 3.0


def test_a_stop_leaves_room_on_the_other_side_and_takes_some_where_the_joint_goes():
    for robot in ROBOTS.values():
        z, at = scales(robot.name), places("joint_limit", robot.name)
        for joint in at:
            stop = parameters("joint_limit", 0.5, robot.name, joint, np.random.default_rng(0))
            assert stop["low"] < z.low[joint] - 0.2 * (z.high[joint] - z.low[joint])
            assert z.low[joint] < stop["high"] < z.high[joint]


def test_what_a_walker_leaves_without_the_effect_is_not_the_effects():
    single = make(Plan("single", "quadruped", (Planted("ground_friction", -1, 0.05),), 13), shorter=0.1)
    assert single.twin is not None
    shown = answer(single)["visibility"]
    left = {role: np.sqrt(max(shown["refit"][role] ** 2 - shown["twin"][role] ** 2, 0.0)) for role in shown["refit"]}
    assert min(shown["twin"].values()) > 0.0 and shown["shown"] == pytest.approx(min(left.values()))


@pytest.mark.parametrize("robot", ["leg", "planar", "arm6", "cartpole", "scara"])
def test_a_first_links_mass_is_rotor_inertia_where_an_answer_says_so(robot):
    """Where it is, more of it changes nothing but the inertia about the first joint."""
    case = make(Plan("single", robot, (Planted("body_mass", 0, 0.5),), 14), shorter=0.14, refit=False)
    model, heavier = case.truth, case.effects[0]
    other = model.__copy__()
    heavier.edit(other)
    bias, inertia = np.zeros((2, model.nv)), np.zeros((2, model.nv, model.nv))
    for k, m in enumerate((model, other)):
        data = mujoco.MjData(m)
        data.qpos[:], data.qvel[:] = 0.3, 0.4
        mujoco.mj_forward(m, data)
        bias[k] = data.qfrc_bias
        for dof in range(m.nv):
            mujoco.mj_mulM(m, data, inertia[k, dof], np.eye(m.nv)[dof])
    changed = np.abs(inertia[1] - inertia[0])
    same = np.allclose(bias[0], bias[1]) and changed[0, 0] > 0.0 and np.allclose(changed.sum(), changed[0, 0])
    assert same == ("armature" in answer(case)["equivalents"][0])


def test_a_set_has_all_groups_and_every_effect_a_place():
    drawn = plans(3, 60, ["leg", "planar"])
    assert {p.group for p in drawn} == set(SHARES) and len(drawn) == 60 and len({p.seed for p in drawn}) == 60
    assert drawn == plans(3, 60, ["leg", "planar"]) != plans(4, 60, ["leg", "planar"])
    assert counts(420)["null"] + counts(420)["parameters"] >= 150
    for name in CATALOGUE:
        assert any(places(name, robot) for robot in ROBOTS), name
    assert not {*RELATIVES, *UNKNOWN} - set(CATALOGUE)
