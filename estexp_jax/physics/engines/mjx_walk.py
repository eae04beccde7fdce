"""Closed loop on MJX: robots with damage, each driven by its own network."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.changes import Values
from estexp_jax.physics.controllers import HIDDEN, Network, decode, respond
from estexp_jax.physics.effects.base import CommandShift, ControllerFault, Distortion, ReadingShift
from estexp_jax.physics.engines.batching import in_chunks
from estexp_jax.physics.engines.mjx_model import MjxModel, mjx_model
from estexp_jax.physics.engines.mjx_terms import Hidden, Now
from estexp_jax.physics.interface import Interface, interface_of
from estexp_jax.physics.registry import Catalogue
from estexp_jax.physics.robot import Robot
from estexp_jax.physics.travel import travel_of


class BodyState(NamedTuple):
    """Where one robot is; batched, every array has a leading axis."""

    qpos: Any  #: (nq,)
    qvel: Any  #: (nv,)
    warmstart: Any  #: (nv,) the solver's last solution
    sensordata: Any  #: (nsensordata,) of the last physics step
    hidden: Hidden  #: variables of effects that have some


class Walk(NamedTuple):
    """What robots did; every array has the robots as first axis.

    Rows are control steps; only the first `steps` of them are filled.
    """

    readings: Any  #: (robots, rows, n_inputs) raw readings before the row's command acts; touch as +1/-1
    commands: Any  #: (robots, rows, nu)
    position: Any  #: (robots, rows, 3) of the root, m
    final: BodyState
    failed: Any  #: (robots,) bool: the simulation blew up


class _Lane(NamedTuple):
    values: Values
    weights: Any
    start: BodyState


@final
@dataclass(frozen=True, eq=False)
class Walker:
    """Simulates populations of one robot in closed loop, all with one executable.

    Attributes:
        on_mjx: the robot and its catalogue of effects.
        interface: what controllers see and move.
        rows: longest walk, control steps.
        substeps: physics steps a control step.
        gain: of the neurons' tanh.
        width: robots in a chunk.
    """

    on_mjx: MjxModel
    interface: Interface
    rows: int
    substeps: int
    gain: float
    width: int

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.on_mjx.robot

    @property
    def catalogue(self) -> Catalogue:
        """The effects that `values` have an entry for."""
        return self.on_mjx.catalogue

    def home(self, values: Values) -> BodyState:
        """The states of robots in their home posture, at rest, for values (robots, n_sites, n_parameters)."""
        model, n = self.robot.model, _size(values)
        zeros = partial(np.zeros, dtype=np.float32)
        qpos = self.robot.home().astype(np.float32)
        centre = self.interface.ctrl_centre.astype(np.float32)
        now = Now(qpos, zeros(model.nv), centre, np.ones(model.nu), model.opt.timestep)
        hidden = jax.vmap(lambda v: self.on_mjx.rested(self.on_mjx.model, v, jax.tree.map(jnp.asarray, now)))(values)
        one = (qpos, zeros(model.nv), zeros(model.nv), zeros(model.nsensordata))
        place, speed, warmstart, sensordata = (np.broadcast_to(x, (n, *x.shape)) for x in one)
        return BodyState(place, speed, warmstart, sensordata, hidden)

    def settle(self, values: Values, steps: int) -> BodyState:
        """Let robots come to rest with all motors at home: the state a trial starts from.

        Args:
            values: (robots, n_sites, n_parameters) for each effect.
            steps: control steps.
        """
        n = _size(values)
        start = self.home(values)
        weights = np.zeros((n, self._n_weights), np.float32)
        return self._run(values, weights, start, steps, active=False).final

    def walk(self, values: Values, weights: np.ndarray, start: BodyState, steps: int) -> Walk:
        """Drive robots by their networks.

        Args:
            values: (robots, n_sites, n_parameters) for each effect.
            weights: (robots, n_weights).
            start: batched states, as `settle` gives them.
            steps: control steps, at most `rows`.
        """
        return self._run(values, weights, start, steps, active=True)

    @property
    def _n_weights(self) -> int:
        i, o = self.interface.n_inputs, self.interface.n_outputs
        return HIDDEN * (i + 1 + HIDDEN) + o * (HIDDEN + 1)

    def _run(self, values: Values, weights: np.ndarray, start: BodyState, steps: int, *, active: bool) -> Walk:
        if not 0 < steps <= self.rows:
            raise ValueError(f"{steps} steps do not fit into 1..{self.rows}")
        lanes = _Lane(values, np.asarray(weights, np.float32), start)
        walk = in_chunks(lambda part: _walk_batch(self, part, steps, active), lanes, self.width)
        return walk._replace(**{k: getattr(walk, k)[:, :steps] for k in ("readings", "commands", "position")})


def walker(
    robot: Robot,
    catalogue: Catalogue,
    *,
    rows: int,
    control_step: float,
    gain: float = 3.0,
    width: int = 50,
) -> Walker:
    """Compile-ready simulator of a robot in closed loop.

    Args:
        robot: the nominal robot.
        catalogue: effects that may be planted; none of them a `CommandShift` or `ReadingShift`.
        rows: longest walk, control steps.
        control_step: s; rounded to whole physics steps.
        gain: of the neurons' tanh.
        width: robots in a chunk.
    """
    late = [e.name for e in catalogue if isinstance(e, CommandShift | ReadingShift)]
    if late:
        raise ValueError(f"not simulated in closed loop: {', '.join(late)}")
    substeps = max(1, round(control_step / robot.model.opt.timestep))
    return Walker(mjx_model(robot, catalogue), interface_of(robot), rows, substeps, gain, width)


def _size(values: Values) -> int:
    return next(iter(values.values())).shape[0]


@partial(jax.jit, static_argnums=0)
def _walk_batch(self: Walker, lanes: _Lane, steps: int, active: bool) -> Walk:
    return jax.vmap(lambda lane: _walk_one(self, lane, steps, active))(lanes)


def _walk_one(self: Walker, lane: _Lane, steps: int, active: bool) -> Walk:
    """One robot's walk; `steps` and `active` are traced, so that every trial and settling share one executable."""
    model = self.on_mjx.edited(self.on_mjx.model, lane.values)
    network = _network(self, lane)
    travel = travel_of(self.robot)
    rows, face = self.rows, self.interface
    walk = Walk(
        readings=jnp.zeros((rows, face.n_inputs)),
        commands=jnp.zeros((rows, face.n_outputs)),
        position=jnp.zeros((rows, 3)),
        final=lane.start,
        failed=jnp.asarray(False),
    )

    def control_step(row, carry):  # noqa: ANN001, ANN202
        walk, hidden = carry
        body = walk.final
        readings = _readings(self, lane.values, body)
        hidden, outputs = respond(network, hidden, face.inputs(readings), self.gain)
        ctrl = jnp.where(active, face.commands(outputs), face.ctrl_centre)
        walk = walk._replace(
            readings=walk.readings.at[row].set(readings),
            commands=walk.commands.at[row].set(ctrl),
            position=walk.position.at[row].set(travel(body.qpos)),
            final=jax.lax.fori_loop(
                0, self.substeps, lambda _, b: _physics_step(self, model, lane.values, b, ctrl), body
            ),
        )
        return walk, hidden

    walk, _ = jax.lax.fori_loop(0, steps, control_step, (walk, jnp.zeros(HIDDEN)))
    return walk._replace(failed=~(_sound(walk.final.qpos) & _sound(walk.final.qvel)))


