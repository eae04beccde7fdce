"""Robots from MJCF: names, places, and what is said about a file that is none."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot, spec_element
from tests.physics.reference import recompiled
from tests.physics.robots import robot


def test_errors_name_the_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.xml: no such MJCF"):
        Robot.from_xml(tmp_path / "none.xml")
    broken = tmp_path / "broken.xml"
    broken.write_text("<mujoco><worldbody><body><joint/></body></worldbody></mujoco>")
    with pytest.raises(InputError, match=r"broken\.xml: the MJCF does not compile: .*mass"):
        Robot.from_xml(broken)
    broken.write_text("<mujoco><body")
    with pytest.raises(InputError, match=r"broken\.xml"):
        Robot.from_xml(broken)
    with pytest.raises(InputError, match=r"typed: the MJCF does not compile"):
        Robot.from_string("<mujoco><actuator><motor joint='j'/></actuator></mujoco>", "typed")


def test_an_unknown_name_lists_what_exists() -> None:
    with pytest.raises(InputError, match=r"quadruped\.xml: there is no joint 'tail'; known are: root, hip_f"):
        robot("quadruped").index("joint", "tail")
    with pytest.raises(InputError) as caught:
        robot("quadruped").index("body", "tail")
    assert "world" not in str(caught.value)


def test_the_unnamed_are_called_by_kind_and_index_in_model_and_description() -> None:
    nameless = robot("nameless")
    assert nameless.names("joint") == ("joint_0", "left", "joint_2", "right")
    assert nameless.names("actuator") == ("actuator_0", "actuator_1", "actuator_2")
    for kind in ("joint", "actuator", "sensor", "body"):
        for index, name in enumerate(nameless.names(kind)):
            assert spec_element(nameless.spec, nameless, kind, name).id == index


def test_a_name_holds_after_a_part_is_gone() -> None:
    quadruped = robot("quadruped")
    spec = quadruped.spec.copy()
    spec.delete(spec_element(spec, quadruped, "body", "upper_f"))
    assert spec_element(spec, quadruped, "joint", "knee_r").name == "knee_r"
    with pytest.raises(InputError, match="knee_f"):
        spec_element(spec, quadruped, "joint", "knee_f")


def test_the_description_given_is_not_touched() -> None:
    spec = mujoco.MjSpec.from_string("<mujoco><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>")
    Robot.from_spec(spec)
    assert spec.joints[0].name == ""


def test_home_is_the_keyframe_of_that_name_then_the_first_then_qpos0() -> None:
    body = "<worldbody><body><joint ref='0.5' type='slide'/><geom size='1'/></body></worldbody>"
    keys = "<keyframe><key qpos='1'/>{}</keyframe>"
    for more, wanted in (("<key name='home' qpos='2'/>", 2.0), ("<key name='away' qpos='3'/>", 1.0)):
        assert Robot.from_string(f"<mujoco>{body}{keys.format(more)}</mujoco>").home() == wanted
    assert Robot.from_string(f"<mujoco>{body}</mujoco>").home() == 0.5


def test_places_of_sensors_and_columns() -> None:
    quadruped, cartpole = robot("quadruped"), robot("cartpole")
    for leg in "flbr":
        for kind in ("touch", "angle"):
            body = quadruped.body_of_sensor(quadruped.index("sensor", f"{kind}_{leg}"))
            assert body == quadruped.index("body", f"lower_{leg}")
    assert cartpole.sensor_columns() == ("place", "lean", "where.0", "where.1", "where.2")
    lower = [quadruped.index("body", n) for n in ("upper_l", "lower_l")]
    assert quadruped.subtree(lower[0]) == tuple(lower)


DERIVED = """
<mujoco>
  <compiler inertiafromgeom="true" autolimits="true"/>
  <worldbody>
    <body name="arm"><joint name="j" axis="0 1 0" springdamper="0.5 1"/>
      <inertial pos="0 0 9" mass="9" diaginertia="9 9 9"/><geom size="0.1" pos="0 0 -0.3" mass="1"/>
      <body name="hand" pos="0 0 -0.6"><joint name="k" axis="0 1 0"/><geom size="0.1" pos="0 0 -0.3" mass="0.5"/></body>
    </body>
  </worldbody>
  <actuator><position name="servo" joint="j" kp="5" dampratio="1" forcerange="-3 3"/></actuator>
</mujoco>
"""


@pytest.mark.parametrize(
    "change", ["body_mass@arm dm=1", "part_lost@hand", "armature@j I=0.5", "viscous_friction@j c=2"]
)
def test_a_change_leaves_alone_what_the_compiler_derives_from_the_whole(change: str) -> None:
    derived = Robot.from_string(DERIVED)
    nominal, changed = derived.model, recompiled(derived, [parse_change(change, derived)])
    assert nominal.actuator_biasprm[0, 2] < 0.0 and nominal.dof_damping[0] > 0.0
    np.testing.assert_allclose(changed.actuator_biasprm[0], nominal.actuator_biasprm[0])
    np.testing.assert_allclose(changed.jnt_stiffness[0], nominal.jnt_stiffness[0])
    added = 2.0 if change.startswith("viscous") else 0.0
    assert changed.dof_damping[0] == pytest.approx(nominal.dof_damping[0] + added)
    dm = 1.0 if change.startswith("body") else 0.0
    assert changed.body_mass[1] == pytest.approx(nominal.body_mass[1] + dm)
    np.testing.assert_allclose(changed.body_ipos[1], nominal.body_ipos[1])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("masses", ['settotalmass="7"', 'settotalmass="7" inertiafromgeom="true"'])
def test_what_mujoco_warns_of_a_model_is_not_heard_each_time_it_is_changed(masses: str) -> None:
    scaled = Robot.from_string(DERIVED.replace('inertiafromgeom="true"', masses))
    assert scaled.model.body_mass.sum() == pytest.approx(7.0)
    for other in (scaled.finer(2).model, recompiled(scaled, [parse_change("viscous_friction@j c=2", scaled)])):
        for name in ("body_mass", "body_inertia", "body_ipos", "body_iquat"):
            np.testing.assert_allclose(getattr(other, name), getattr(scaled.model, name), atol=1e-12)


def test_a_lost_strength_of_all_compiles_where_limits_are_spelled_out() -> None:
    xml = DERIVED.replace('forcerange="-3 3"', 'forcelimited="true" forcerange="-3 3"')
    derived = Robot.from_string(xml)
    model = recompiled(derived, [parse_change("motor_weakness@servo loss=1", derived)])
    assert not model.actuator_gainprm[0].any() and not model.actuator_biasprm[0].any()


def test_an_unknown_effect_lists_the_catalogue() -> None:
    with pytest.raises(InputError, match="there is no effect 'rust'.*body_mass"):
        effect("rust")
