"""A first MJCF of a robot without motors and sensors, as every URDF is: servos and angle sensors at its joints."""

from __future__ import annotations

import shutil
from pathlib import Path

import mujoco

from estexp_jax.errors import InputError
from estexp_jax.physics.model.portable import ASSETS, portable
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.spec import spec_elements
from estexp_jax.runs import write_text

_SWAY = {mujoco.mjtJoint.mjJNT_HINGE: 0.1, mujoco.mjtJoint.mjJNT_SLIDE: 0.01}
"""The error, rad or m, at which a guessed servo gives all its force."""
_FORCE = 10.0
"""N m or N, of a servo whose force is not limited."""
_HEAD = """<!-- A first MJCF of {name}. Servos and angle sensors were added at joints that had none. The gains are
     guesses: put in what your servos do, or motors (<motor joint="..."/>) where commands are torques. The base is fixed
     unless the model says otherwise; for a robot that moves about put <freejoint name="root"/> into its first body, and
     a floor (<geom type="plane" size="0 0 1"/>) into the world. -->
"""


def first_model(robot: Robot) -> mujoco.MjSpec:
    """The robot's description with a position servo and an angle sensor at each hinge and slide joint that has none.

    A servo reaches the joint's force limit at 0.1 rad (1 cm) of error, critically damped; commands end at its range.

    Raises:
        InputError: the robot has no such joint.
    """
    model, spec = robot.model, robot.spec.copy()
    if not robot.scalar_joints:
        raise InputError("the robot has no hinge and no slide joint", where=robot.source)
    driven = {robot.joint_of_actuator(a) for a in range(model.nactuator)}
    sensors = {element.name for element in spec_elements(spec)["sensor"]}
    measured = model.sensor_objid[model.sensor_type == int(mujoco.mjtSensor.mjSENS_JOINTPOS)].tolist()
    for joint in robot.scalar_joints:
        name = robot.names("joint")[joint]
        if joint not in driven:
            _add_servo(spec, model, joint, name)
        if joint not in measured and f"{name}_pos" not in sensors:
            spec.add_sensor(
                name=f"{name}_pos",
                type=mujoco.mjtSensor.mjSENS_JOINTPOS,
                objtype=mujoco.mjtObj.mjOBJ_JOINT,
                objname=name,
            )
    spec.compile()
    return spec


def _add_servo(spec: mujoco.MjSpec, model: mujoco.MjModel, joint: int, name: str) -> None:
    limited = bool(model.jnt_actfrclimited[joint])
    force = float(abs(model.jnt_actfrcrange[joint]).max()) if limited else _FORCE
    servo = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    servo.set_to_position(kp=force / _SWAY[mujoco.mjtJoint(int(model.jnt_type[joint]))], dampratio=1.0)
    if limited:
        servo.forcerange = model.jnt_actfrcrange[joint]
    if model.jnt_limited[joint]:
        servo.ctrlrange = model.jnt_range[joint]


def write_first_model(robot: Robot, folder: Path) -> Path:
    """Write `first_model` and the files that belong beside it into a folder; gives its path.

    Raises:
        InputError: there is such a file already, or it cannot be written.
    """
    path = folder / f"{Path(robot.source).stem}.xml"
    text, files = portable(first_model(robot))
    try:
        if path.exists():
            raise InputError("exists already", where=str(path), right="move it away, or give another folder with --out")
        path.parent.mkdir(parents=True, exist_ok=True)
        for name, source in files.items():
            (folder / ASSETS).mkdir(exist_ok=True)
            target = folder / ASSETS / name
            if not target.exists():
                shutil.copyfile(source, target)
            elif target.read_bytes() != source.read_bytes():
                raise InputError("is another file", where=str(target), right="give another folder with --out")
        write_text(path, _HEAD.format(name=Path(robot.source).name.replace("--", "- -")) + text)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", where=str(path)) from None
    return path
