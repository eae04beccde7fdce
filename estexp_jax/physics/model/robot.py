"""A robot: a compiled MJCF model, and its elements by name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.errors import InputError, known
from estexp_jax.physics.model.files import is_file, read_description
from estexp_jax.physics.model.log_channels import LogChannel, log_channels
from estexp_jax.physics.model.portable import precise_xml
from estexp_jax.physics.model.spec import freeze, set_timestep, spec_elements, with_masses, with_names
from estexp_jax.physics.model.validation import refuse_invalid, refuse_unbounded, warnings_suppressed

_TYPES = {
    "body": mujoco.mjtObj.mjOBJ_BODY,
    "joint": mujoco.mjtObj.mjOBJ_JOINT,
    "geom": mujoco.mjtObj.mjOBJ_GEOM,
    "site": mujoco.mjtObj.mjOBJ_SITE,
    "actuator": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "sensor": mujoco.mjtObj.mjOBJ_SENSOR,
}
_FAILURES = (ValueError, RuntimeError, mujoco.FatalError)
_COUNTS = {
    "body": "nbody",
    "joint": "njnt",
    "geom": "ngeom",
    "site": "nsite",
    "actuator": "nactuator",
    "sensor": "nsensor",
}


@final
@dataclass(frozen=True, eq=False)
class Robot:
    """A robot as its MJCF or URDF describes it.

    Attributes:
        spec: the description, every element named; copied before every change, never changed in place.
        model: `spec` compiled; read only.
        source: where the MJCF came from, for messages.
    """

    spec: mujoco.MjSpec = field(repr=False)
    model: mujoco.MjModel = field(repr=False)
    source: str = "MJCF"

    def __reduce__(self) -> tuple[Any, ...]:
        """As text and compiled model: descriptions cannot be pickled."""
        return unpickled_robot, (precise_xml(self.spec.copy()), self.model, self.source)

    @classmethod
    def from_xml(cls, path: str | Path, root: str | Path | None = None) -> Robot:
        """Compile the MJCF or URDF at `path`; meshes and whatever else it refers to are read from under its root.

        Args:
            path: of the model.
            root: the folder that its files have to be under; None: the repository or package around it, else three
                folders up.

        Raises:
            InputError: there is no such file, it refers to what is not there or leads out of its root, or it does not
                compile.
        """
        path = Path(path)
        if not is_file(path):
            right = "give the path of a MuJoCo XML model or a URDF"
            raise InputError("no such MJCF file", where=str(path), right=right)
        try:
            with warnings_suppressed():
                return cls.from_spec(read_description(path, None if root is None else Path(root)), str(path))
        except _FAILURES as error:
            raise InputError(f"the MJCF does not compile: {_one_line(error)}", where=str(path)) from None

    @classmethod
    def from_string(cls, xml: str, source: str = "MJCF") -> Robot:
        """Compile MJCF text.

        Raises:
            InputError: the text does not compile.
        """
        try:
            with warnings_suppressed():
                return cls.from_spec(mujoco.MjSpec.from_string(xml), source)
        except _FAILURES as error:
            raise InputError(f"the MJCF does not compile: {_one_line(error)}", where=source) from None

    @classmethod
    def from_spec(cls, spec: mujoco.MjSpec, source: str = "MJCF") -> Robot:
        """Compile a description that was built or changed in memory.

        Raises:
            InputError: it claims more than any robot has, or holds what is no number.
        """
        refuse_unbounded(spec, source)
        model = spec.compile()
        refuse_invalid(model, source)
        return cls(with_masses(with_names(spec), model), model, source)

    def names(self, kind: str) -> tuple[str, ...]:
        """Names of all elements of a kind, in MuJoCo's order; unnamed ones are `<kind>_<index>`.

        Args:
            kind: body, joint, geom, site, actuator or sensor. The world is left out of the bodies'
                *choices* (see `index`), not out of this list. Or channel: those of `channels`.
        """
        return tuple(self.channels) if kind == "channel" else self._names[kind]

    def index(self, kind: str, name: str) -> int:
        """MuJoCo's index of a named element.

        Raises:
            InputError: no such element; the message lists those that exist.
        """
        names = self.names(kind)
        if name not in names:
            choices = names[1:] if kind == "body" else names
            raise InputError(f"there is no {kind} '{name}'", where=self.source, right=known(choices))
        return names.index(name)

    @cached_property
    def _names(self) -> dict[str, tuple[str, ...]]:
        model = self.model
        return {
            kind: tuple(
                mujoco.mj_id2name(model, _TYPES[kind], i) or f"{kind}_{i}" for i in range(getattr(model, _COUNTS[kind]))
            )
            for kind in _TYPES
        }

    @cached_property
    def channels(self) -> dict[str, LogChannel]:
        """What a log of it has one number a row of, by name."""
        return log_channels(self.model, self._names)

    @cached_property
    def scalar_joints(self) -> tuple[int, ...]:
        """Indices of the hinge and slide joints: those with one coordinate and one speed."""
        kinds = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
        return tuple(i for i in range(self.model.njnt) if int(self.model.jnt_type[i]) in kinds)

    @property
    def remedy(self) -> str:
        """Advice for a robot without actuators; empty for others."""
        if self.model.nactuator:
            return ""
        return f"`estexp check {self.source} --init` writes an MJCF of it with servos and sensors, a URDF has none"

    def joint_of_actuator(self, actuator: int) -> int | None:
        """Index of the joint an actuator drives directly, or None for any other transmission."""
        if self.model.actuator_trntype[actuator] != mujoco.mjtTrn.mjTRN_JOINT:
            return None
        return int(self.model.actuator_trnid[actuator, 0])

    def body_of_sensor(self, sensor: int) -> int | None:
        """Index of the body a sensor sits on, or None where it sits on none."""
        model, types = self.model, mujoco.mjtObj
        target = int(model.sensor_objid[sensor])
        match types(int(model.sensor_objtype[sensor])):
            case types.mjOBJ_JOINT:
                return int(model.jnt_bodyid[target])
            case types.mjOBJ_SITE:
                return int(model.site_bodyid[target])
            case types.mjOBJ_GEOM:
                return int(model.geom_bodyid[target])
            case types.mjOBJ_BODY | types.mjOBJ_XBODY:
                return target
            case types.mjOBJ_ACTUATOR:
                joint = self.joint_of_actuator(target)
                return None if joint is None else int(model.jnt_bodyid[joint])
            case _:
                return None

    def command_columns(self) -> tuple[str, ...]:
        """One name per value of `ctrl`: `<actuator>`, or `<actuator>.0 .1 ...` where it has several inputs."""
        columns: list[str] = []
        for name, inputs in zip(self.names("actuator"), self.model.actuator_ctrlnum, strict=True):
            columns += [name] if inputs == 1 else [f"{name}.{k}" for k in range(inputs)]
        return tuple(columns)

    def sensor_columns(self) -> tuple[str, ...]:
        """One name per value of `sensordata`: `<sensor>`, or `<sensor>.0 .1 ...` where it has several values."""
        columns: list[str] = []
        for name, dim in zip(self.names("sensor"), self.model.sensor_dim, strict=True):
            columns += [name] if dim == 1 else [f"{name}.{k}" for k in range(dim)]
        return tuple(columns)

    def subtree(self, body: int) -> tuple[int, ...]:
        """Indices of a body and everything that hangs from it."""
        inside = {body}
        for child in range(body + 1, self.model.nbody):
            if int(self.model.body_parentid[child]) in inside:
                inside.add(child)
        return tuple(sorted(inside))

    def floats(self, body: int) -> bool:
        """Whether a body belongs to a tree that nothing holds: its first joint is free."""
        model, first = self.model, int(self.model.body_rootid[body])
        adr = int(model.body_jntadr[first])
        return adr >= 0 and int(model.jnt_type[adr]) == int(mujoco.mjtJoint.mjJNT_FREE)

    def without_contacts(self, bodies: Iterable[tuple[int, int]]) -> Robot:
        """The robot without contacts between some pairs of its bodies; itself where there is none."""
        spec, names, changed = self.spec.copy(), self.names("body"), False
        for one, other in bodies:
            spec.add_exclude(bodyname1=names[one], bodyname2=names[other])
            changed = True
        return Robot.from_spec(spec, self.source) if changed else self

    def finer(self, parts: float) -> Robot:
        """The robot with a physics step that is a part of its own."""
        spec = self.spec.copy()
        set_timestep(spec, spec.option.timestep / parts)
        return Robot.from_spec(spec, self.source)

    def home(self) -> np.ndarray:
        """The configuration to start from, (nq,): keyframe `home`, else the first keyframe, else qpos0."""
        model = self.model
        key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "home")
        return model.key_qpos[max(key, 0)].copy() if model.nkey else model.qpos0.copy()


def unpickled_robot(xml: str, model: mujoco.MjModel, source: str) -> Robot:
    """A robot that was pickled; files that it refers to are read anew where they were."""
    return Robot(mujoco.MjSpec.from_string(xml), model, source)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()).removeprefix("Error: ")


def spec_element(spec: mujoco.MjSpec, robot: Robot, kind: str, name: str) -> Any:
    """The element of a copy of a robot's description that carries this name, to be changed; see `freeze`.

    Raises:
        InputError: the robot has no such element, or it was deleted from the copy.
    """
    robot.index(kind, name)
    freeze(spec, robot.model, robot.index)
    for element in spec_elements(spec)[kind]:
        if element.name == name:
            return element
    raise InputError(f"the {kind} '{name}' is no longer there", where=robot.source, right="change it before its part")
