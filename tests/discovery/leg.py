"""The leg with any effect of the catalogue concealed in it: laws in numpy on the C engine, at a fifth of the step."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.package_data import model_path
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

RATE, FINER, LENGTH = 100.0, 5, 4.0
BITS, NOISE = 14, 2e-4
JOINTS = ("hip", "thigh", "knee")
Values = Mapping[str, float]

CASES: dict[str, Values] = {
    "viscous_friction@knee": {"c": 0.3},
    "coulomb_friction@thigh": {"T": 0.8},
    "stribeck_friction@knee": {"T": 0.3, "S": 0.6, "w_s": 0.3},
    "load_dependent_friction@thigh": {"mu": 0.25},
    "quadratic_drag@knee": {"c": 0.15},
    "joint_stiffness@thigh": {"k": 6.0, "q0": 0.5},
    "cogging@knee": {"A": 0.6, "n": 12.0, "phase": 0.7},
    "armature@knee": {"I": 0.02},
    "joint_limit@thigh": {"low": -0.35},
    "hysteresis@thigh": {"T": 1.0, "sigma": 12.0},
    "crosstalk@knee": {"from": 2.0, "g": 0.12},
    "torque_offset@knee": {"T": 0.6},
    "motor_weakness@thigh": {"loss": 0.4},
    "motor_weakness@*": {"loss": 0.35},
    "torque_saturation@thigh": {"limit": 4.0},
    "back_emf@knee": {"k": 0.5},
    "motor_fade@thigh": {"loss": 0.9, "tau": 0.8},
    "supply_sag": {"R": 0.025},
    "gravity_compensation@thigh": {"share": 0.8},
    "command_limit@thigh": {"v": 4.0, "a": 120.0},
    "joint_compliance@thigh": {"k": 60.0, "d": 0.3, "I": 0.02},
    "backlash@knee": {"half_gap": 0.04},
    "command_delay@thigh": {"delay": 0.03},
    "command_delay@*": {"delay": 0.025},
    "actuator_lag@hip": {"tau": 0.06},
    "dead_band@hip": {"half_width": 0.06},
    "tied_outputs@knee": {"with": 2.0},
    "sensor_gain@knee_angle": {"gain": 0.85},
    "sensor_bias@knee_angle": {"bias": 0.08},
    "sensor_delay@thigh_angle": {"delay": 0.03},
    "sensor_stuck@knee_angle": {"value": 0.3},
    "joint_jam@knee": {"f": 0.6},
    "part_lost@shank": {},
    "body_mass@shank": {"dm": 0.4},
    "com_shift@thigh": {"x": 0.05},
    "joint_offset@knee": {"offset": 0.15},
    "gravity_tilt": {"angle": 0.25, "axis": 0.9},
    "external_force@shank": {"x": 3.0, "y": -2.0},
}
"""What is concealed; parameters left out are zero."""
LIMIT, LIMITS = 20.0, {"motor_fade@thigh": 6.0}
"""Largest torque of the motors, N m; where they fade they are small ones, which warm as they work."""


def _described(limit: float) -> str:
    """MJCF of the leg with motors of this largest torque."""
    return model_path("leg").read_text().replace(f"-{LIMIT:g} {LIMIT:g}", f"-{limit:g} {limit:g}")


class Leg:
    """One real leg.

    Args:
        case: one of `CASES`.
        seed: of parameter errors of 1 %.
    """

    def __init__(self, case: str, seed: int) -> None:
        self.effect, _, self.place = case.partition("@")
        self.v = {"x": 0.0, "y": 0.0, "z": 0.0, **CASES.get(case, {})}
        self.limit = LIMITS.get(case, LIMIT)
        spec = mujoco.MjSpec.from_string(_described(self.limit))
        self._describe(spec)
        self.model = spec.compile()
        self.model.opt.timestep /= FINER
        self._compiled(np.random.default_rng([seed, 5]))
        self.data = mujoco.MjData(self.model)
        self.gain, self.bias = self.model.actuator_gainprm.copy(), self.model.actuator_biasprm.copy()
        self.dof = JOINTS.index(self.place) if self.place in JOINTS else -1
        self.state: dict[str, float] = {}

    def _describe(self, spec: mujoco.MjSpec) -> None:
        v = self.v
        match self.effect:
            case "joint_limit":
                spec.joint(self.place).limited, spec.joint(self.place).range = 1, [v["low"], 3.0]
            case "joint_offset":
                spec.joint(self.place).ref = v["offset"]
            case "gravity_tilt":
                axis = np.array([np.cos(v["axis"]), np.sin(v["axis"]), 0.0])
                quat, turned = np.zeros(4), np.zeros(3)
                mujoco.mju_axisAngle2Quat(quat, axis, v["angle"])
                mujoco.mju_rotVecQuat(turned, spec.option.gravity, quat)
                spec.option.gravity = turned

    def _compiled(self, rng: np.random.Generator) -> None:
        m, v, effect = self.model, self.v, self.effect
        error = 1.0 + 0.01 * rng.standard_normal(m.nbody)
        m.body_mass *= error
        m.body_inertia *= error[:, None]
        m.dof_damping *= 1.0 + 0.01 * rng.standard_normal(m.nv)
        m.dof_armature *= 1.0 + 0.01 * rng.standard_normal(m.nv)
        dof = JOINTS.index(self.place) if self.place in JOINTS else slice(None)
        match effect:
            case "viscous_friction" | "back_emf":
                m.dof_damping[dof] += v["c"] if "c" in v else v["k"]
            case "joint_jam":  # full torque turns it by a degree a second at f = 1
                m.dof_damping[dof] *= (m.actuator_forcerange[dof, 1] / np.deg2rad(1.0) / 0.05) ** v["f"]
            case "part_lost":
                m.body_mass[m.body(self.place).id] *= 0.01
                m.body_inertia[m.body(self.place).id] *= 0.01
            case "coulomb_friction":
                m.dof_frictionloss[dof] = v["T"]
            case "armature":
                m.dof_armature[dof] += v["I"]
            case "motor_weakness":
                m.actuator_gainprm[dof] *= 1.0 - v["loss"]
                m.actuator_biasprm[dof] *= 1.0 - v["loss"]
                m.actuator_forcerange[dof] *= 1.0 - v["loss"]
            case "torque_saturation":
                m.actuator_forcerange[dof] = [-v["limit"], v["limit"]]
            case "body_mass":
                b = m.body(self.place).id
                m.body_inertia[b] *= 1.0 + v["dm"] / m.body_mass[b]
                m.body_mass[b] += v["dm"]
            case "com_shift":
                m.body_ipos[m.body(self.place).id] += [v["x"], v["y"], v["z"]]
        mujoco.mj_setConst(m, mujoco.MjData(m))

    def step(self, u: np.ndarray, on: np.ndarray) -> None:
        """One physics step under commands (3,), motors on or off (3,)."""
        m, d = self.model, self.data
        d.ctrl[:] = self._obeyed(u)
        scale = on.copy()
        d.qfrc_applied[:] = 0.0
        if self.dof >= 0 or self.effect == "supply_sag":
            self._law(on, scale)
        m.actuator_gainprm[:], m.actuator_biasprm[:] = self.gain * scale[:, None], self.bias * scale[:, None]
        mujoco.mj_step(m, d)

    def _obeyed(self, u: np.ndarray) -> np.ndarray:
        u, v, i = np.clip(u, -1.2, 1.2), self.v, self.dof
        if self.effect == "actuator_lag":
            u[i] = self.state["u"] = self.state.get("u", u[i]) + self.model.opt.timestep / v["tau"] * (
                u[i] - self.state.get("u", u[i])
            )
        if self.effect == "dead_band":
            asked = u[i] - self.data.qpos[i]
            u[i] = self.data.qpos[i] + asked - np.clip(asked, -v["half_width"], v["half_width"])
        if self.effect == "tied_outputs":
            u[i] = u[int(v["with"]) - 1]
        if self.effect == "command_limit":
            u[i] = self._profiled(u[i])
        return u

    def _profiled(self, goal: float) -> float:
        """A goal that is led to another with a bounded speed and acceleration, and brakes in time."""
        s, v, dt = self.state, self.v, self.model.opt.timestep
        left = goal - s.setdefault("goal", goal)
        speed = np.sign(left) * min(v["v"], np.sqrt(2.0 * v["a"] * abs(left)))
        s["speed"] = s.get("speed", 0.0) + float(np.clip(speed - s.get("speed", 0.0), -v["a"] * dt, v["a"] * dt))
        step = s["speed"] * dt
        s["goal"], s["speed"] = (goal, 0.0) if abs(left) <= abs(step) else (s["goal"] + step, s["speed"])
        return s["goal"]

    def _gravity(self) -> float:
        """Torque that gravity puts on the joint."""
        d, bias, speed = self.data, np.zeros(self.model.nv), self.data.qvel.copy()
        d.qvel[:] = 0.0
        mujoco.mj_fwdVelocity(self.model, d)
        mujoco.mj_rne(self.model, d, 0, bias)
        d.qvel[:] = speed
        return -float(bias[self.dof])

    def _servo(self, u: float, q: float, w: float) -> float:
        return float(np.clip(40.0 * (u - q) - w, -self.limit, self.limit))

    def _law(self, on: np.ndarray, scale: np.ndarray) -> None:
        """What depends on the state: torques into qfrc_applied, friction into the model, motors scaled in place."""
        m, d, v, i, s, dt = self.model, self.data, self.v, self.dof, self.state, self.model.opt.timestep
        q, w = d.qpos[i], d.qvel[i]
        torque = [on[k] * self._servo(d.ctrl[k], d.qpos[k], d.qvel[k]) for k in range(3)]
        match self.effect:
            case "stribeck_friction":
                m.dof_frictionloss[i] = v["T"] + v["S"] * np.exp(-((w / v["w_s"]) ** 2))
            case "load_dependent_friction":
                m.dof_frictionloss[i] = v["mu"] * abs(torque[i])
            case "quadratic_drag":
                d.qfrc_applied[i] = -v["c"] * abs(w) * w
            case "joint_stiffness":
                d.qfrc_applied[i] = -v["k"] * (q - v["q0"])
            case "cogging":
                d.qfrc_applied[i] = v["A"] * np.sin(v["n"] * q + v["phase"])
            case "torque_offset":
                d.qfrc_applied[i] = v["T"]
            case "hysteresis":
                s["F"] = s.get("F", 0.0) + dt * v["sigma"] * w * (1.0 - s.get("F", 0.0) / v["T"] * np.sign(w))
                d.qfrc_applied[i] = -s["F"]
            case "crosstalk":
                d.qfrc_applied[i] = v["g"] * torque[int(v["from"]) - 1]
            case "gravity_compensation":
                d.qfrc_applied[i] = -v["share"] * on[i] * self._gravity()
            case "supply_sag":
                left = max(1.0 - v["R"] * sum(map(abs, torque)), 0.0)
                scale *= left
                m.actuator_forcerange[:] = [-left * self.limit, left * self.limit]
            case "back_emf":
                m.dof_damping[i] = 0.05 + v["k"] * on[i]
            case "motor_fade":
                left = 1.0 - v["loss"] * s.get("H", 0.0)
                scale[i], m.actuator_forcerange[i] = left * scale[i], [-left * self.limit, left * self.limit]
                s["H"] = s.get("H", 0.0) + dt * ((torque[i] / self.limit) ** 2 - s.get("H", 0.0)) / v["tau"]
            case "joint_compliance" | "backlash":
                scale[i] = 0.0
                d.qfrc_applied[i] = self._behind(on, q, w)

    def _behind(self, on: np.ndarray, q: float, w: float) -> float:
        """Torque that a rotor passes on through a spring or a gap with hard ends, in ten steps of its own."""
        s, v, i, dt, mean = self.state, self.v, self.dof, self.model.opt.timestep / 10, 0.0
        if self.effect == "backlash":
            self.model.dof_armature[i] = 0.0
        for k in range(10):
            now = q + k * dt * w
            r, a = s.get("r", q), s.get("a", w)
            if self.effect == "joint_compliance":
                passed, inertia = v["k"] * (r - now) + v["d"] * (a - w), v["I"]
            else:
                beyond = (r - now) - np.clip(r - now, -v["half_gap"], v["half_gap"])
                passed = 3e3 * beyond + 5.0 * (a - w) * (beyond != 0.0)
                passed, inertia = (max(passed, 0.0) if beyond > 0.0 else min(passed, 0.0)), 0.005
            a += dt * (on[i] * self._servo(self.data.ctrl[i], r, a) - passed) / inertia
            s["r"], s["a"], mean = r + dt * a, a, mean + passed / 10
        return mean


def record(case: str, seed: int, role: str) -> Recording:
    """One recording of a leg with an effect: sums of sines with jumps, encoders with noise, motors off for a while."""
    rng, leg = np.random.default_rng(seed), Leg(case, seed // 10)
    inner, n = round(1.0 / (RATE * leg.model.opt.timestep)), round(LENGTH * RATE)
    before = 50
    u, on, q = _commands(rng, n + before, role), np.ones((n + before, 3)), np.zeros((n, 3))
    on[before + n // 2 : before + n // 2 + 40] = 0.0
    sent = np.repeat(u, inner, axis=0)
    late = round(leg.v.get("delay", 0.0) / leg.model.opt.timestep) if leg.effect == "command_delay" else 0
    who = [JOINTS.index(leg.place)] if leg.place in JOINTS else [0, 1, 2]
    old = round(leg.v.get("delay", 0.0) / leg.model.opt.timestep) if leg.effect == "sensor_delay" else 0
    path = []
    for k in range(len(sent)):
        path.append(leg.data.qpos.copy())
        if k == before * inner and leg.effect == "motor_fade":
            leg.state["H"] = 0.0  # cold where a recording begins
        if k % inner == 0 and k // inner >= before:
            q[k // inner - before] = path[-1]
            if leg.effect == "sensor_delay":
                q[k // inner - before, 1] = path[k - old][1]
        command = sent[k].copy()
        command[who] = sent[max(k - late, 0)][who]
        if leg.effect == "external_force":
            leg.data.xfrc_applied[leg.model.body(leg.place).id, :3] = [leg.v[c] for c in "xyz"]
        leg.step(command, on[k // inner].copy())
    step = 2.0 * np.pi / 2**BITS
    read = np.round((q + NOISE * rng.standard_normal(q.shape)) / step) * step
    if leg.effect in ("sensor_gain", "sensor_bias", "sensor_stuck"):
        sensor = {"hip_angle": 0, "thigh_angle": 1, "knee_angle": 2}[leg.place]
        whole = read[:, sensor] * leg.v.get("gain", 1.0) + leg.v.get("bias", 0.0)
        read[:, sensor] = leg.v["value"] if leg.effect == "sensor_stuck" else whole
    nothing, time = np.full((n, 3), np.nan), np.arange(n) / RATE
    return Recording(f"{role}_{seed}.csv", time, u[before:], on[before:], read, nothing, nothing, role)


def _commands(rng: np.random.Generator, n: int, role: str) -> np.ndarray:
    """(n, 3): sums of three sines a motor, with a jump now and then."""
    time = np.arange(n)[:, None, None] / RATE
    frequency, phase = rng.uniform(0.2, 1.5, (3, 3)), rng.uniform(0.0, 2.0 * np.pi, (3, 3))
    waves = np.sin(2.0 * np.pi * frequency * time + phase).sum(axis=1) / 2.0
    jumps = np.repeat(rng.choice([-0.4, 0.0, 0.4], size=(n // 80 + 1, 3)), 80, axis=0)[:n]
    return (0.6 if role == "train" else 0.75) * (waves + jumps)


def leg_case(case: str, seed: int) -> Case:
    """Three training recordings and one test recording of one leg."""
    robot = Robot.from_string(_described(LIMITS.get(case, LIMIT)), "leg.xml")
    roles = ["train"] * 3 + ["test"]
    recordings = tuple(record(case, 10 * seed + k, role) for k, role in enumerate(roles))
    return Case(robot, recordings, (robot,) * len(recordings))
