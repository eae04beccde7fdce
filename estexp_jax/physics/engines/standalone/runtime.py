"""How laws act over plain MuJoCo: the part of every `explained.py` that is the same, copied into it word for word.

It imports MuJoCo and NumPy alone. Numbers of one robot are scalars, those of a `mujoco.batch.Batch` arrays (lanes,).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np


class LawPlace(NamedTuple):
    """Where a law acts, and its where_of there."""

    p: tuple[float, ...]  #: parameters
    joint: str = ""
    motors: tuple[str, ...] = ()  #: those that count there
    whole: bool = False  #: whether they are all of the joint, so that the joint's own limit counts
    limit: float = 0.0  #: largest torque of the motors in the model
    body: str = ""
    native: bool = False  #: whether model_explained.xml holds it by itself


class Law(NamedTuple):
    """A law, and where it acts."""

    kind: str  #: command, joint or body
    act: Callable[..., Any]
    rest: Callable[..., Any] | None  #: hidden variables of what has been where it is for long; None: it has none
    places: tuple[LawPlace, ...]


class Assignment(NamedTuple):
    """A value of the model that is another: x -> op(x, value)."""

    field: str
    kind: str  #: of the element
    name: str
    part: tuple[int, ...]  #: within the element
    op: str  #: add, scale or set
    value: float
    native: bool = False


class Reading(NamedTuple):
    """A reading that is faulty: gain * true + bias, `delay` s late, drifting by so much a second."""

    sensor: str
    part: int = 0
    gain: float = 1.0
    bias: float = 0.0
    delay: float = 0.0
    drift: float = 0.0
    native: bool = False


class DisplayedVariable(NamedTuple):
    """A hidden variable that a sensor shows: added, times `factor`."""

    sensor: str
    part: int
    law: int
    place: int
    state: int
    factor: float


class DelayedCommand(NamedTuple):
    """A command that comes late, or is another's."""

    motor: str
    part: int = 0
    delay: float = 0.0
    source: str = ""
    source_part: int = 0
    native: bool = False


@dataclass(frozen=True)
class Found:
    """All that was found."""

    laws: tuple[Law, ...] = ()
    edits: tuple[Assignment, ...] = ()
    delayed: tuple[DelayedCommand, ...] = ()
    readings: tuple[Reading, ...] = ()
    displayed: tuple[DisplayedVariable, ...] = ()
    substeps: int = 1  #: in a step of the nominal model
    joints: tuple[str, ...] = ()  #: of the nominal model, to whose order parameters refer
    motors: tuple[tuple[str, str], ...] = ()  #: all that drive a joint, and the joint
    file_differs: tuple[str, tuple[int, ...], float] | None = None  #: field, index, value that only the file has

    def over(self, model: mujoco.MjModel) -> Found:
        """What is to be added to a model: to `model_explained.xml`, what that lacks, at its own step; to others all."""
        if self.file_differs is None:
            return self
        name, index, value = self.file_differs
        array = np.asarray(getattr(model, name))
        is_there = all(i < n for i, n in zip(index, array.shape, strict=False))
        if not is_there or not np.isclose(array[index], value, rtol=1e-9, atol=0.0):
            return self
        laws = tuple(law._replace(places=tuple(p for p in law.places if not p.native)) for law in self.laws)
        return Found(
            laws,
            tuple(x for x in self.edits if not x.native),
            tuple(x for x in self.delayed if not x.native),
            tuple(x for x in self.readings if not x.native),
            tuple(s for s in self.displayed if not self.laws[s.law].places[s.place].native),
            1,
            self.joints,
            self.motors,
        )


_KINDS = {
    "joint": mujoco.mjtObj.mjOBJ_JOINT,
    "actuator": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "body": mujoco.mjtObj.mjOBJ_BODY,
    "sensor": mujoco.mjtObj.mjOBJ_SENSOR,
    "geom": mujoco.mjtObj.mjOBJ_GEOM,
    "tendon": mujoco.mjtObj.mjOBJ_TENDON,
}


def index_of(model: mujoco.MjModel, kind: str, name: str) -> int:
    """Index of an element; one without a name is called by its kind and number."""
    found = mujoco.mj_name2id(model, _KINDS[kind], name)
    return found if found >= 0 else int(name.rpartition("_")[2])


def address(model: mujoco.MjModel, edit: Assignment) -> tuple[int, ...]:
    """Where the number of an edit stands in its field."""
    if not edit.kind:
        return edit.part
    i = index_of(model, edit.kind, edit.name)
    firsts = {"dof": model.jnt_dofadr, "qpos": model.jnt_qposadr}
    by_input, by_output = ("actuator_ctrllimited", "actuator_ctrlrange"), ("actuator_gear",)
    if (prefix := edit.field.partition("_")[0].rstrip("0")) in firsts:
        return int(firsts[prefix][i]) + edit.part[0], *edit.part[1:]
    if edit.field in by_input:
        i = int(model.actuator_ctrladr[i])
    elif edit.field in by_output:
        i = int(model.actuator_outadr[i])
    return i, *edit.part


def edited(op: str, x: Any, value: float) -> Any:
    """A number of the model after an edit."""
    return {"add": x + value, "scale": x * value, "set": 0.0 * x + value}[op]


class Simulated:
    """Arrays of a model and its state, of one robot or of a batch with the lanes first."""

    def __init__(self, model: mujoco.MjModel, data: Any) -> None:
        self.model, self.data, self.batch = model, data, data if hasattr(data, "expand") else None
        names = ("qpos", "qvel", "ctrl", "qfrc_applied", "xfrc_applied", "sensordata") if self.batch is not None else ()
        self.bound: dict[str, np.ndarray] = {name: data.bind(name) for name in names}  # filled from the next step on

    def __getitem__(self, name: str) -> np.ndarray:
        """An array of the state."""
        if self.batch is None:
            return getattr(self.data, name)
        if name not in self.bound:
            self.bound[name] = self.batch.bind(name)
        return self.bound[name]

    def own(self, name: str) -> np.ndarray:
        """A field of the model, to be written."""
        return _field(self.model, name) if self.batch is None else self.batch.expand(name)

    def read(self, name: str) -> np.ndarray:
        """A field of the model."""
        expanded = None if self.batch is None else self.batch.expanded(name)
        return np.asarray(_field(self.model, name)) if expanded is None else expanded

    def edit(self, edits: tuple[Assignment, ...]) -> None:
        """Change values of the model, and what MuJoCo derives from them."""
        for e in edits:
            where = (..., *address(self.model, e))
            array = self.own(e.field)
            array[where] = edited(e.op, array[where], e.value)
        if edits and self.batch is not None:
            self.batch.set_const()
        elif edits:
            mujoco.mj_setConst(self.model, mujoco.MjData(self.model))

    def place(self, *names: str) -> list[np.ndarray]:
        """Arrays that say where bodies are, and what joints carry, computed for the present positions."""
        arrays = [self[name] for name in names]
        if self.batch is not None:
            self.batch.forward(stage=int(mujoco.mjtStage.mjSTAGE_POS))
        else:
            for compute in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_crb):
                compute(self.model, self.data)
        return [np.array(array) for array in arrays]

    def step(self) -> None:
        """One step of MuJoCo's own."""
        if self.batch is not None:
            self.batch.step()
        else:
            mujoco.mj_step(self.model, self.data)


def _field(model: mujoco.MjModel, name: str) -> Any:
    return getattr(model.opt, name[4:]) if name.startswith("opt.") else getattr(model, name)
