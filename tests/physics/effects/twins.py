"""Textbook laws in numpy on the C engine, at steps so small that how they are integrated no longer matters."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

# Two links: a servo with a force limit and rotor inertia, and a motor with a gear.
XML = """
<mujoco model="twin">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.0025"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" damping="0.05" armature="0.004"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.02" mass="0.6" contype="0" conaffinity="0"/>
      <body name="hand" pos="0 0 -0.25">
        <joint name="elbow" axis="0 1 0" damping="0.02" armature="0.002"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02" mass="0.2" contype="0" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="servo" joint="shoulder" kp="12" kv="0.3" forcerange="-4 4"/>
    <motor name="push" joint="elbow" gear="0.5" ctrlrange="-1 1"/>
  </actuator>
  <sensor><jointpos name="angle" joint="shoulder"/><jointpos name="bend" joint="elbow"/></sensor>
</mujoco>
"""
KP, KV, LIMIT, GEAR = 12.0, 0.3, 4.0, 0.5
ROTOR = 0.004

Values = Mapping[str, float]


class Twin:
    """A robot whose motors are computed here: the model's own are never used, only its joints and bodies.

    Args:
        values: parameters of the law.
    """

    def __init__(self, **values: float) -> None:
        self.v = values
        self.model = mujoco.MjModel.from_xml_string(XML)
        self.model.opt.iterations, self.model.opt.tolerance = 100, 1e-12
        self.data = mujoco.MjData(self.model)

    def servo(self, u: float, q: float, w: float) -> float:
        """Torque of the servo at a position and speed."""
        return float(np.clip(KP * (u - q) - KV * w, -LIMIT, LIMIT))

    def push(self, u: float) -> float:
        """Torque of the motor."""
        return GEAR * float(np.clip(u, -1.0, 1.0))

    def torques(self, u: np.ndarray, on: np.ndarray, dt: float) -> np.ndarray:
        """Torques of both motors on their joints, after the law."""
        q, w = self.data.qpos, self.data.qvel
        return on * [self.servo(u[0], q[0], w[0]), self.push(u[1])]

    def more(self, torques: np.ndarray, on: np.ndarray, dt: float) -> np.ndarray:
        """Further torques on the joints; may also change the model's friction."""
        return np.zeros(2)

    def step(self, u: np.ndarray, on: np.ndarray, dt: float) -> None:
        """One step."""
        torques = self.torques(u, on, dt)
        self.model.opt.timestep = dt
        self.data.ctrl[:] = 0.0
        self.data.qfrc_applied[:] = torques + self.more(torques, on, dt)
        mujoco.mj_step(self.model, self.data)


def _no_motors(twin: Twin) -> Twin:
    twin.model.actuator_gainprm[:], twin.model.actuator_biasprm[:] = 0.0, 0.0
    return twin


class Stribeck(Twin):
    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        w = self.data.qvel[0]
        self.model.dof_frictionloss[0] = self.v["T"] + self.v["S"] * np.exp(-((w / self.v["w_s"]) ** 2))
        return np.zeros(2)


class LoadFriction(Twin):
    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        self.model.dof_frictionloss[0] = self.v["mu"] * abs(torques[0])
        return np.zeros(2)


class Drag(Twin):
    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        w = self.data.qvel[0]
        return np.array([-self.v["c"] * abs(w) * w, 0.0])


class Offset(Twin):
    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        return np.array([0.0, self.v["T"]])


class Cogs(Twin):
    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        return np.array([0.0, self.v["A"] * np.sin(self.v["n"] * self.data.qpos[1] + self.v["phase"])])


class Dahl(Twin):
    force = 0.0

    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        w = self.data.qvel[1]
        self.force += dt * self.v["sigma"] * w * (1.0 - self.force / self.v["T"] * np.sign(w))
        return np.array([0.0, -self.force])


class Talk(Twin):
    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        return np.array([0.0, self.v["g"] * torques[0]])


class Brake(Twin):
    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        return np.array([0.0, -self.v["k"] * self.data.qvel[1] * on[1]])


class Fade(Twin):
    heat = 0.0

    def torques(self, u, on, dt):  # noqa: ANN001, ANN201
        strong = super().torques(u, on, dt)
        weak = strong * [1.0 - self.v["loss"] * self.heat, 1.0]
        self.heat += dt * ((strong[0] / LIMIT) ** 2 - self.heat) / self.v["tau"]
        return weak


class Spring(Twin):
    rotor: np.ndarray | None = None

    def torques(self, u, on, dt):  # noqa: ANN001, ANN201
        q, w = self.data.qpos[0], self.data.qvel[0]
        r, a = (q, w) if self.rotor is None else self.rotor
        passed = self.v["k"] * (r - q) + self.v["d"] * (a - w)
        a = a + dt * (on[0] * self.servo(u[0], r, a) - passed) / self.v["I"]
        self.rotor = np.array([r + dt * a, a])
        return np.array([passed, on[1] * self.push(u[1])])


