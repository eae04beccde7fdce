"""The real arm: MuJoCo's C engine at a tenth of the step, with wrong values, effects and a flaw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from experiments.explain.several.arms import RATE, STEP, Arm
from experiments.explain.several.effects import ArmEffect
from experiments.explain.several.flaws import Flaw, soften

FINER = 10
ERROR = 0.03
"""Relative error of every mass, rotor inertia, gain and damping, up or down."""
_HARD = (2.5 * STEP / FINER, 1.0)
"""Time constant and damping ratio of friction at rest: MuJoCo's default lets a joint creep."""
_PER_ROW = round(FINER / (RATE * STEP))


@final
@dataclass(frozen=True, eq=False)
class Run:
    """What a real arm did, a row a time.

    Attributes:
        command: (rows, joints), as it was logged.
        position, speed: (rows, joints) before the row's command acts.
        state: (rows, nq + nv) of everything, the mount included.
        reading: (rows, joints) true positions with the sensors' biases.
    """

    command: np.ndarray
    position: np.ndarray
    speed: np.ndarray
    state: np.ndarray
    reading: np.ndarray


@final
class RealArm:
    """A real arm, which can be started anywhere and stepped from row to row."""

    def __init__(self, arm: Arm, effects: Sequence[ArmEffect], flaw: Flaw, signs: np.ndarray) -> None:
        """Of a nominal arm.

        Args:
            arm: the nominal one.
            effects: what it has besides.
            flaw: what is wrong besides; `Flaw()`: nothing.
            signs: (5, joints) of +1 and -1: which way masses, rotors, gains, servos' dampings, frictions are off.
        """
        spec = mujoco.MjSpec.from_string(arm.xml)
        soften(spec, flaw)
        spec.option.timestep = STEP / FINER
        self.model, self.arm, self.flaw, n = spec.compile(), arm, flaw, arm.joints
        self.q = np.array([self.model.joint(f"j{j + 1}").qposadr[0] for j in range(n)])
        self.v = np.array([self.model.joint(f"j{j + 1}").dofadr[0] for j in range(n)])
        self.values = {name: np.zeros(n) for name in ("T", "S", "mu", "push", "delay", "bias")}
        self.values["w_s"] = np.ones(n)
        self._spoil(1.0 + ERROR * signs)
        for effect in effects:
            self._add(effect)
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))
        self.data = mujoco.MjData(self.model)
        self.known = self.model.dof_frictionloss[self.v].copy()
        self.geared = self.model.dof_armature[self.v].copy()
        self.varies = any(self.values[name].any() for name in ("S", "mu", "delay")) or flaw.depth > 0.0

    def _spoil(self, factors: np.ndarray) -> None:
        m, links = self.model, self._links()
        m.body_mass[links] *= factors[0]
        m.body_inertia[links] *= factors[0][:, None]
        m.dof_armature[self.v] *= factors[1]
        m.actuator_gainprm[:, 0] *= factors[2]
        m.actuator_biasprm[:, 1] *= factors[2]
        m.actuator_biasprm[:, 2] *= factors[3]
        m.dof_frictionloss[self.v] *= factors[4]
        m.dof_solref[self.v] = _HARD

    def _links(self) -> np.ndarray:
        return np.array([self.model.body(f"link{j + 1}").id for j in range(self.arm.joints)])

    def _add(self, effect: ArmEffect) -> None:
        m, j, p, v = self.model, effect.joint, effect.parameters, self.v[effect.joint]
        if effect.effect == "viscous_friction":
            m.dof_damping[v] += p["c"]
        elif effect.effect == "armature":
            m.dof_armature[v] += p["I"]
        elif effect.effect == "joint_stiffness":
            joint = m.dof_jntid[v]
            m.jnt_stiffness[joint], m.qpos_spring[self.q[j]] = p["k"], p["q0"]
        elif effect.effect == "motor_weakness":
            for table in (m.actuator_gainprm, m.actuator_biasprm, m.actuator_forcerange):
                table[j] *= 1.0 - p["loss"]
        elif effect.effect == "body_mass":
            body = self._links()[j]
            factor = 1.0 + p["dm"] / m.body_mass[body]
            m.body_mass[body] *= factor
            m.body_inertia[body] *= factor
        elif effect.effect == "torque_offset":
            self.values["push"][j] = p["T"]
        else:
            for name, value in p.items():
                self.values[name][j] = value
        if "T" in p and effect.effect != "torque_offset":
            m.dof_frictionloss[v] += p["T"]

    def begin(self, position: np.ndarray, speed: np.ndarray, mount: np.ndarray) -> None:
        """Start at positions and speeds (joints,) of the joints and, where it has one, the mount's (4,)."""
        mujoco.mj_resetData(self.model, self.data)
        if self.flaw.mount and len(mount):
            self.data.qpos[:2], self.data.qvel[:2] = mount[:2], mount[2:]
        self.data.qpos[self.q], self.data.qvel[self.v] = position, speed
        self.data.qfrc_applied[self.v] = self.values["push"]
        mujoco.mj_forward(self.model, self.data)

    def reading(self) -> np.ndarray:
        """(joints,) what its sensors say, without noise."""
        return self.data.qpos[self.q] + self.values["bias"]

    def mount(self) -> np.ndarray:
        """(4,) angles and speeds of the mount; (0,) where it is rigid."""
        return np.concatenate([self.data.qpos[:2], self.data.qvel[:2]]) if self.flaw.mount else np.zeros(0)

    def row(self, commands: np.ndarray, k: int) -> None:
        """Go on by a row.

        Args:
            commands: (rows, joints), of which the rows up to k are known.
            k: the row that begins.
        """
        d = self.data
        d.ctrl[:] = commands[k]
        if not self.varies:
            mujoco.mj_step(self.model, d, _PER_ROW)
            return
        late = np.flatnonzero(self.values["delay"])
        for step in range(_PER_ROW):
            for j in late:
                then = k + step / _PER_ROW - self.values["delay"][j] * RATE
                d.ctrl[j] = commands[max(int(np.floor(then)), 0), j]
            self._vary()
            mujoco.mj_step(self.model, d)

    def _vary(self) -> None:
        d, x, flaw, j = self.data, self.values, self.flaw, self.flaw.joint
        w = d.qvel[self.v]
        friction = self.known + x["S"] * np.exp(-((w / x["w_s"]) ** 2)) + x["mu"] * np.abs(d.actuator_force)
        if j is not None and flaw.inertia:
            more, torque = flaw.rotor(float(d.qpos[self.q[j]]), float(w[j]))
            self.model.dof_armature[self.v[j]] = self.geared[j] + more
            d.qfrc_applied[self.v[j]] = x["push"][j] + torque
        elif j is not None:
            friction[j] += self.arm.model.dof_frictionloss[j] * flaw.friction(d.qpos[self.q[j]])
        self.model.dof_frictionloss[self.v] = friction
