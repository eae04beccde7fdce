"""Law terms in simulations: all engines agree, and terms of a command do what the named effects do."""

import numpy as np
import pytest

from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.registry import catalogue, effect
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, window_of
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


@pytest.mark.parametrize(
    ("law", "same"),
    [
        ({"law_deaf_motor": {"a": 1.0, "m_0": NM * 0.15}}, {"dead_band": {"half_width": 0.15}}),
        ({"law_late_command": {"a": 1.0, "T": 0.12}}, {"actuator_lag": {"tau": 0.12}}),
    ],
    ids=["dead_band", "actuator_lag"],
)
def test_laws_of_a_servos_command_do_what_its_named_effects_do(law: dict, same: dict) -> None:
    subject, rows = Robot.from_string(SERVO, "servo.xml"), 81
    time, nothing = 0.01 * np.arange(rows), np.full((rows, 1), np.nan)
    recording = Recording("r", time, 0.9 * np.cos(5.0 * time)[:, None], np.ones((rows, 1)), nothing, nothing, nothing)
    stretch = window_of([recording], 0, (0, rows - 1), 0.005, InitialState(np.zeros(1), np.zeros(1)))
    without = {next(iter(same)): {}}
    ways = []
    for acts, site in ((law, "j"), (same, "s"), (without, "s")):
        [(name, parameters)] = acts.items()
        effects, changes = catalogue([name]), [Change(name, site, parameters)] if parameters else []
        values = stack([encode(subject, effects, changes)])
        for engine in ("lanes", "mjx", "c"):
            replay = open_loop_simulator(subject, effects, [subject], engine=engine, width=1).replay
            ways.append(replay(values, [stretch], np.zeros(1, int)).qpos[0, :, 0])
    for way in ways[1:6]:
        np.testing.assert_allclose(way, ways[0], atol=3e-3)
    assert np.abs(ways[6] - ways[0]).max() > 0.05


@pytest.mark.parametrize(
    ("name", "p"),
    [
        ("law_stir", (0.05, 1.0)),
        ("law_tie", (0.3, 1.0, 0.1)),
        ("law_friction_wave", (0.03, 0.8, 5.0, 0.4)),
        ("law_driven", (0.3, 1.0)),
        ("law_late_command", (0.8, 0.05)),
        ("law_deaf_motor", (0.9, 0.1)),
        ("law_bristles", (0.2, 0.02)),
        ("law_inertia", (0.02,)),
        ("law_motor_brake", (0.1,)),
    ],
)
def test_engines_agree_on_laws(name: str, p: tuple[float, ...]) -> None:
    subject, rows = nominal("two"), 41
    law = effect(name)
    change = Change(law.name, "elbow", dict(zip([x.name for x in law.parameters], p, strict=True)))
    time = 0.01 * np.arange(rows)
    commands = np.stack([np.sin(9.0 * time), 0.4 * np.cos(7.0 * time)], axis=1)
    nothing = np.full((rows, 2), np.nan)
    recording = Recording("r", time, commands, np.ones((rows, 2)), nothing, nothing, nothing)
    stretch = window_of([recording], 0, (0, rows - 1), 0.005, InitialState(np.array([0.3, -0.2]), np.zeros(2)))
    effects = catalogue([name])
    values = stack([encode(subject, effects, [change]), encode(subject, effects, [])])
    found = [
        open_loop_simulator(subject, effects, [subject], engine=engine, width=2).replay(
            values, [stretch], np.zeros(2, int)
        )
        for engine in ("lanes", "mjx", "c")
    ]
    np.testing.assert_allclose(found[0].qpos, found[1].qpos, atol=2e-5)
    np.testing.assert_allclose(found[2].qpos, found[1].qpos, atol=2e-5)
    assert np.abs(found[0].qpos[0] - found[0].qpos[1]).max() > 5e-3
