"""The same for MJX, as functions without memory of their own: the last part of every `explained.py`."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.engines.standalone.runtime import Found, Simulated, index_of
from estexp_jax.physics.engines.standalone.runtime_laws import Step
from estexp_jax.physics.engines.standalone.runtime_sites import Motion, carried

_ARMED = 1e-9
"""A friction loss without effect, that makes MJX keep a row for it."""
_DOF_FIELDS = {"damping": "dof_damping", "friction": "dof_frictionloss", "inertia": "dof_armature"}
_MOTOR_FIELDS = ("actuator_gainprm", "actuator_biasprm", "actuator_forcerange")

MjxMemory = dict[str, Any]
"""What is remembered from step to step; a pytree."""


def simulation_of_mjx(
    found: Found, model: mujoco.MjModel
) -> tuple[mujoco.MjModel, MjxMemory, Callable[[Any, Any, MjxMemory], tuple[Any, MjxMemory]]]:
    """What was found on MJX, over a model that nothing was installed into.

    Returns:
        The model to put on the device; what is remembered at the beginning; and step(mx, dx, memory) ->
        (dx, memory), which takes the place of `mjx.step` and may be compiled and mapped as that.
    """
    one = MjxSteps(found.over(model), copy(model))
    return one.model, one.begin(), one.step


class MjxSteps:
    """Steps on MJX.

    Attributes:
        model: with the values that were found, to put on the device.
    """

    def __init__(self, found: Found, model: mujoco.MjModel) -> None:
        self.found, self.model, self.dt = found, model, float(model.opt.timestep) / found.substeps
        Simulated(model, mujoco.MjData(model)).edit(found.edits)
        joints = {place.joint for law in found.laws for place in law.places if place.joint}
        dofs = [int(model.jnt_dofadr[index_of(model, "joint", name)]) for name in joints]
        model.dof_frictionloss[dofs] = np.maximum(model.dof_frictionloss[dofs], _ARMED)
        #: Addresses of a command and of the one in its place, and by how many steps it is late.
        self.commands = [(self._command(c.motor, c.part), self._source(c), c.delay / self.dt) for c in found.delayed]
        self.readings = [(self._column(r.sensor, r.part), r, r.delay / self.dt) for r in found.readings]

    def begin(self) -> MjxMemory:
        """What is remembered before the first step."""
        import jax.numpy as jnp

        model, zero, hidden = self.model, jnp.zeros(()), dict[str, Any]()
        for k, law in enumerate(self.found.laws):
            for i, place in enumerate(law.places if law.rest else ()):
                given = (zero,) if law.kind == "command" else (zero, zero)
                hidden[f"{k}.{i}"] = tuple(law.rest(jnp, place.p, *given)) if law.rest else ()
        sizes = (int(max((x[2] for x in some), default=0.0)) + 2 for some in (self.commands, self.readings))
        commands, readings = (jnp.zeros((n, k)) for n, k in zip(sizes, (model.nu, model.nsensordata), strict=True))
        began = jnp.zeros((), bool)
        return {"began": began, "time": zero, "commands": commands, "readings": readings, "hidden": hidden}

    def step(self, mx: Any, dx: Any, memory: MjxMemory) -> tuple[Any, MjxMemory]:
        """One step of the model's length; readings are those of its beginning."""
        from mujoco import mjx

        given = {name: getattr(dx, name) for name in ("ctrl", "qfrc_applied", "xfrc_applied")}
        finer = mx.replace(opt=mx.opt.replace(timestep=self.dt)) if self.found.substeps > 1 else mx
        found = []
        for _ in range(self.found.substeps):
            own, there, after = self._acted(finer, dx.replace(**given), memory)
            dx = mjx.step(own, there)
            readings, past = self._displayed(dx.sensordata, memory, after)
            memory = {**after, "readings": past}
            found.append(readings)
        return dx.replace(sensordata=found[0], **given), memory

    def _acted(self, mx: Any, dx: Any, memory: MjxMemory) -> tuple[Any, Any, MjxMemory]:
        """Model and state with all that acts in a step, and what is remembered after it."""
        import jax.numpy as jnp
        from mujoco import mjx

        def place() -> Any:
            return mjx.crb(mx, mjx.com_pos(mx, mjx.kinematics(mx, dx)))

        def momenta() -> Any:
            there = place()
            return carried(jnp, self.model, there._impl.crb, there.cdof, there.subtree_com, there.xpos)

        def value_of(name: str) -> Any:
            return getattr(mx.opt, name[4:]) if name.startswith("opt.") else getattr(mx, name)

        ctrl, past = self._arrived(dx.ctrl, memory)
        on = jnp.ones(self.model.nactuator)
        now = Motion(dx.qpos, dx.qvel, ctrl, on, self.dt, momenta, lambda: place().xipos)
        step = Step(jnp, self.model, value_of, self.found, now)
        before = {key: memory["hidden"][f"{key[0]}.{key[1]}"] for key in step.rest()}
        for key, rest in step.rest().items():
            before[key] = tuple(jnp.where(memory["began"], a, b) for a, b in zip(before[key], rest, strict=True))
        hidden = {f"{k}.{i}": tuple(x) for (k, i), x in step.act(before).items()}
        for k, u in step.ctrl.items():
            ctrl = ctrl.at[k].set(u)
        force, pull = dx.qfrc_applied, dx.xfrc_applied
        for dof, x in step.added["force"].items():
            force = force.at[dof].add(x)
        for body, parts in step.pull.items():
            pull = pull.at[body, :3].add(jnp.stack(parts))
        fields = {}
        for part, name in _DOF_FIELDS.items():
            for dof, x in step.added[part].items():
                fields[name] = fields.get(name, getattr(mx, name)).at[dof].add(x)
        if step.share:
            share = on
            for a, x in step.share.items():
                share = share.at[a].set(x)
            fields |= {name: getattr(mx, name) * share[:, None] for name in _MOTOR_FIELDS}
        after = {"began": jnp.ones((), bool), "time": memory["time"] + self.dt, "commands": past, "hidden": hidden}
        return mx.replace(**fields), dx.replace(ctrl=ctrl, qfrc_applied=force, xfrc_applied=pull), after

    def _arrived(self, given: Any, memory: MjxMemory) -> tuple[Any, Any]:
        """Commands that arrive now, and those that are remembered."""
        past = _pushed(memory["commands"], given, memory["began"])
        ctrl = given
        for own, source, steps in self.commands:
            ctrl = ctrl.at[own].set(_steps_ago(past[:, source], steps))
        return ctrl, past

    def _displayed(self, readings: Any, memory: MjxMemory, after: MjxMemory) -> tuple[Any, Any]:
        """Readings as sensors show them, and those that are remembered."""
        for s in self.found.displayed:
            x = s.factor * after["hidden"][f"{s.law}.{s.place}"][s.state]
            readings = readings.at[self._column(s.sensor, s.part)].add(x)
        for column, r, _ in self.readings:
            readings = readings.at[column].set(r.gain * readings[column] + r.bias)
        past = _pushed(memory["readings"], readings, memory["began"])
        for column, r, steps in self.readings:
            readings = readings.at[column].set(_steps_ago(past[:, column], steps) + r.drift * memory["time"])
        return readings, past

    def _column(self, sensor: str, part: int) -> int:
        return int(self.model.sensor_adr[index_of(self.model, "sensor", sensor)]) + part

    def _command(self, motor: str, part: int) -> int:
        return int(self.model.actuator_ctrladr[index_of(self.model, "actuator", motor)]) + part

    def _source(self, c: Any) -> int:
        return self._command(c.source, c.source_part) if c.source else self._command(c.motor, c.part)


def _pushed(past: Any, now: Any, began: Any) -> Any:
    """Rows of the past with those of now in front; at the beginning it was always as now."""
    import jax.numpy as jnp

    return jnp.where(began, jnp.roll(past, 1, axis=0).at[0].set(now), jnp.broadcast_to(now, past.shape))


def _steps_ago(past: Any, steps: float) -> Any:
    """What was so many steps ago, in part between two of them."""
    whole = int(steps)
    return (1.0 - steps + whole) * past[whole] + (steps - whole) * past[whole + 1]
