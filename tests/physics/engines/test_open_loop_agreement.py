"""Engines are compared with plain MuJoCo on the user's robot: what differs is found, and named."""

from dataclasses import replace

import mujoco
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines import choice
from estexp_jax.physics.engines.c.open_loop import COpenLoop
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop_agreement import open_loop_agreement
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.settings import apply_settings
from tests.physics.robots import robot

EFFECTS = catalogue(["body_mass"])
ARM = """
<mujoco><option timestep="0.004" integrator="implicitfast" {option}/><worldbody><body name="upper" pos="0 0 1">
<joint name="shoulder" axis="0 1 0" damping="0.05" {joint}/><geom type="capsule" size=".03" fromto="0 0 0 .3 0 0"
mass=".8"/><site name="hand" pos=".3 0 0"/></body></worldbody>
<actuator><position name="servo" joint="shoulder" kp="60" {actuator}/></actuator>
<sensor><jointpos name="angle" joint="shoulder"/><accelerometer name="felt" site="hand" {sensor}/></sensor></mujoco>
"""
PLAIN = {"option": "", "joint": "", "actuator": 'kv="6"', "sensor": ""}
LIMITED = {"joint": 'actuatorfrcrange="-6 6"'}


def arm(**what: str) -> Robot:
    return Robot.from_string(ARM.format(**PLAIN | what), "arm.xml")


def on_c(one: Robot) -> COpenLoop:
    simulator = open_loop_simulator(one, EFFECTS, [one], engine="c")
    assert isinstance(simulator, COpenLoop)
    return simulator


def test_a_replayer_is_tried_as_the_first_recording_knew_the_robot() -> None:
    one = robot("cartpole")
    heavy = apply_settings(one, {"body.pole.mass": 0.5, "option.timestep": 0.002})
    replays = open_loop_simulator(one, EFFECTS, [heavy, one], width=8, block=4, engine="lanes")
    found = open_loop_agreement(replays, heavy)
    assert found.agrees and found.states > 20 and found.physics_steps == 2
    assert not open_loop_agreement(replays, one).agrees


def test_the_c_engine_agrees_to_the_last_bit_and_says_so() -> None:
    assert on_c(arm()).choice.largest_difference == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("what", "words"),
    [
        (LIMITED, "the motion of joint 'shoulder', saturated"),
        ({"joint": 'range="-1 1" limited="true"'}, "the motion of joint 'shoulder'"),
        ({"actuator": 'kv="6.3"'}, "the motion of joint 'shoulder'"),
        ({"sensor": 'cutoff="3"'}, "sensor 'felt'"),
        ({"actuator": 'kv="6" delay=".008" nsample="2"'}, "the motion of joint 'shoulder'"),
    ],
)
def test_what_an_engine_passes_over_is_found_and_named(what: dict[str, str], words: str) -> None:
    found = open_loop_agreement(on_c(arm()), arm(**what), converged=False)  # an engine without the feature
    assert not found.agrees and words in found.sentence()


def test_states_in_which_mujoco_itself_gives_up_do_not_count() -> None:
    weak = arm(actuator='kv="6"').spec.copy()
    weak.actuator("servo").gainprm[0], weak.option.integrator = 1e13, mujoco.mjtIntegrator.mjINT_EULER
    one = Robot.from_spec(weak)
    found = on_c(one).choice
    assert found.engine == "c" and found.largest_difference == 0.0


def test_an_engine_that_differs_is_not_used_and_alone_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    one = robot("cartpole")
    bad = open_loop_agreement(on_c(arm()), arm(**LIMITED), converged=False)
    good = replace(bad, median=0.0, high=0.0, largest=2e-7, differing="")
    monkeypatch.setattr(choice, "open_loop_agreement", lambda s, *_, **__: good if isinstance(s, COpenLoop) else bad)
    chosen = open_loop_simulator(one, EFFECTS, [one])
    assert chosen.choice.engine == "c" and chosen.choice.largest_difference == 2e-7
    assert "differs from plain MuJoCo in the motion of joint 'shoulder', saturated" in chosen.choice.reason
    with pytest.raises(InputError, match=r"saturated.*use --engine c"):
        open_loop_simulator(one, EFFECTS, [one], engine="lanes")


def test_where_no_engine_agrees_the_feature_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    one = arm(option='actuatorgroupdisable="1"')
    bad = replace(open_loop_agreement(on_c(one), one, converged=False), median=float("nan"))
    monkeypatch.setattr(choice, "open_loop_agreement", lambda *_, **__: bad)
    with pytest.raises(InputError, match="the model has disabled groups of actuators"):
        open_loop_simulator(one, EFFECTS, [one], engine="c")
