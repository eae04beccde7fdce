"""The robots of the concealed recordings: their nominal MJCF, which joints are driven, how they are moved."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import mujoco
import numpy as np

_FOLDER = Path(__file__).parent / "mjcf"


@dataclass(frozen=True)
class Robot:
    """A robot and how it is made to move.

    Attributes:
        name: of its MJCF file.
        reach: amplitude of the motion of each scalar joint, rad or m, at full amplitude.
        style: what commands mean: `servo` (positions), `torque` (open loop and feedback), `cart`, `gait`, `mixed`.
        rates: rows a second it may be logged with.
        seconds: length of a recording at 200 Hz; at 50 Hz it is 1.5 times as long.
        by_hand: whether its equations of motion are also written out, in `equations`.
        sealed_only: kept for sealed sets, so that nothing is developed on it.
    """

    name: str
    reach: tuple[float, ...]
    style: str
    rates: tuple[int, ...] = (200, 50)
    seconds: float = 8.0
    by_hand: bool = False
    sealed_only: bool = False

    @property
    def xml(self) -> str:
        """The nominal MJCF."""
        return (_FOLDER / f"{self.name}.xml").read_text(encoding="utf-8")

    @property
    def model(self) -> mujoco.MjModel:
        """A fresh compiled nominal model."""
        return mujoco.MjModel.from_xml_string(self.xml)

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the hinge and slide joints, in the model's order."""
        return layout(self.name).joints


@dataclass(frozen=True)
class Layout:
    """Where things are in a model.

    Attributes:
        joints: names of the scalar joints; `q` and `v` are their addresses, `body` the bodies they move.
        actuators: names of the actuators, `drives` the index of the scalar joint each one drives.
        free: whether there is a free joint (it comes first).
    """

    joints: tuple[str, ...]
    q: np.ndarray
    v: np.ndarray
    body: tuple[str, ...]
    actuators: tuple[str, ...]
    drives: tuple[int, ...]
    free: bool


ROBOTS = {
    r.name: r
    for r in (
        Robot("leg", (0.5, 0.7, 0.8), "servo"),
        Robot("planar", (0.9, 0.9), "torque", by_hand=True),
        Robot("arm6", (0.7, 0.5, 0.6, 0.8, 0.7, 0.9), "servo", rates=(50, 200), seconds=9.0),
        Robot("cartpole", (0.35, 0.8), "cart", by_hand=True),
        Robot("quadruped", (0.35, 0.5) * 4, "gait", rates=(200,), seconds=5.0),
        Robot("scara", (0.8, 0.8, 0.06), "mixed", sealed_only=True),
    )
}
"""All robots by name."""


@cache
def layout(name: str) -> Layout:
    """Where things are in a robot's model."""
    model = ROBOTS[name].model
    kinds = {int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)}
    scalar = [j for j in range(model.njnt) if int(model.jnt_type[j]) in kinds]
    order = {j: i for i, j in enumerate(scalar)}
    return Layout(
        joints=tuple(model.joint(j).name for j in scalar),
        q=model.jnt_qposadr[scalar],
        v=model.jnt_dofadr[scalar],
        body=tuple(model.body(model.jnt_bodyid[j]).name for j in scalar),
        actuators=tuple(model.actuator(a).name for a in range(model.nu)),
        drives=tuple(order[int(model.actuator_trnid[a, 0])] for a in range(model.nu)),
        free=len(scalar) < model.njnt,
    )


def home(model: mujoco.MjModel) -> np.ndarray:
    """The configuration a robot starts from: its first keyframe, else its reference."""
    return np.array(model.key_qpos[0] if model.nkey else model.qpos0)


def mass_diagonal(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Diagonal (nv,) of the mass matrix, armature included, at a state that was computed forward."""
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return np.diag(full).copy()


def perturb(model: mujoco.MjModel, deviation: float, rng: np.random.Generator) -> None:
    """Put an ordinary error into every mass (with its inertia), damping, friction, armature and gain, in place.

    Each is multiplied by 1 + e, e normal of the given deviation and cut off at 2.5 of them. A motor's strength is one
    gain (kp and the torque limit), a servo's kv another.
    """

    def factors(n: int) -> np.ndarray:
        return 1.0 + deviation * np.clip(rng.standard_normal(n), -2.5, 2.5)

    mass = factors(model.nbody)
    model.body_mass[:] *= mass
    model.body_inertia[:] *= mass[:, None]
    for field in (model.dof_damping, model.dof_frictionloss, model.dof_armature):
        field[:] *= factors(model.nv)
    stiff, slow = factors(model.nu), factors(model.nu)
    servo = model.actuator_biasprm[:, 1] != 0.0
    model.actuator_gainprm[:, 0] *= stiff
    model.actuator_biasprm[:, 1] *= np.where(servo, stiff, 1.0)
    model.actuator_biasprm[:, 2] *= slow
    model.actuator_forcerange[:] *= stiff[:, None]


def misjudge(model: mujoco.MjModel, most: float, rng: np.random.Generator) -> dict[str, float]:
    """Make some masses, dampings and gains wrong by up to a share, in place; gives the relative errors."""
    errors: dict[str, float] = {}

    def draw(kind: str, names: list[str], apply) -> None:
        for i in rng.permutation(len(names))[: rng.integers(1, 3)]:
            error = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.4, 1.0) * most)
            apply(int(i), 1.0 + error)
            errors[f"{kind}.{names[int(i)]}"] = error

    def mass(i: int, factor: float) -> None:
        model.body_mass[i + 1] *= factor
        model.body_inertia[i + 1] *= factor

    def damping(i: int, factor: float) -> None:
        model.dof_damping[moved[i]] *= factor

    def gain(i: int, factor: float) -> None:
        model.actuator_gainprm[i, 0] *= factor
        model.actuator_biasprm[i, 1:3] *= factor
        model.actuator_forcerange[i] *= factor

    moved = np.flatnonzero(model.dof_damping > 0.0)
    draw("mass", [model.body(b).name for b in range(1, model.nbody)], mass)
    draw("damping", [model.joint(int(model.dof_jntid[v])).name for v in moved], damping)
    draw("gain", [model.actuator(a).name for a in range(model.nu)], gain)
    return errors
