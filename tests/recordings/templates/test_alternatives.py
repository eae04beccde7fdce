"""Mappings that the nominal model contradicts are told, with what would fit far better."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.templates.alternatives import better_mappings

ARM = """
<mujoco><option timestep="0.002" integrator="implicitfast"/><default><geom contype="0" conaffinity="0"/></default>
<worldbody><body><joint name="a" axis="0 1 0" damping=".2" armature=".02"/>
 <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="{mass}"/>
 <body pos=".3 0 0"><joint name="b" axis="0 1 0" damping=".1" armature=".01" frictionloss="{friction}"/>
  <geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" mass=".3"/></body></body></worldbody>
<actuator><{motor} name="ma" joint="a" {gain}/><{motor} name="mb" joint="b" {gain}/></actuator>
<sensor><jointpos name="qa" joint="a"/><jointpos name="qb" joint="b"/></sensor></mujoco>
"""


def _arm(motor, mass=0.5, friction=0.0):
    gain = 'kp="20" kv=".5"' if motor == "position" else 'gear="1"'
    return Robot.from_string(ARM.format(motor=motor, gain=gain, mass=mass, friction=friction))


def _recording(motor):
    """Of a robot with another mass and some friction."""
    model = _arm(motor, 0.6, 0.1).model
    data, rows = mujoco.MjData(model), []
    for k in range(1500):
        t = k * 0.004
        rows.append((t, *(np.array([np.sin(2 * t), 0.8 * np.sin(3.1 * t + 1)]) * (1.0, 0.4)), *data.qpos))
        data.ctrl[:] = rows[-1][1:3]
        mujoco.mj_step(model, data, 2)
    table = np.array(rows)
    nothing = np.full((len(table), 2), np.nan)
    return Recording("a.csv", table[:, 0], table[:, 1:3], np.ones((len(table), 2)), table[:, 3:], nothing, nothing)


@pytest.mark.parametrize("motor", ["position", "motor"])
@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({}, []),
        ({"sensor": [1, 0]}, ["sensor.qa and sensor.qb exchanged|ctrl.ma and ctrl.mb exchanged"]),
        ({"ctrl": [1, 0]}, ["ctrl.ma and ctrl.mb exchanged|sensor.qa and sensor.qb exchanged"]),
        ({"ctrl": -1}, ["scale = -1.0 for ctrl.mb|scale = -1.0 for sensor.qb"]),
        ({"sensor": 180 / np.pi}, ['unit = "deg" for sensor.qb']),
    ],
)
def test_what_fits_far_better_is_told(motor, change, told):
    recording = _recording(motor)
    for name, how in change.items():
        values = getattr(recording, name)
        recording = replace(recording, **{name: values[:, how] if isinstance(how, list) else values * (1.0, how)})
    found = better_mappings(_arm(motor), recording)
    if motor == "position" or not told:  # torques of some tenths of a second tell less than servos
        assert len(found) == len(told)
    for sentence, either in zip(found, told, strict=False):
        assert any(each in sentence for each in either.split("|"))


def test_a_joint_that_turns_the_other_way_in_command_and_reading_is_told():
    recording = _recording("position")
    turned = replace(recording, ctrl=recording.ctrl * (-1, 1), sensor=recording.sensor * (-1, 1))
    [sentence] = better_mappings(_arm("position"), turned)
    assert "with scale = -1.0 for sensor.qa and ctrl.ma" in sentence


def test_what_cannot_be_replayed_is_not_doubted():
    recording = _recording("position")
    silent = replace(recording, sensor=np.where([[True, False]], np.nan, recording.sensor))
    assert better_mappings(_arm("position"), silent) == []
