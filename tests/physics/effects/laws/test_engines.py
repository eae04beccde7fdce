"""Law terms in simulations: all engines agree, and terms of a command do what the named effects do."""

from functools import cache
from itertools import product

import numpy as np
import pytest

from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.registry import catalogue, effect
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, Window, window_of
from tests.discovery.planted import nominal

SERVO = """
<mujoco>
  <option timestep="0.005" integrator="implicitfast"/>
  <worldbody><body><joint name="j" axis="0 1 0" damping="0.02" armature="0.01"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.3"/></body></worldbody>
  <actuator><position name="s" joint="j" gear="0.8" kp="8" kv="0.3" forcerange="-4 4" ctrlrange="-1.4 1.4"/></actuator>
</mujoco>
"""
NM = 0.8 * 8.0
"""Torque for each unit of its command, N m."""


ENGINES = ("lanes", "mjx", "c")
SAME = {
    "dead_band": ({"law_deaf_motor": {"a": 1.0, "m_0": NM * 0.15}}, {"dead_band": {"half_width": 0.15}}),
    "actuator_lag": ({"law_late_command": {"a": 1.0, "T": 0.12}}, {"actuator_lag": {"tau": 0.12}}),
}
"""A law's values and those of the effect that does the same, by the effect's name."""
LAWS = {
    "law_stir": (0.05, 1.0),
    "law_tie": (0.3, 1.0, 0.1),
    "law_friction_wave": (0.03, 0.8, 5.0, 0.4),
    "law_driven": (0.3, 1.0),
    "law_late_command": (0.8, 0.05),
    "law_deaf_motor": (0.9, 0.1),
    "law_bristles": (0.2, 0.02),
    "law_inertia": (0.02,),
    "law_motor_brake": (0.1,),
}


@cache
def servos() -> dict[str, dict[str, np.ndarray]]:
    """Positions (rows,) of the servo with each acting law or effect, and nominal ones, by engine."""
    subject, rows = Robot.from_string(SERVO, "servo.xml"), 81
    time, nothing = 0.01 * np.arange(rows), np.full((rows, 1), np.nan)
    recording = Recording("r", time, 0.9 * np.cos(5.0 * time)[:, None], np.ones((rows, 1)), nothing, nothing, nothing)
    window = window_of([recording], 0, (0, rows - 1), 0.005, InitialState(np.zeros(1), np.zeros(1)))
    acts = {
        name: (values, site)
        for pair in SAME.values()
        for part, site in zip(pair, "js", strict=True)
        for name, values in part.items()
    }
    sets = {"nominal": [], **{name: [Change(name, site, values)] for name, (values, site) in acts.items()}}
    found = replayed(subject, [*acts], window, list(sets.values()))
    return {engine: dict(zip(sets, qpos[:, :, 0], strict=True)) for engine, qpos in found.items()}


def replayed(subject: Robot, names: list[str], window: Window, sets: list[list[Change]]) -> dict[str, np.ndarray]:
    """Positions (sets, rows, joints) under each set of changes in one window, by engine: one program for all."""
    effects = catalogue(names)
    values = stack([encode(subject, effects, changes) for changes in sets])
    return {
        engine: open_loop_simulator(subject, effects, [subject], engine=engine, width=len(sets))
        .replay(values, [window], np.zeros(len(sets), int))
        .qpos
        for engine in ENGINES
    }


@pytest.mark.parametrize("name", SAME)
def test_laws_of_a_servos_command_do_what_its_named_effects_do(name: str) -> None:
    [law], [effect_] = SAME[name]
    found = servos()
    for engine, act in product(ENGINES, (law, effect_)):
        np.testing.assert_allclose(found[engine][act], found["lanes"][law], atol=3e-3)
    assert np.abs(found["lanes"]["nominal"] - found["lanes"][law]).max() > 0.05


@cache
def with_laws() -> dict[str, np.ndarray]:
    """Positions (laws and the nominal robot, rows, joints) of two joints with each of the laws, by engine."""
    subject, rows = nominal("two"), 41
    time = 0.01 * np.arange(rows)
    commands = np.stack([np.sin(9.0 * time), 0.4 * np.cos(7.0 * time)], axis=1)
    nothing = np.full((rows, 2), np.nan)
    recording = Recording("r", time, commands, np.ones((rows, 2)), nothing, nothing, nothing)
    window = window_of([recording], 0, (0, rows - 1), 0.005, InitialState(np.array([0.3, -0.2]), np.zeros(2)))
    changes = [
        [Change(name, "elbow", dict(zip([x.name for x in effect(name).parameters], p, strict=True)))]
        for name, p in LAWS.items()
    ]
    return replayed(subject, [*LAWS], window, [*changes, []])


@pytest.mark.parametrize("name", LAWS)
def test_engines_agree_on_laws(name: str) -> None:
    found, row = with_laws(), list(LAWS).index(name)
    for engine in ENGINES:
        np.testing.assert_allclose(found[engine][row], found["mjx"][row], atol=2e-5)
    assert np.abs(found["lanes"][row] - found["lanes"][-1]).max() > 5e-3
