"""Apply the known differences of a recording to the robot's MJCF: `actuator.servo.kp = 1.77`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from estexp_jax.errors import InputError, known
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.spec import set_timestep
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
# These lists may be shorter than the field, as in the XML; all others need every value.
_MAY_BE_SHORTER = ("damping", "stiffness", "gear", "size", "friction", "gainprm", "biasprm", "dynprm", "fluidcoef")
_MAY_BE_SHORTER += ("solref", "solimp", "solreflimit", "solimplimit", "solreffriction", "solimpfriction", "noise")

# (law of the actuator, shortcut attribute) -> (field, index, sign) that the XML sets for it.
_GAINS = {
    ("position", "kp"): (("gainprm", 0, 1.0), ("biasprm", 1, -1.0)),
    ("position", "kv"): (("biasprm", 2, -1.0),),
    ("pid", "kp"): (("biasprm", 1, -1.0),),
    ("pid", "kv"): (("biasprm", 2, -1.0),),
    ("velocity", "kv"): (("gainprm", 0, 1.0), ("biasprm", 2, -1.0)),
    ("damper", "kv"): (("gainprm", 2, -1.0),),
}
# Law of each kind of actuator, by the end of its name in MuJoCo's enumeration; releases before 4 have none.
_LAWS = {
    "POSITION": "position",
    "INTVELOCITY": "position",
    "ORIENTATION": "position",
    "PID": "pid",
    "VELOCITY": "velocity",
    "DAMPER": "damper",
}


def apply_settings(robot: Robot, settings: Mapping[str, Any], *, where: str = "set") -> Robot:
    """The robot as it was in a recording, recompiled from a copy of its MJCF.

    Keys are `<element>.<name>.<attribute>` as in MJCF, split at the first and the last dot, or `option.<attribute>`;
    values are numbers, or lists where MJCF has lists, in the MJCF file's own units (degrees where its compiler says
    so). Where MJCF allows a shorter list, missing values are unchanged. `kp` and `kv` change gain and bias, as in the
    XML. `body.<name>.mass` scales the body's inertia with its mass.

    Args:
        robot: unchanged.
        settings: the differences; empty returns `robot` itself.
        where: origin of the settings, for messages.

    Raises:
        InputError: an element, name or attribute is unknown (lists those that exist), a value does not fit, or the
            robot no longer compiles.
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
        if (element, attribute) == ("option", "timestep"):
            set_timestep(spec, _positive(value, place))
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
    # By id, not by name: only this package names unnamed elements. A copy keeps the ids of the compiled original.
    index = _index(robot, element, name, place)
    elements = {"joint": spec.joints, "actuator": spec.actuators, "geom": spec.geoms, "body": spec.bodies}
    elements |= {"site": spec.sites, "sensor": spec.sensors}
    return next(item for item in elements[element] if item.id == index)


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
        setattr(target, field, parse_number(value, place))
    if attribute == "quat":  # otherwise another form of rotation in the XML would take precedence
        target.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def _assign_list(target: np.ndarray, attribute: str, value: object, place: str) -> None:
    """Write values into an array that is a view of the MJCF."""
    values = list(value) if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str) else [value]
    entries = [parse_number(v, place) for v in values]
    fits = 1 <= len(entries) <= len(target) if attribute in _MAY_BE_SHORTER else len(entries) == len(target)
    if not fits:
        at_most = "at most " if attribute in _MAY_BE_SHORTER else ""
        raise InputError(f"has {len(entries)} numbers", where=place, right=f"{at_most}{len(target)} numbers")
    if attribute.endswith("range") and any(entries) and entries[0] >= entries[1]:
        # MuJoCo would read it as no limit.
        raise InputError(f"is {entries}, not low to high", where=place, right="low below high; 0 0 for no limit")
    target[: len(entries)] = entries


def _assign_gain(actuator: Any, attribute: str, value: float, place: str) -> None:
    law = _law_of_shortcut(actuator) or _law_of_general(actuator)
    if (law, attribute) not in _GAINS:
        right = "gainprm and biasprm can be set instead" if law != "velocity" else "a velocity actuator has kv"
        raise InputError(f"this actuator has no {attribute}", where=place, right=right)
    for field, index, sign in _GAINS[law, attribute]:
        getattr(actuator, field)[index] = sign * value


def _law_of_shortcut(actuator: Any) -> str | None:
    """The law of an actuator that MJCF has an element for, such as `position`."""
    kinds = getattr(mujoco, "mjtActuator", None)
    return None if kinds is None else _LAWS.get(kinds(actuator.type).name.removeprefix("mjACTUATOR_"))


def _law_of_general(actuator: Any) -> str:
    """The law of a `general` actuator; MuJoCo saves servos in this form."""
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
    """Set the masses of bodies and scale their inertia in proportion.

    All bodies get explicit inertias as compiled. Otherwise the compiler's options (inertiafromgeom, settotalmass)
    would act a second time, on the scaled values.
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