class Play(Twin):
    """The rotor, no longer part of the joint, meets the ends of its play as hard, well damped springs."""

    rotor: np.ndarray | None = None

    def __init__(self, **values: float) -> None:
        super().__init__(**values)
        self.model.dof_armature[0] = 0.0

    def torques(self, u, on, dt):  # noqa: ANN001, ANN201
        q, w = self.data.qpos[0], self.data.qvel[0]
        r, a = (q, w) if self.rotor is None else self.rotor
        beyond = (r - q) - np.clip(r - q, -self.v["half_gap"], self.v["half_gap"])
        passed = 2e3 * beyond + 4.0 * (a - w) * (beyond != 0.0)
        passed = max(passed, 0.0) if beyond > 0.0 else min(passed, 0.0)
        a = a + dt * (on[0] * self.servo(u[0], r, a) - passed) / ROTOR
        self.rotor = np.array([r + dt * a, a])
        return np.array([passed, on[1] * self.push(u[1])])


class Lag(Twin):
    u: float | None = None

    def torques(self, u, on, dt):  # noqa: ANN001, ANN201
        self.u = u[0] if self.u is None else self.u + dt * (u[0] - self.u) / self.v["tau"]
        return super().torques(np.array([self.u, u[1]]), on, dt)


class ServoDead(Twin):
    def servo(self, u, q, w):  # noqa: ANN001, ANN201
        asked = u - q
        return super().servo(q + asked - np.clip(asked, -self.v["half_width"], self.v["half_width"]), q, w)


class MotorDead(Twin):
    def push(self, u):  # noqa: ANN001, ANN201
        u = np.clip(u, -1.0, 1.0)
        return GEAR * float(u - np.clip(u, -self.v["half_width"], self.v["half_width"]))


class Sag(Twin):
    def torques(self, u, on, dt):  # noqa: ANN001, ANN201
        strong = super().torques(u, on, dt)
        return strong * max(1.0 - self.v["R"] * np.abs(strong).sum(), 0.0)


class Profile(Twin):
    goal: float | None = None
    speed = 0.0

    def torques(self, u, on, dt):  # noqa: ANN001, ANN201
        left = 0.0 if self.goal is None else u[0] - self.goal
        wanted = np.sign(left) * min(self.v["v"], np.sqrt(2.0 * self.v["a"] * abs(left)))
        self.speed += np.clip(wanted - self.speed, -self.v["a"] * dt, self.v["a"] * dt)
        self.goal = u[0] if self.goal is None else self.goal + self.speed * dt
        return super().torques(np.array([self.goal, u[1]]), on, dt)


class Weightless(Twin):
    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        still = mujoco.MjData(self.model)
        still.qpos[:] = self.data.qpos
        mujoco.mj_forward(self.model, still)
        return self.v["share"] * on * still.qfrc_bias * [1.0, 0.0]


class Pull(Twin):
    def more(self, torques, on, dt):  # noqa: ANN001, ANN201
        self.data.xfrc_applied[2, :3] = [self.v[c] for c in "xyz"] - self.v["k"] * self.data.xipos[2]
        return np.zeros(2)


TWINS: dict[str, tuple[type[Twin], float]] = {
    "stribeck_friction@shoulder T=0.15 S=0.3 w_s=0.3": (Stribeck, 0.03),
    "load_dependent_friction@shoulder mu=0.4": (LoadFriction, 0.03),
    "quadratic_drag@shoulder c=0.2": (Drag, 0.03),
    "torque_offset@elbow T=0.15": (Offset, 0.03),
    "cogging@elbow A=0.2 n=8 phase=1": (Cogs, 0.03),
    "hysteresis@elbow T=0.2 sigma=3": (Dahl, 0.03),
    "crosstalk@elbow from=shoulder g=0.15": (Talk, 0.03),
    "back_emf@push k=0.1": (Brake, 0.03),
    "motor_fade@servo loss=0.9 tau=0.15": (Fade, 0.03),
    "joint_compliance@shoulder k=30 d=0.1 I=0.006": (Spring, 0.03),
    # The rotor hits an end inelastically; its twin, a spring of finite stiffness.
    "backlash@shoulder half_gap=0.05": (Play, 0.15),
    "actuator_lag@servo tau=0.08": (Lag, 0.03),
    "dead_band@servo half_width=0.1": (ServoDead, 0.03),
    "dead_band@push half_width=0.2": (MotorDead, 0.03),
    "supply_sag R=0.12": (Sag, 0.03),
    "command_limit@servo v=1.2 a=10": (Profile, 0.03),
    "gravity_compensation@shoulder share=0.7": (Weightless, 0.03),
    "external_force@hand x=1.5 y=0 z=-1 k=0": (Pull, 0.03),
    "external_force@hand x=2 y=0 z=4 k=8": (Pull, 0.03),
}
"""What is planted, its twin, and by how much of the effect's own size the two may be apart."""


def simulated(kind: type[Twin], values: Values, commands: np.ndarray, on: np.ndarray, period: float) -> np.ndarray:
    """Joint positions (rows, 2) under commands (rows, 2), each held for a period."""
    twin, substeps, rows = _no_motors(kind(**values)), 100, []
    for u, switch in zip(commands, on, strict=True):
        rows.append(twin.data.qpos.copy())
        for _ in range(substeps):
            twin.step(u, switch, period / substeps)
    return np.array(rows)
