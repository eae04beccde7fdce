"""Two engines that move a robot under given joint forces: MuJoCo in C at a fine step, and equations by hand."""

from __future__ import annotations

import mujoco
import numpy as np

from experiments.benchmark.generator.equations import by_hand, integrator
from experiments.benchmark.generator.robots import Layout, home


class CEngine:
    """MuJoCo's C engine without its own actuators.

    Args of its making: the model, where things are, the fine step (s) and the integrator.
    """

    def __init__(self, model: mujoco.MjModel, layout: Layout, dt: float, integrator: int) -> None:
        """At home, at rest."""
        self.layout, self.dt, self.integrator = layout, dt, integrator
        self.use(model)
        self.data = mujoco.MjData(model)
        self.data.qpos[:] = home(model)
        self.data.qpos[layout.q] = home(model)[layout.q]

    def use(self, model: mujoco.MjModel) -> None:
        """Go on with another model of the same robot."""
        model.opt.timestep, model.opt.integrator = self.dt, self.integrator
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
        mujoco.mj_setConst(model, mujoco.MjData(model))
        self.model = model

    def state(self) -> tuple[list[float], list[float]]:
        """Positions and speeds of the scalar joints."""
        return self.data.qpos[self.layout.q].tolist(), self.data.qvel[self.layout.v].tolist()

    def whole(self) -> tuple[np.ndarray, np.ndarray]:
        """All of qpos and qvel."""
        return self.data.qpos.copy(), self.data.qvel.copy()

    def set(self, qpos: np.ndarray, qvel: np.ndarray) -> None:
        """Put it into a state."""
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel

    def push(self, body: str, force: tuple[float, float, float]) -> None:
        """Apply a constant force from now on."""
        self.data.xfrc_applied[self.model.body(body).id, :3] = force

    def advance(self, force: list[float]) -> None:
        """One fine step under forces (scalar joints)."""
        self.data.qfrc_applied[self.layout.v] = force
        mujoco.mj_step(self.model, self.data)


class HandEngine:
    """The equations of `equations`, integrated adaptively within each fine step; forces are held over it."""

    def __init__(self, model: mujoco.MjModel, name: str, dt: float) -> None:
        """At home, at rest."""
        self.name, self.dt = name, dt
        self.force = [0.0, 0.0]
        self.use(model)
        self.solver = integrator(lambda: self.equations, self.force)
        self.solver.set_initial_value([*home(model).tolist(), 0.0, 0.0])

    def use(self, model: mujoco.MjModel) -> None:
        """Go on with other numbers."""
        self.equations = by_hand(model, self.name)

    def state(self) -> tuple[list[float], list[float]]:
        """Positions and speeds."""
        y = np.asarray(self.solver.y).tolist()
        return y[:2], y[2:]

    def whole(self) -> tuple[np.ndarray, np.ndarray]:
        """The same as arrays."""
        y = np.array(self.solver.y)
        return y[:2], y[2:]

    def set(self, qpos: np.ndarray, qvel: np.ndarray) -> None:
        """Put it into a state."""
        self.solver.set_initial_value([*qpos.tolist(), *qvel.tolist()], self.solver.t)

    def push(self, body: str, force: tuple[float, float, float]) -> None:
        """These robots are not pushed."""
        raise NotImplementedError(f"{self.name} by hand knows no force on {body}: {force}")

    def advance(self, force: list[float]) -> None:
        """One fine step."""
        self.force[:] = force
        self.solver.integrate(self.solver.t + self.dt)
