"""What laws see of a step and do to it: the third part of every `explained.py`, for NumPy and JAX alike.

Nothing is changed in place here: a step collects what laws add to it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import mujoco

from estexp_jax.physics.engines.standalone.runtime import Found, LawPlace, index_of
from estexp_jax.physics.engines.standalone.runtime_sites import Motion, Site

_AFFINE_GAIN, _AFFINE_BIAS = int(mujoco.mjtGain.mjGAIN_AFFINE), int(mujoco.mjtBias.mjBIAS_AFFINE)


class Step:
    """A step while laws act in it.

    Attributes:
        ctrl: commands that differ from those given, by address.
        share: factors on motors, by index.
        added: what is added to degrees of freedom, by part and address.
        pull: forces on bodies, by index.
    """

    def __init__(
        self,
        np: Any,
        model: mujoco.MjModel,
        read: Callable[[str], Any],
        found: Found,
        now: Motion,
        indices: dict[tuple[str, str], int] | None = None,
    ) -> None:
        self.np, self.model, self.read, self.found, self.now = np, model, read, found, now
        self.indices = {} if indices is None else indices
        self.ctrl: dict[int, Any] = {}
        self.share: dict[int, Any] = {}
        self.added: dict[str, dict[int, Any]] = {"force": {}, "damping": {}, "friction": {}, "inertia": {}}
        self.pull: dict[int, tuple[Any, Any, Any]] = {}

    def act(self, hidden: Mapping[tuple[int, int], Any]) -> dict[tuple[int, int], Any]:
        """Let all laws act, one after the other; hidden variables after the step."""
        after = dict(hidden)
        for k, law in enumerate(self.found.laws):
            does = []
            for i, place in enumerate(law.places):
                state = hidden[k, i] if (k, i) in hidden else ()
                if law.kind == "command":
                    does.append(law.act(self.np, *self.asked_of(place), self.now.dt, place.p, state))
                elif law.kind == "body":
                    at = self.now.xipos()[..., self.find("body", place.body), :]
                    does.append((law.act(self.np, at[..., 0], at[..., 1], at[..., 2], place.p), ()))
                else:
                    does.append(law.act(self.np, Site(self, place), place.p, state))
            for i, (place, (did, state)) in enumerate(zip(law.places, does, strict=True)):
                self._apply(law.kind, place, did)
                if law.rest is not None:
                    after[k, i] = state
        return after

    def rest(self) -> dict[tuple[int, int], Any]:
        """Hidden variables of a robot that has been where it is, under its commands, for long."""
        found = {}
        for k, law in enumerate(self.found.laws):
            if law.rest is None:
                continue
            for i, place in enumerate(law.places):
                if law.kind == "command":
                    found[k, i] = law.rest(self.np, place.p, self.asked_of(place)[0])
                else:
                    site = Site(self, place)
                    found[k, i] = law.rest(self.np, place.p, site.q, site.w)
        return found

    def _apply(self, kind: str, place: LawPlace, did: Any) -> None:
        if kind == "command":
            self.ctrl[self.command_of(self.find("actuator", place.motors[0]))] = did
            return
        if kind == "body":
            body = self.find("body", place.body)
            x, y, z = self.pull.get(body, (0.0, 0.0, 0.0))
            self.pull[body] = x + did[0], y + did[1], z + did[2]
            return
        dof = self.dof_of(place.joint)
        motors = [self.find("actuator", m) for m in place.motors]
        for part, x in did.items():
            if part == "motor":
                for a in motors:
                    self.share[a] = self.share.get(a, 1.0) * x
            elif part == "command":
                for a in motors:
                    strength = self.gear(a) * self.read("actuator_gainprm")[..., a, 0] * self.scale(a)
                    works = strength != 0.0
                    more = self.np.where(works, x / len(motors) / self.np.where(works, strength, 1.0), 0.0)
                    self.ctrl[self.command_of(a)] = self.command(a) + more
            else:
                self.added[part][dof] = self.added[part].get(dof, 0.0) + x

    def find(self, kind: str, name: str) -> int:
        """Index of an element."""
        if (kind, name) not in self.indices:
            self.indices[kind, name] = index_of(self.model, kind, name)
        return self.indices[kind, name]

    def dof_of(self, joint: str) -> int:
        """Address of a joint's speed."""
        return int(self.model.jnt_dofadr[self.find("joint", joint)])

    def command_of(self, a: int) -> int:
        """Address of a motor's command."""
        return int(self.model.actuator_ctrladr[a])

    def gear(self, a: int) -> Any:
        """Gear of a motor."""
        return self.read("actuator_gear")[..., int(self.model.actuator_outadr[a]), 0]

    def scale(self, a: int) -> Any:
        """By what a motor's force is multiplied, 0 where it is off."""
        return self.now.on[..., a] * self.share.get(a, 1.0)

    def command(self, a: int) -> Any:
        """A motor's command, within its range."""
        k = self.command_of(a)
        u = self.ctrl.get(k, self.now.ctrl[..., k])
        if self.model.actuator_ctrllimited[k]:
            limits = self.read("actuator_ctrlrange")[..., k, :]
            u = self.np.minimum(self.np.maximum(u, limits[..., 0]), limits[..., 1])
        return u

    def idle(self, a: int, q: Any, w: Any) -> Any:
        """The command at which a motor gives no torque: where a servo is."""
        if int(self.model.actuator_biastype[a]) != _AFFINE_BIAS:
            return 0.0 * q
        np, g, b = self.np, self.read("actuator_gainprm")[..., a, 0], self.read("actuator_biasprm")[..., a, :]
        by_place = b[..., 0] + b[..., 1] * self.gear(a) * q
        bias = np.where(b[..., 1] != 0.0, by_place, b[..., 0] + b[..., 2] * self.gear(a) * w)
        return np.where(g != 0.0, -bias / np.where(g == 0.0, 1.0, g), 0.0)

    def torque(self, a: int, q: Any, w: Any) -> Any:
        """Torque of a motor on its joint, if that were at a position and had a speed."""
        np, gear, model = self.np, self.gear(a), self.model
        g, b = self.read("actuator_gainprm")[..., a, :], self.read("actuator_biasprm")[..., a, :]
        length, speed = gear * q, gear * w
        gain = g[..., 0]
        if int(model.actuator_gaintype[a]) == _AFFINE_GAIN:
            gain = gain + g[..., 1] * length + g[..., 2] * speed
        force = gain * self.command(a)
        if int(model.actuator_biastype[a]) == _AFFINE_BIAS:
            force = force + b[..., 0] + b[..., 1] * length + b[..., 2] * speed
        if model.actuator_forcelimited[a]:
            limits = self.read("actuator_forcerange")[..., a, :]
            force = np.minimum(np.maximum(force, limits[..., 0]), limits[..., 1])
        return self.scale(a) * gear * force

    def within_joint(self, joint: str, torque: Any) -> Any:
        """The torque of all motors of a joint within the joint's own limit."""
        j = self.find("joint", joint)
        if not self.model.jnt_actfrclimited[j]:
            return torque
        limits = self.read("jnt_actfrcrange")[..., j, :]
        return self.np.minimum(self.np.maximum(torque, limits[..., 0]), limits[..., 1])

    def at(self, joint: str) -> tuple[Any, Any]:
        """Position and speed of a joint."""
        j = self.find("joint", joint)
        return self.now.qpos[..., int(self.model.jnt_qposadr[j])], self.now.qvel[..., int(self.model.jnt_dofadr[j])]

    def asked_of(self, place: LawPlace) -> tuple[Any, Any]:
        """What a motor is commanded, and the command at which it gives no torque."""
        a = self.find("actuator", place.motors[0])
        command = self.command(a)
        return command, self.idle(a, *self.at(place.joint)) if place.joint else 0.0 * command
