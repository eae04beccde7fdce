"""What is known to differ in a recording, put into the robot's description: `actuator.servo.kp = 1.77`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from estexp_jax.errors import InputError, known
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.columns import parse_number

# MJCF attribute -> the field of MjSpec that holds it, where the two names differ; else they are the same.
_FIELDS = {
    "actuatorfrcrange": "actfrcrange",
    "solreflimit": "solref_limit",
    "solimplimit": "solimp_limit",
    "solreffriction": "solref_friction",
    "solimpfriction": "solimp_friction",
    "fluidcoef": "fluid_coefs",
}
_ATTRIBUTES = {
    "joint": "pos axis range ref springref springdamper damping stiffness armature frictionloss margin actuatorfrcrange"
    " solreflimit solimplimit solreffriction solimpfriction",
    "actuator": "kp kv gear ctrlrange forcerange actrange lengthrange gainprm biasprm dynprm cranklength damping"
    " armature",
    "geom": "pos quat fromto size mass density friction margin gap solref solimp solmix fluidcoef",
    "body": "mass pos quat gravcomp",
    "site": "pos quat fromto size",
    "sensor": "cutoff noise",
    "option": "timestep gravity wind magnetic density viscosity impratio tolerance iterations ls_iterations"
    " noslip_iterations o_margin o_solref o_solimp o_friction",
}
# Fewer numbers than the field holds are as good as all of them, as in the XML; the others need them all.
_MAY_BE_SHORTER = ("damping", "stiffness", "gear", "size", "friction", "gainprm", "biasprm", "dynprm", "fluidcoef")
_MAY_BE_SHORTER += ("solref", "solimp", "solreflimit", "solimplimit", "solreffriction", "solimpfriction", "noise")

# (law of the actuator, shortcut) -> (field, index, sign) of what it stands for in the XML.
_GAINS = {
    ("position", "kp"): (("gainprm", 0, 1.0), ("biasprm", 1, -1.0)),
    ("position", "kv"): (("biasprm", 2, -1.0),),
    ("pid", "kp"): (("biasprm", 1, -1.0),),
    ("pid", "kv"): (("biasprm", 2, -1.0),),
    ("velocity", "kv"): (("gainprm", 0, 1.0), ("biasprm", 2, -1.0)),
    ("damper", "kv"): (("gainprm", 2, -1.0),),
}
_LAWS = {
    mujoco.mjtActuator.mjACTUATOR_POSITION: "position",
    mujoco.mjtActuator.mjACTUATOR_INTVELOCITY: "position",
    mujoco.mjtActuator.mjACTUATOR_ORIENTATION: "position",
    mujoco.mjtActuator.mjACTUATOR_PID: "pid",
    mujoco.mjtActuator.mjACTUATOR_VELOCITY: "velocity",
    mujoco.mjtActuator.mjACTUATOR_DAMPER: "damper",
}


def apply_settings(robot: Robot, settings: Mapping[str, Any], *, where: str = "set") -> Robot:
    """The robot as it was in a recording, recompiled from a copy of its description.

    Keys are `<element>.<name>.<attribute>` as in MJCF, split at the first and the last dot, or `option.<attribute>`;
    values are numbers, or lists where MJCF has lists, in the MJCF file's own units (degrees where its compiler says
    so). Of a list that may be shorter in MJCF, values left out stay as they are. `kp` and `kv` change gain and bias, as
    in the XML. `body.<name>.mass` scales the body's inertia with its mass.

    Args:
        robot: unchanged.
        settings: what differs; empty gives `robot` itself.
        where: the place of the settings, for messages.

    Raises:
        InputError: an unknown element, name or attribute, with what exists; a value that does not fit; or a robot that
            no longer compiles.
    """
    if not settings:
        return robot
    spec = robot.spec.copy()
    masses: dict[int, float] = {}
    for key, value in settings.items():
        place = f"{where}, '{key}'"
        element, name, attribute = _split(key, place)
        if (element, attribute) == ("body", "mass"):
            masses[_index(robot, element, name, place)] = _positive(value, place)
            continue
        target = spec.option if element == "option" else _element(robot, spec, element, name, place)
        _assign(target, element, attribute, value, place)
    changed = _compiled(spec, robot.source, where)
    if not masses:
        return changed
    _scale_masses(spec, changed, masses, where)
    return _compiled(spec, robot.source, where)


def _split(key: str, place: str) -> tuple[str, str, str]:
    element, dot, rest = key.partition(".")
    if element not in _ATTRIBUTES:
        raise InputError(f"unknown element '{element}'", where=place, right=known(_ATTRIBUTES))
    name, last_dot, attribute = ("", ".", rest) if element == "option" else rest.rpartition(".")
    if not (dot and last_dot and attribute):
        right = "option.<attribute>" if element == "option" else f"{element}.<name>.<attribute>"
        raise InputError("is not a setting", where=place, right=right)
    if attribute not in _ATTRIBUTES[element].split():
        right = known(_ATTRIBUTES[element].split())
        raise InputError(f"unknown attribute '{attribute}' of {element}", where=place, right=right)
    return element, name, attribute


def _index(robot: Robot, element: str, name: str, place: str) -> int:
    try:
        index = robot.index(element, name)
    except InputError as error:
        raise InputError(error.what, where=place, right=error.right) from None
    if element == "body" and index == 0:
        raise InputError("the world cannot be set", where=place, right=known(robot.names("body")[1:]))
    return index


def _element(robot: Robot, spec: mujoco.MjSpec, element: str, name: str, place: str) -> Any:
    # Not by name: unnamed elements have one only with us. A copy keeps the indices of the compiled original.
    index = _index(robot, element, name, place)
    listed = {"joint": spec.joints, "actuator": spec.actuators, "geom": spec.geoms, "body": spec.bodies}
    listed |= {"site": spec.sites, "sensor": spec.sensors}
    return next(item for item in listed[element] if item.id == index)


def _positive(value: object, place: str) -> float:
    checked = parse_number(value, place)
    if checked <= 0.0:
        raise InputError(f"is {checked!r}, not above zero", where=place)
    return checked


def _assign(target: Any, element: str, attribute: str, value: Any, place: str) -> None:
    if attribute in ("kp", "kv"):
        return _assign_gain(target, attribute, parse_number(value, place), place)
    if attribute in ("pos", "quat") and element in ("geom", "site") and np.isfinite(target.fromto[0]):
        raise InputError("the MJCF places it with fromto", where=place, right="set fromto instead")
    field = _FIELDS.get(attribute, attribute)
    old = getattr(target, field)
    if isinstance(old, np.ndarray):
        _assign_list(old, attribute, value, place)
    elif isinstance(old, int):
        checked = parse_number(value, place)
        if checked < 0.0 or not checked.is_integer():
            raise InputError(f"is {value!r}, not a whole number", where=place)
        setattr(target, field, int(checked))
    else:
        setattr(target, field, _positive(value, place) if attribute == "timestep" else parse_number(value, place))
    if attribute == "quat":  # a rotation given in another way in the XML would win
        target.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def _assign_list(old: np.ndarray, attribute: str, value: object, place: str) -> None:
    """Write into a view of the description."""
    values = list(value) if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str) else [value]
    numbers = [parse_number(v, place) for v in values]
    fits = 1 <= len(numbers) <= len(old) if attribute in _MAY_BE_SHORTER else len(numbers) == len(old)
    if not fits:
        at_most = "at most " if attribute in _MAY_BE_SHORTER else ""
        raise InputError(f"has {len(numbers)} numbers", where=place, right=f"{at_most}{len(old)} numbers")
    if attribute.endswith("range") and any(numbers) and numbers[0] >= numbers[1]:
        # MuJoCo would take it for no limit at all.
        raise InputError(f"is {numbers}, not low to high", where=place, right="low below high; 0 0 for no limit")
    old[: len(numbers)] = numbers


def _assign_gain(actuator: Any, attribute: str, value: float, place: str) -> None:
    law = _LAWS.get(actuator.type) or _law_of_general(actuator)
    if (law, attribute) not in _GAINS:
        right = "gainprm and biasprm can be set instead" if law != "velocity" else "a velocity actuator has kv"
        raise InputError(f"this actuator has no {attribute}", where=place, right=right)
    for field, index, sign in _GAINS[law, attribute]:
        getattr(actuator, field)[index] = sign * value


def _law_of_general(actuator: Any) -> str:
    """A `general` actuator that is written as a servo is one: MuJoCo saves them so."""
    if (actuator.gaintype, actuator.biastype) != (mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE):
        return "general"
    if actuator.gainprm[0] == -actuator.biasprm[1]:
        return "position"
    return "velocity" if actuator.gainprm[0] == -actuator.biasprm[2] and actuator.biasprm[1] == 0.0 else "general"


def _compiled(spec: mujoco.MjSpec, source: str, where: str) -> Robot:
    try:
        return Robot.from_spec(spec, source)
    except (ValueError, mujoco.FatalError) as error:
        message = " ".join(str(error).split()).removeprefix("Error: ")
        raise InputError(f"with these settings the MJCF does not compile: {message}", where=where) from None


def _scale_masses(spec: mujoco.MjSpec, robot: Robot, masses: Mapping[int, float], where: str) -> None:
    """Give bodies other masses, the inertia in proportion.

    Every body's inertia is written down as compiled first, whether it was explicit or came from geoms: the compiler's
    own ways to arrive at it (inertiafromgeom, settotalmass) would otherwise act a second time, on scaled values.
    """
    model = robot.model
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.compiler.settotalmass = -1.0
    for body in spec.bodies[1:]:
        index = body.id
        old = float(model.body_mass[index])
        if index in masses and old == 0.0:
            place = f"{where}, 'body.{robot.names('body')[index]}.mass'"
            raise InputError("has no mass in the MJCF, so no inertia to scale", where=place)
        if old == 0.0:
            continue
        scale = masses[index] / old if index in masses else 1.0
        body.explicitinertial = True
        body.mass, body.inertia = masses.get(index, old), scale * model.body_inertia[index]
        body.ipos, body.iquat = model.body_ipos[index], model.body_iquat[index]
        body.fullinertia = [np.nan, 0.0, 0.0, 0.0, 0.0, 0.0]
        body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
