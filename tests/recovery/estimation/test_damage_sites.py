"""Equivalent damage has one form, and every site takes every amount."""

import numpy as np

from estexp_jax.physics.effects.changes import encode, neutral
from estexp_jax.physics.effects.registry import paper
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.estimation.damage_sites import DamageSite, canonical_damage, change_of, damage_sites


def test_equivalent_edits_are_merged(quadruped: Robot) -> None:
    weak, body = DamageSite("motor_weakness", "knee_f"), DamageSite("body_mass", "torso")
    assert canonical_damage(quadruped, [(weak, 0.5), (weak, 0.5)]) == ((weak, 0.75),)
    assert canonical_damage(quadruped, [(body, 0.5), (body, -0.5)]) == ()


def test_what_sits_on_a_lost_part_is_dropped_but_its_sensors(quadruped: Robot) -> None:
    lost, lower = DamageSite("part_lost", "upper_f"), DamageSite("part_lost", "lower_f")
    on_it = [
        DamageSite("motor_weakness", "knee_f"),
        DamageSite("joint_jam", "hip_f"),
        DamageSite("body_mass", "lower_f"),
    ]
    sensor = DamageSite("sensor_gain", "touch_f")
    items = [(lost, 1.0), (lower, 1.0), *((place, 0.5) for place in on_it), (sensor, 0.5)]
    assert canonical_damage(quadruped, items) == ((lost, 1.0), (sensor, 0.5))


def test_every_place_takes_every_amount(quadruped: Robot) -> None:
    effects = paper()
    for name in (e.name for e in paper()):
        for place in damage_sites(quadruped, name):
            values = encode(quadruped, effects, [change_of(quadruped, place, 0.5)])
            nominal = neutral(quadruped, effects)
            differing = {key for key in values if not np.array_equal(values[key], nominal[key])}
            assert differing == {name}


def test_a_motor_repeats_one_other(quadruped: Robot) -> None:
    ties = [(DamageSite("tied_outputs", "hip_f", partner), 1.0) for partner in (2, 3)]
    assert canonical_damage(quadruped, ties) == (ties[0],)
    assert canonical_damage(quadruped, [*ties, (DamageSite("part_lost", "upper_f"), 1.0)]) == (
        (DamageSite("part_lost", "upper_f"), 1.0),
    )


def test_a_sensor_can_be_stuck_at_zero(quadruped: Robot) -> None:
    stuck = ((DamageSite("sensor_stuck", "angle_f"), 0.0),)
    assert canonical_damage(quadruped, stuck) == stuck
