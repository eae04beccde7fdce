"""One physics step of all robots of a chunk: forces, constraints, acceleration, integration.

Source: MuJoCo documentation, "Computation": "Numerical integration".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, final

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import (
    Scalar,
    Vector,
    add,
    all_to_children,
    apply,
    cross,
    dot,
    is_number,
    mul,
    sub,
    sum_over_children,
    transposed,
    vadd,
)
from estexp_jax.lanes.contacts import Contact, contacts
from estexp_jax.lanes.dynamics import Inertias, mass_and_bias
from estexp_jax.lanes.forces import JointForces, MotorCommands, joint_forces
from estexp_jax.lanes.integration import moved, speed_since_start
from estexp_jax.lanes.joint_constraints import friction_loss_rows, limit_rows
from estexp_jax.lanes.kinematics import BodyMotion, body_motion
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.newton import Solution, solve
from estexp_jax.lanes.rows import Rows
from estexp_jax.lanes.sparse import Factor

_INTEGRATOR, _OFF = mujoco.mjtIntegrator, mujoco.mjtDisableBit

TOLERANCE = {np.dtype(np.float32): 1e-9, np.dtype(np.float64): 1e-22}
"""Squared relative change of the accelerations at which the solver stops."""
ITERATIONS = 10
"""Most Newton steps; a robot that has not converged by then keeps what it has, as in MuJoCo."""


class LaneState(NamedTuple):
    """Robots at the beginning of a step.

    Attributes:
        qpos: per joint, its coordinates: seven (N,) of a floating base, else one (k, N).
        qvel: per degree of freedom, (N,) or (k, N).
        warmstart: accelerations of the step before, a floating base's spin in world axes.
    """

    qpos: tuple[tuple[Any, ...], ...]
    qvel: tuple[Any, ...]
    warmstart: tuple[Any, ...]


@final
@dataclass(frozen=True, eq=False)
class AddedForces:
    """Additions of effects during one step; the number 0 where nothing is added.

    Attributes:
        force: per degree of freedom, N m or N.
        damping: on top of the joints' own, likewise.
        friction: on top of the friction losses.
        inertia: on top of the armature.
        pull: force on the centres of mass of a group's bodies, N, world axes.
    """

    force: Sequence[Scalar]
    damping: Sequence[Scalar]
    friction: Sequence[Scalar]
    inertia: Sequence[Scalar]
    pull: dict[int, Vector] = field(default_factory=dict)

    @classmethod
    def nothing(cls, n_dofs: int) -> AddedForces:
        """No effect acts."""
        zeros = (0,) * n_dofs
        return cls(zeros, zeros, zeros, zeros)


@final
@dataclass(frozen=True, eq=False)
class StepState:
    """Everything about one state, for its sensors.

    Attributes:
        state: the state.
        moving: poses and velocities.
        pulled: forces of motors, springs, dampers.
        touched: contacts, and the residual of each one's rows.
        solution: accelerations and constraint forces.
    """

    state: LaneState
    moving: BodyMotion
    pulled: JointForces
    touched: tuple[tuple[Contact, Any], ...]
    solution: Solution


@final
class Stepper:
    """Steps the robots of one set of numbers; made once in a rollout, outside its loop."""

    def __init__(self, layout: Layout, params: ModelParameters, tolerance: float) -> None:
        """For robots of these numbers; `tolerance` as in `newton.solve`."""
        self.layout, self.params, self.tolerance = layout, params, tolerance
        self.inertias = Inertias(layout, params)

    def step(
        self, state: LaneState, commands: MotorCommands, dt: Scalar, added: AddedForces | None = None
    ) -> tuple[LaneState, StepState]:
        """The next state, and all about this one.

        Args:
            state: of the robots.
            commands: of the motors.
            dt: length of the step, s: a number or (N,).
            added: by effects.
        """
        added = added or AddedForces.nothing(len(self.layout.dofs))
        if self.layout.model.opt.integrator == _INTEGRATOR.mjINT_RK4:
            return self._runge_kutta(state, commands, dt, added)
        now, matrix = self._instant(state, commands, dt, added)
        rate = self._implicit(now, matrix, dt)
        speed = tuple(v + dt * a for v, a in zip(state.qvel, rate, strict=True))
        return LaneState(moved(self.layout, state.qpos, speed, dt), speed, tuple(now.solution.acceleration)), now

    def _instant(
        self, state: LaneState, commands: MotorCommands, dt: Scalar, added: AddedForces
    ) -> tuple[StepState, Any]:
        layout, params = self.layout, self.params
        moving = body_motion(layout, params, state.qpos, state.qvel)
        matrix, bias = mass_and_bias(layout, params, self.inertias, moving)
        for i, inertia in enumerate(added.inertia):
            matrix[i, i] = add(matrix[i, i], inertia)
        pulled = joint_forces(layout, params, state.qpos, moving.speed, commands)
        self._take(pulled, moving, added)
        smooth = [sub(f, b) for f, b in zip(pulled.force, bias, strict=True)]
        touched = contacts(layout, params, moving, dt)
        rows: list[Rows] = [c.rows for c in touched]
        rows += limit_rows(layout, params, state.qpos, state.qvel, dt)
        rows += friction_loss_rows(layout, params, moving.speed, dt, added.friction)
        start = state.warmstart
        solution = solve(layout.dofs, matrix, smooth, rows, start, ITERATIONS, self.tolerance)
        whole = [jnp.broadcast_to(a, s.shape) for a, s in zip(solution.acceleration, start, strict=True)]
        solution = solution._replace(acceleration=whole)
        pairs = tuple(zip(touched, solution.residuals[: len(touched)], strict=True))
        total = [add(s, f) for s, f in zip(smooth, solution.force, strict=True)]
        return StepState(state, moving, pulled, pairs, solution), (matrix, total)

    def _take(self, pulled: JointForces, moving: BodyMotion, added: AddedForces) -> None:
        """Add what effects add to the forces."""
        for i, (force, damping) in enumerate(zip(added.force, added.damping, strict=True)):
            pulled.force[i] = add(pulled.force[i], sub(force, mul(damping, moving.speed[i])))
            pulled.damping[i], pulled.braking[i] = (add(x[i], damping) for x in (pulled.damping, pulled.braking))
        for index, force in added.pull.items():
            group, pose = self.layout.groups[index], moving.poses[index]
            centre = vadd(pose.position, apply(pose.rotation, self.inertias.centre[index]))
            torque = cross(centre, force)
            for i in group.chain:
                k = self.layout.dofs[i].k
                linear, angular = (all_to_children(m[i], k, group.k) for m in (moving.linear, moving.angular))
                push = sum_over_children(add(dot(linear, force), dot(angular, torque)), group.k, k)
                pulled.force[i] = add(pulled.force[i], push)

    def _implicit(self, now: StepState, matrix: Any, dt: Scalar) -> list[Scalar]:
        """Accelerations with the damping taken at the end of the step; a floating base's spin in its own axes."""
        (matrix, force), model = matrix, self.layout.model
        fast = model.opt.integrator == _INTEGRATOR.mjINT_IMPLICITFAST
        euler = model.opt.integrator == _INTEGRATOR.mjINT_EULER and not (
            model.opt.disableflags & (_OFF.mjDSBL_EULERDAMP | _OFF.mjDSBL_DAMPER)
        )
        damping = now.pulled.damping if fast else now.pulled.braking
        rate = now.solution.acceleration
        if (fast or euler) and not all(is_number(d, 0) for d in damping):
            implicit = dict(matrix)
            for dof, d in zip(self.layout.dofs, damping, strict=True):
                implicit[dof.index, dof.index] = add(matrix[dof.index, dof.index], mul(dt, d))
            rate = Factor(self.layout.dofs, implicit).solve(force)
        return self._own_axes(rate, now.moving)

    def _own_axes(self, rate: Sequence[Scalar], moving: BodyMotion) -> list[Scalar]:
        turned = list(rate)
        for first, rotation in moving.base.items():
            turned[first + 3 : first + 6] = apply(transposed(rotation), rate[first + 3 : first + 6])
        return turned

    def _runge_kutta(
        self, state: LaneState, commands: MotorCommands, dt: Scalar, added: AddedForces
    ) -> tuple[LaneState, StepState]:
        """Fourth order, as MuJoCo's: the stages' states all start from this one, and so do their bases' turns.

        Source: Munthe-Kaas, BIT Numerical Mathematics 38 (1998).
        """
        first, _ = self._instant(state, commands, dt, added)
        speeds, rates = [state.qvel], [tuple(self._own_axes(first.solution.acceleration, first.moving))]
        warm = tuple(first.solution.acceleration)
        for share in (0.5, 0.5, 1.0):
            there = tuple(v + share * dt * a for v, a in zip(state.qvel, rates[-1], strict=True))
            stage = LaneState(moved(self.layout, state.qpos, speeds[-1], share * dt), there, warm)
            now, _ = self._instant(stage, commands, dt, added)
            speeds.append(speed_since_start(self.layout, speeds[-1], there, share * dt))
            rates.append(tuple(self._own_axes(now.solution.acceleration, now.moving)))
            warm = tuple(now.solution.acceleration)
        mean = [
            tuple((a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in zip(*stages, strict=True))
            for stages in (speeds, rates)
        ]
        speed = tuple(v + dt * a for v, a in zip(state.qvel, mean[1], strict=True))
        return LaneState(moved(self.layout, state.qpos, mean[0], dt), speed, warm), first
