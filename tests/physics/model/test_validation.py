"""Models whose numbers are none, or that claim too much: refused with one message, and nothing on stderr."""

import mujoco
import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from tests.versions import needs_mujoco_4

ARM = """<mujoco>{}<worldbody><body><joint name="elbow" axis="0 1 0"/><geom size="{}"/></body></worldbody>
<actuator><position joint="elbow" kp="{}"/></actuator><sensor><jointpos joint="elbow"/>{}</sensor></mujoco>"""


def arm(option: str = "", size: str = ".1", kp: str = "1", sensor: str = "") -> str:
    return ARM.format(option, size, kp, sensor)


@pytest.mark.parametrize(
    ("xml", "told"),
    [
        (arm('<option timestep="nan"/>'), "timestep: a step of nan s"),
        (arm('<option timestep="1e-300"/>'), "1e-06 to 1 s"),
        (arm('<option timestep="1e300"/>'), "1e-06 to 1 s"),
        (arm('<option gravity="0 0 inf"/>'), "gravity"),
        (arm(size="nan"), "nan size"),
        (arm(size="1e200"), "holds what is no number|does not compile"),
        (arm(kp="inf"), "actuator_gainprm"),
        (arm(kp="1e300"), "actuator_gainprm"),
        (arm(sensor='<user dim="2000000000"/>'), "claims 2,000,000,001 values of sensors; at most 100,000"),
    ],
)
def test_what_is_no_number_is_told_once(xml, told, capfd):
    with pytest.raises(InputError, match=told) as caught:
        Robot.from_string(xml, "arm.xml")
    assert "arm.xml" in str(caught.value) and "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


SLOTS = '<contact geom1="g" num="2000"/>'
DELAYED = '<jointpos joint="elbow" delay="0.01" nsample="100000"/>'
CLAIMS = {
    "values of sensors": (3, '<user dim="40000"/>'),
    "values of sensors, by slots of contacts": (3, SLOTS),
    "values of sensors, by rays of a camera": (1, '<rangefinder camera="eye"/>'),
    "kept values of sensors and actuators": (6, DELAYED),
}


@pytest.mark.parametrize("name", CLAIMS)
def test_what_a_model_claims_counts_in_sum(name):
    times, sensor = CLAIMS[name]
    eye = '<camera name="eye" resolution="100 100"/>'
    seeing = arm(sensor=times * sensor).replace("<worldbody>", f"<worldbody>{eye}").replace("<geom ", '<geom name="g" ')
    with pytest.raises(InputError, match=f"claims [0-9,]+ {name.partition(',')[0]}; at most [0-9,]+"):
        Robot.from_string(seeing)
    assert Robot.from_string(seeing.replace(sensor, "", times - 1).replace("100 100", "60 60"))


@pytest.mark.parametrize(
    ("option", "told"),
    [
        ('<option ls_iterations="10001"/>', "claims 10,001 iterations"),
        ('<custom><numeric name="n" size="600000"/><numeric name="m" size="600000"/></custom>', "custom numbers"),
    ],
)
def test_what_a_model_claims_is_bounded(option, told):
    with pytest.raises(InputError, match=told):
        Robot.from_string(arm(option))


def test_activations_count_in_sum():
    many = '<general joint="elbow" dyntype="user" actdim="6000"/>'
    with pytest.raises(InputError, match="claims 12,000 activations"):
        Robot.from_string(arm().replace("</actuator>", f"{many}{many}</actuator>"))
    assert Robot.from_string(arm().replace("</actuator>", f"{many}</actuator>"))


def test_sound_ones_pass_and_warnings_are_heard_again():
    heard: list[str] = []
    mujoco.set_mju_user_warning(heard.append)
    try:
        model = Robot.from_string(arm()).model
        assert not heard
        data = mujoco.MjData(model)
        data.qpos[:] = np.nan
        mujoco.mj_step(model, data)
        assert "QPOS" in heard[-1]
    finally:
        mujoco.set_mju_user_warning(None)


@needs_mujoco_4
def test_a_warning_while_a_model_is_read_is_not_heard(tmp_path, recwarn):
    twice = '<mujoco><worldbody><body><joint/><joint/><geom size="0.1"/></body></worldbody></mujoco>'
    with pytest.warns(UserWarning, match="singular"):
        mujoco.MjSpec.from_string(twice).compile()
    (tmp_path / "twice.xml").write_text(twice)
    recwarn.clear()
    with pytest.raises(InputError, match="twice.xml: the inertia matrix is singular at the joint 'joint_0'"):
        Robot.from_xml(tmp_path / "twice.xml")
    assert not recwarn.list


def test_joints_that_move_alike_are_sound_once_they_have_armature():
    twice = '<joint name="one" armature=".1"/><joint name="two" armature=".1"/>'
    xml = arm().replace('<joint name="elbow" axis="0 1 0"/>', twice).replace('"elbow"', '"one"')
    assert Robot.from_string(xml).model.njnt == 2
