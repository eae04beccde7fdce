"""What is compiled once for all tests of the physics floor."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mujoco import mjx

from estexp_jax.lanes.compilation import compile_lowered
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.states import from_lanes, to_lanes
from estexp_jax.lanes.step import Stepper
from estexp_jax.physics.effects.base import Edit
from estexp_jax.physics.effects.changes import Values, neutral
from estexp_jax.physics.effects.registry import catalogue, named_effects, paper
from estexp_jax.physics.engines.batching import in_chunks
from estexp_jax.physics.engines.choice import closed_loop_simulator
from estexp_jax.physics.engines.closed_loop import ClosedLoopSimulator
from estexp_jax.physics.engines.lanes.model import lanes_model, lanes_refusal
from estexp_jax.physics.engines.lanes.terms import ActiveEffects
from estexp_jax.physics.engines.mjx.model import MjxModel, mjx_model
from estexp_jax.physics.engines.mjx.terms import MjxStepStart
from estexp_jax.recovery.control.network import RecurrentPolicy
from tests.physics.reference import TRAJECTORY, States
from tests.physics.robots import robot

WIDTH = 120
COMPARED = (
    *(e for e in named_effects() if isinstance(e, Edit) and e.in_mjcf),
    *catalogue(["load_dependent_friction", "back_emf"]),
)
"""Effects that are compared with a model of the C engine, changed once or before each step."""
CONSTANTS = ("body_subtreemass", "dof_invweight0", "body_invweight0")


@dataclass(frozen=True, eq=False)
class Lab:
    """One robot on MJX with the effects that are compared: batches of (values, state), all by one executable."""

    on_mjx: MjxModel

    def run(self, values: Values, states: States) -> dict[str, np.ndarray]:
        """Next velocities, configurations after the trajectory, and the constants of the edited models."""
        batch = (values, *(np.asarray(x, np.float32) for x in states[:4]))
        return in_chunks(partial(_run, self), batch, WIDTH)


@partial(jax.jit, static_argnums=0)
def _run(self: Lab, batch: Any) -> dict[str, jax.Array]:
    return jax.vmap(partial(_run_one, self))(*batch)


def _run_one(self: Lab, values: Values, qpos, qvel, ctrl, warmstart) -> dict[str, jax.Array]:  # noqa: ANN001
    on = self.on_mjx
    model = on.edited(on.model, values)
    enable = jnp.ones(on.robot.model.nu)

    def now(data: Any) -> MjxStepStart:
        return MjxStepStart(data.qpos, data.qvel, ctrl, enable, model.opt.timestep)

    def step(k, carry):  # noqa: ANN001, ANN202
        data, hidden, first = carry
        does = on.acted(model, values, hidden, now(data))
        data = mjx.step(does.model, data.replace(ctrl=does.ctrl, qfrc_applied=does.force, xfrc_applied=does.pull))
        return data, does.hidden, jnp.where(k == 0, data.qvel, first)

    data = on.data.replace(qpos=qpos, qvel=qvel, ctrl=ctrl, qacc_warmstart=warmstart)
    data, _, first = jax.lax.fori_loop(0, TRAJECTORY, step, (data, on.rested(model, values, now(data)), qvel))
    return {"next_qvel": first, "final_qpos": data.qpos} | {name: getattr(model, name) for name in CONSTANTS}


@dataclass(frozen=True, eq=False)
class LanesLab(Lab):
    """The same in lanes."""

    def run(self, values: Values, states: States) -> dict[str, np.ndarray]:
        n = len(states.qpos)
        chosen = np.resize(np.arange(n), WIDTH * -(-n // WIDTH))
        batch = jax.tree.map(lambda x: np.asarray(x, np.float32)[chosen], (values, *states[:4]))
        parts = [jax.tree.map(lambda x, i=i: x[i : i + WIDTH], batch) for i in range(0, len(chosen), WIDTH)]
        found = [self._program(part) for part in parts]
        return jax.tree.map(lambda *xs: np.concatenate(xs)[:n], *found)

    def _program(self, batch: Any) -> dict[str, np.ndarray]:
        prepare, step, _ = self.programs
        values, qpos, qvel, ctrl, warmstart = batch
        prepared = prepare(values, qpos, qvel, ctrl)
        found = step(prepared, *(np.ascontiguousarray(x.T) for x in (qpos, qvel, ctrl, warmstart)))
        return {k: np.moveaxis(np.asarray(x), -1, 0) for k, x in found.items()}

    @cached_property
    def programs(self) -> tuple[Any, Any, bool]:
        """What edits the models, what steps them, and whether that is the fast program."""
        model, lanes, on = self.on_mjx.robot.model, lanes_model(self.on_mjx), self.on_mjx

        def prepared(values: Values, qpos: Any, qvel: Any, ctrl: Any) -> Any:
            edited = on.edited(on.model, values)
            now = MjxStepStart(qpos, qvel, ctrl, jnp.ones(model.nu), model.opt.timestep)
            constants = {k: getattr(edited, k) for k in CONSTANTS}
            return lanes.fields(on.model, values), values, on.rested(edited, values, now), constants

        shapes = [(n,) for n in (model.nq, model.nv, model.nu, model.nv)]
        values = jax.tree.map(lambda x: np.zeros((WIDTH, *x.shape), np.float32), neutral(on.robot, on.catalogue))
        first = jax.jit(jax.vmap(prepared, out_axes=-1)).lower(
            values, *(np.zeros((WIDTH, *s), np.float32) for s in shapes[:3])
        )
        step = jax.jit(partial(_lanes_run, self, lanes.layout)).lower(
            first.out_info, *(np.zeros((*s, WIDTH), np.float32) for s in shapes)
        )
        return (first.compile(), *compile_lowered(step, WIDTH))


def _lanes_run(self: LanesLab, layout: Layout, prepared: Any, qpos: Any, qvel: Any, ctrl: Any, warmstart: Any) -> Any:
    fields, values, hidden, constants = prepared
    params, dt = ModelParameters(layout.model, fields, np.float32), float(layout.model.opt.timestep)
    stepper = Stepper(layout, params, 1e-9)
    acting = ActiveEffects(self.on_mjx.robot, self.on_mjx.catalogue, layout, params, values)

    def step(k: Any, carry: Any) -> Any:
        state, hidden, first = carry
        drive, added, hidden = acting.act(state, ctrl, jnp.ones_like(ctrl), dt, hidden)
        state, _ = stepper.step(state, drive, dt, added)
        return state, hidden, jnp.where(k == 0, from_lanes(layout, state)[1], first)

    carry = (to_lanes(layout, qpos, qvel, warmstart), hidden, qvel)
    state, _, first = jax.lax.fori_loop(0, TRAJECTORY, step, carry)
    return {"next_qvel": first, "final_qpos": from_lanes(layout, state)[0]} | constants


def marks(engine: str, name: str) -> tuple[pytest.MarkDecorator, ...]:
    """Marks of a test in the lab of a robot: MJX takes a minute to compile one, and by default tries a pendulum."""
    return (pytest.mark.slow,) if engine == "mjx" and name != "pendulum" else ()


@pytest.fixture(scope="session")
def lab() -> Callable[[str, str], Lab]:
    """The lab of an engine and a robot, by their names."""

    @cache
    def made(engine: str, name: str) -> Lab | str:
        on = mjx_model(robot(name), COMPARED)
        if engine == "mjx":
            return Lab(on)
        return lanes_refusal(on) or LanesLab(on)

    def one(engine: str, name: str) -> Lab:
        found = made(engine, name)
        if isinstance(found, str):
            pytest.skip(f"{name}: {found} by the lanes engine")
        return found

    return one


WALKER_ROWS = 60


@pytest.fixture(scope="session", params=["mjx", "lanes", "c"])
def walkers(request: pytest.FixtureRequest) -> ClosedLoopSimulator:
    """The quadruped in closed loop with all that the paper breaks, in each engine."""
    effects = catalogue([*(e.name for e in paper()), "neuron_fault", "tied_outputs"])
    return closed_loop_simulator(
        robot("quadruped"), effects, policy=RecurrentPolicy(), rows=WALKER_ROWS, control_step=0.01, engine=request.param
    )
