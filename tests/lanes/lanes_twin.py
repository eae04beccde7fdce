"""One step of a model in lanes and in the C engine, from the same states, in double precision."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.compilation import compile_lowered
from estexp_jax.lanes.forces import motor_commands
from estexp_jax.lanes.layout import Layout, layout_of
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.sensors import SensorReader
from estexp_jax.lanes.states import from_lanes, to_lanes
from estexp_jax.lanes.step import Stepper


class Visited(NamedTuple):
    """States (n, ...), and what the C engine made of them in one step."""

    qpos: np.ndarray
    qvel: np.ndarray
    ctrl: np.ndarray
    warmstart: np.ndarray
    next_qpos: np.ndarray
    next_qvel: np.ndarray
    sensordata: np.ndarray
    contacts: np.ndarray
    rows: np.ndarray


def exact(model: mujoco.MjModel) -> mujoco.MjModel:
    """The model with a solver that leaves no error in double precision; changed in place."""
    model.opt.iterations, model.opt.ls_iterations = 200, 100
    model.opt.tolerance, model.opt.ls_tolerance = 1e-15, 1e-12
    return model


def visited(model: mujoco.MjModel, n: int, seed: int, every: int = 17, qpos: np.ndarray | None = None) -> Visited:
    """States that a model passes through under random commands."""
    rng, data, after = np.random.default_rng(seed), mujoco.MjData(model), mujoco.MjData(model)
    low, high = np.where(model.actuator_ctrllimited[:, None] > 0, 1.1 * model.actuator_ctrlrange, [-1.0, 1.0]).T
    rows = []
    if qpos is not None:
        data.qpos[:] = qpos
    for _ in range(n):
        data.ctrl[:] = rng.uniform(low, high)
        for _ in range(every):
            mujoco.mj_step(model, data)
        now = (data.qpos.copy(), data.qvel.copy(), data.ctrl.copy(), data.qacc_warmstart.copy())
        after.qpos[:], after.qvel[:], after.ctrl[:], after.qacc_warmstart[:] = now
        mujoco.mj_forward(model, after)
        contacts, constraints, sensed = after.ncon, after.nefc, after.sensordata.copy()
        mujoco.mj_step(model, after)
        rows.append((*now, after.qpos.copy(), after.qvel.copy(), sensed, contacts, constraints))
    return Visited(*(np.array(column) for column in zip(*rows, strict=True)))


class Stepped(NamedTuple):
    """What lanes make of the same states, and whether the fast program did."""

    qpos: np.ndarray
    qvel: np.ndarray
    sensordata: np.ndarray
    fast: bool


def stepped(model: mujoco.MjModel, states: Visited, fields: dict[str, np.ndarray] | None = None) -> Stepped:
    """One step in lanes, in the precision that JAX is set to.

    Args:
        model: what to step.
        states: where from.
        fields: (n, ...) numbers that differ from robot to robot.
    """
    structure, last = layout_of(model), [np.moveaxis(x, 0, -1) for x in states[:4]]
    varying = {k: np.moveaxis(v, 0, -1) for k, v in (fields or {}).items()}
    dtype = jnp.zeros(()).dtype
    arguments = jax.tree.map(lambda x: np.asarray(x, dtype), (varying, *last))
    program, fast = compile_lowered(jax.jit(lambda *a: _step(structure, *a)).lower(*arguments), len(states.qpos))
    qpos, qvel, sensordata = (np.moveaxis(np.asarray(x), -1, 0) for x in program(*arguments))
    return Stepped(qpos, qvel, sensordata, fast)


def _step(layout: Layout, varying: Any, qpos: Any, qvel: Any, ctrl: Any, warmstart: Any) -> Any:
    params = ModelParameters(layout.model, varying, qpos.dtype)
    stepper = Stepper(layout, params, 1e-24 if qpos.dtype == np.float64 else 1e-9)
    commands = motor_commands(layout, ctrl)
    state, now = stepper.step(to_lanes(layout, qpos, qvel, warmstart), commands, float(layout.model.opt.timestep))
    readings = SensorReader(layout, params, stepper.inertias).read(now, range(layout.model.nsensor))
    sensordata = [readings[i] + jnp.zeros_like(qpos[0]) for i in range(layout.model.nsensordata)]
    empty = jnp.zeros((0, qpos.shape[1]))
    return (*from_lanes(layout, state)[:2], jnp.stack(sensordata) if sensordata else empty)
