"""What people write, and what they are told when it is wrong."""

import mujoco
import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change, encode, neutral, parse_change, stack
from estexp_jax.physics.effects.registry import catalogue, effect, paper
from estexp_jax.physics.model.robot import Robot
from tests.physics.robots import robot


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("rust@knee_f x=1", ["rust", "motor_weakness"]),
        ("", ["there is no effect", "motor_weakness"]),
        ("motor_weakness@elbow loss=0.5", ["elbow", "knee_f"]),
        ("motor_weakness loss=0.5", ["knee_f"]),
        ("gravity_tilt@torso angle=0.1", ["gravity_tilt", "takes no place"]),
        ("motor_weakness@knee_f gain=0.5", ["gain=0.5", "loss"]),
        ("motor_weakness@knee_f loss", ["loss"]),
        ("motor_weakness@knee_f loss=half", ["half", "loss"]),
        ("motor_weakness@knee_f loss=nan", ["nan"]),
        ("body_mass@torso", ["no parameter", "dm=..."]),
        ("tied_outputs@knee_f with=tail", ["tail"]),
    ],
)
def test_a_wrong_change_says_what_would_be_right(text: str, named: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        parse_change(text, robot("quadruped"))
    assert all(word in str(caught.value) for word in named)


SWITCHED = {"constraint", "frictionloss", "limit", "damper", "spring", "gravity", "contact"}


@pytest.mark.parametrize(
    ("text", "flags"),
    [
        ("coulomb_friction@knee_f T=0.1", {"constraint", "frictionloss"}),
        ("stribeck_friction@knee_f S=0.1", {"constraint", "frictionloss"}),
        ("joint_limit@knee_f high=0.5", {"constraint", "limit"}),
        ("viscous_friction@knee_f c=0.1", {"damper"}),
        ("joint_stiffness@knee_f k=0.1", {"spring"}),
        ("gravity_tilt angle=0.1", {"gravity"}),
        ("ground_friction mu=0.5", {"constraint", "contact"}),
        ("body_mass@torso dm=0.1", set()),
    ],
)
def test_what_a_flag_of_the_model_switches_off_is_refused(text: str, flags: set[str]) -> None:
    refused = dict[str, str]()
    for flag in SWITCHED:
        spec = robot("quadruped").spec.copy()
        spec.option.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag.upper()}"))
        try:
            parse_change(text, Robot.from_spec(spec))
        except InputError as error:
            refused[flag] = str(error)
    assert set(refused) == flags
    assert all(f'<flag {flag}="enable"/>' in said for flag, said in refused.items())


def test_a_lost_part_needs_no_number_and_a_tie_takes_a_name() -> None:
    quadruped = robot("quadruped")
    assert parse_change("part_lost@lower_f", quadruped).parameters == {"lost": 1.0}
    tied = parse_change("tied_outputs@knee_f with=hip_l", quadruped)
    assert tied.parameters == {"with": 1.0 + quadruped.names("actuator").index("hip_l")}


def test_changes_at_one_place_add_up() -> None:
    quadruped, effects = robot("quadruped"), paper()
    texts = ("body_mass@torso dm=1", "body_mass@torso dm=-0.25", "sensor_gain@angle_f gain=0.8")
    values = encode(quadruped, effects, [parse_change(t, quadruped) for t in texts])
    names = effect("body_mass").sites(quadruped)
    assert values["body_mass"][names.index("torso"), 0] == pytest.approx(0.75)
    sensors = effect("sensor_gain").sites(quadruped)
    assert values["sensor_gain"][sensors.index("angle_f"), 0] == pytest.approx(0.8)


def test_encoding_refuses_what_the_catalogue_lacks() -> None:
    quadruped, effects = robot("quadruped"), catalogue(["body_mass"])
    with pytest.raises(InputError, match="armature"):
        encode(quadruped, effects, [Change("armature", "knee_f", {"I": 0.1})])
    with pytest.raises(InputError, match="tail"):
        encode(quadruped, effects, [Change("body_mass", "tail", {"dm": 0.1})])


def test_a_stack_has_the_robots_first() -> None:
    values = stack([neutral(robot("quadruped"), paper())] * 3)
    assert {v.shape[0] for v in values.values()} == {3}
    assert {v.dtype for v in values.values()} == {np.dtype(np.float32)}