def _sound(x: jax.Array) -> jax.Array:
    """Whether MuJoCo's C engine would go on with these numbers."""
    return jnp.all(jnp.abs(x) < mujoco.mjMAXVAL)  # false for NaN


def _network(self: Walker, lane: _Lane) -> Network:
    network = decode(lane.weights, self.interface.n_inputs, self.interface.n_outputs)
    for effect in self.catalogue:
        if isinstance(effect, ControllerFault):
            network = effect.damage(self.robot, network, lane.values[effect.name])
    return network


def _readings(self: Walker, values: Values, body: BodyState) -> jax.Array:
    """Readings (n_inputs,) as the controller gets them: those of lost parts at rest, faults applied."""
    face = self.interface
    true = face.readings(body.qpos, body.sensordata)
    if "part_lost" in values:
        gone = jnp.clip(values["part_lost"][:, 0] @ jnp.asarray(face.lost, true.dtype), 0.0, 1.0)
        true = jnp.where(gone > 0.5, face.rest, true)
    whole = body.sensordata.at[face.columns].set(true)
    for effect in self.catalogue:
        if isinstance(effect, Distortion):
            whole = effect.distort(self.robot, whole, values[effect.name])
    return whole[face.columns]


def _physics_step(self: Walker, model: mjx.Model, values: Values, body: BodyState, ctrl: jax.Array) -> BodyState:
    does = self.on_mjx.acted(model, values, body.hidden, _now(self, model, body, ctrl))
    data = self.on_mjx.data.replace(qpos=body.qpos, qvel=body.qvel, qacc_warmstart=body.warmstart)
    data = mjx.step(does.model, data.replace(ctrl=does.ctrl, qfrc_applied=does.force, xfrc_applied=does.pull))
    return BodyState(data.qpos, data.qvel, data.qacc_warmstart, data.sensordata, does.hidden)


def _now(self: Walker, model: mjx.Model, body: BodyState, ctrl: jax.Array) -> Now:
    return Now(body.qpos, body.qvel, ctrl, jnp.ones(self.interface.n_outputs), model.opt.timestep)
