"""Joint states of a term's elements in one step, in lanes: `JointState` with rows (n_elements, N)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, final

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.step import LaneState
from estexp_jax.physics.effects.base import JointState, Term
from estexp_jax.physics.effects.mounts import MountState
from estexp_jax.physics.effects.sites import actuator_dofs, driven_actuators
from estexp_jax.physics.engines.lanes.gravity_torques import gravity_torques
from estexp_jax.physics.engines.lanes.motors import MotorInputs, Motors
from estexp_jax.physics.engines.lanes.mounts import mount_states_in_lanes
from estexp_jax.physics.engines.motors import drives
from estexp_jax.physics.model.robot import Robot


class StepStart(NamedTuple):
    """A step at its beginning: position and speed (N,) by velocity address, motor inputs, its length, the robots."""

    position: Mapping[int, Any]
    speed: Mapping[int, Any]
    inputs: MotorInputs
    dt: Any
    state: LaneState


@final
class JointStates:
    """Gathers what terms see, on robots of these numbers."""

    def __init__(self, robot: Robot, layout: Layout, params: ModelParameters, motors: Motors) -> None:
        """With these motors."""
        self._robot, self._layout, self._params, self._motors = robot, layout, params, motors

    def coordinates(self, state: LaneState) -> tuple[dict[int, Any], dict[int, Any]]:
        """Position and speed (N,) of each hinge and slide, by velocity address."""
        position, speed = {}, {}
        for joint, q in zip(self._layout.joints, state.qpos, strict=True):
            if not joint.free:
                for i, address in enumerate(joint.dof):
                    position[address], speed[address] = (_row(x, i) for x in (q[0], state.qvel[joint.dofs[0]]))
        return position, speed

    def of(self, term: Term, now: StepStart) -> JointState:
        """Joint states of a term's elements."""
        (position, speed, inputs, dt, state), dofs = now, term.dofs(self._robot)
        there = drives(self._robot, dofs, term.motors(self._robot))
        at = [[int(a) for a, t in zip(*pair, strict=True) if t] for pair in zip(there.motors, there.there, strict=True)]
        q, w = stacked(dofs, position, speed)

        def torque_at(q: Any, w: Any) -> Any:
            pairs = [(site, q[i], w[i]) for i, site in enumerate(at)]
            return jnp.stack([self._motors.torque(*pair, inputs, whole=there.whole) for pair in pairs])

        def torque_of(number: Any) -> Any:
            total: Any = jnp.zeros_like(q)
            for address in position:
                joint = int(self._layout.model.dof_jntid[address])
                site = [a for a in driven_actuators(self._robot) if self._robot.joint_of_actuator(a) == joint]
                one = self._motors.torque(site, position[address], speed[address], inputs, whole=True)
                mine: Any = jnp.where(jnp.round(number) == joint + 1, one, 0.0)
                total = total + mine
            return total

        def load() -> Any:
            total: Any = jnp.zeros_like(q[0])
            for a, address in zip(driven_actuators(self._robot), actuator_dofs(self._robot).tolist(), strict=True):
                one = self._motors.torque([a], position[address], speed[address], inputs, whole=False)
                total = total + jnp.abs(one)
            return total

        def gravity() -> Any:
            found = gravity_torques(self._layout, self._params, state)
            return jnp.stack([found[int(d)] + jnp.zeros_like(q[0]) for d in dofs])

        def mount() -> MountState:
            return mount_states_in_lanes(self._robot, self._layout, self._params, state, term.bodies(self._robot), dofs)

        def motion_of(number: Any) -> tuple[Any, Any]:
            at: Any = jnp.zeros_like(q)
            rate: Any = jnp.zeros_like(q)
            for address, joint in zip(position, self._layout.model.dof_jntid[list(position)], strict=True):
                mine: Any = (jnp.round(number) == int(joint) + 1).astype(q.dtype)
                at, rate = at + mine * position[address], rate + mine * speed[address]
            return at, rate

        def asked() -> tuple[Any, Any]:
            each = [self._motors.asked(site, position, speed, inputs) for site in at]
            in_all, beyond = (jnp.stack(rows) for rows in zip(*each, strict=True))
            return in_all, beyond

        def switched(site: list[int]) -> Any:
            on = jnp.zeros_like(q[0])
            for a in site:
                on = jnp.maximum(on, inputs.enable[a])
            return on

        return JointState(
            q=q,
            w=w,
            torque=torque_at(q, w),
            on=jnp.stack([switched(site) for site in at]),
            dt=dt,
            limit=jnp.asarray(there.limit(), q.dtype)[:, None],
            armature=jnp.stack([self._params.get("dof_armature", [int(d)], None) + jnp.zeros_like(q[0]) for d in dofs]),
            torque_at=torque_at,
            torque_of=torque_of,
            motion_of=motion_of,
            asked=asked,
            load=load,
            gravity=gravity,
            mount=mount,
        )


def stacked(dofs: np.ndarray, *tables: Mapping[int, Any]) -> tuple[Any, ...]:
    """Rows (n_elements, N) of tables by velocity address."""
    return tuple(jnp.stack([table[int(d)] for d in dofs]) for table in tables)


def _row(x: jax.Array, i: int) -> jax.Array:
    return x[i] if x.ndim == 2 else x
