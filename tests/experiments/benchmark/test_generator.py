"""The generator is another hand, always draws the same, and without an effect its robots are the nominal ones."""

import ast
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from experiments.benchmark.generator.answers import answer
from experiments.benchmark.generator.case import Plan, Planted
from experiments.benchmark.generator.catalogue import CATALOGUE, RELATIVES, UNKNOWN, places
from experiments.benchmark.generator.files import write_case
from experiments.benchmark.generator.making import make
from experiments.benchmark.generator.plans import SHARES, counts, plans
from experiments.benchmark.generator.readings import reading
from experiments.benchmark.generator.robots import ROBOTS, layout
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
    case = make(Plan("single", "planar", (Planted("sensor_delay", 0, 0.4),), 8), shorter=0.15, refit=False)
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
    case = make(Plan("pair", "planar", planted, 8), shorter=0.15, refit=False)
    late, weak = case.effects
    shoulder = channels(ROBOTS["planar"].model, layout("planar"))[0]
    recorded = case.recorded[0]
    time, steps = recorded.rows.time, recorded.whole
    shown = reading(shoulder, recorded, time, case.effects, case.plan.planted, "planar")
    before = np.interp(time - late.delay, steps.time, steps.q[:, 0])
    np.testing.assert_allclose(shown, weak.gain * before, atol=1e-3)
    assert np.abs(shown - before).max() > 0.01


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
        make(Plan("single", robot, (Planted("sensor_bias", joint, 0.5),), 12), shorter=0.15)
        for robot, joint in (("cartpole", 0), ("leg", 2))
    ]
    assert max(rail.visible.nominal.values()) > 30.0 and min(rail.visible.refit.values()) < 3.0
    assert min(knee.visible.refit.values()) > 3.0


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
