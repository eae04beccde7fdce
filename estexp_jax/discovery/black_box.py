"""The black box: a small network learns the force that the joints lack. It predicts, and it explains nothing.

Inputs are positions, speeds, commands and motor torques of all driven joints; outputs the missing forces there. Two
hidden layers of tanh, trained on the force residual of a simulator, refitted or not; the best network on windows held
out from training counts, the silent one among them. Judged like any rival: by simulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import optax

from estexp_jax.discovery.force_residual import ForceResidual, driven
from estexp_jax.physics.model.actuators import actuator_of_input

_HIDDEN = 32
_ROUNDS, _STEPS, _BATCH = 12, 100, 512
_RATE, _DECAY = 5e-3, 1e-4
_JOLT = 3.0
"""Deviations of the force beyond which errors count linearly (Huber): jolts are smeared by smoothing."""
_BEYOND = 0.25
"""Share of an input's range in training by which it may leave it; further on the force stays what it is there."""
_EVERY = 4
"""One window in so many is held out from training."""

Weights = list[tuple[jax.Array, jax.Array]]
"""Matrix and offset of each layer."""


@final
@dataclass(frozen=True, eq=False)
class BlackBox:
    """A trained network.

    Attributes:
        dofs: (n,) degrees of freedom that it acts on.
        places: (n,) addresses of their positions.
        motors: commands that it sees.
        low, high: (inputs,) range of the inputs.
        scale: (n,) unit of the outputs, N m or N.
        weights: of the layers.
    """

    dofs: np.ndarray
    places: np.ndarray
    motors: np.ndarray
    low: np.ndarray
    high: np.ndarray
    scale: np.ndarray
    weights: list[tuple[np.ndarray, np.ndarray]]

    def __call__(self, qpos: np.ndarray, qvel: np.ndarray, ctrl: np.ndarray, motor: np.ndarray) -> np.ndarray:
        """Force (lanes, nv) on the joints, as a `c_replay.Law`."""
        force = np.zeros_like(qvel)
        seen = np.concatenate([qpos[:, self.places], qvel[:, self.dofs], ctrl[:, self.motors], motor[:, self.dofs]], 1)
        x = (np.clip(seen, self.low, self.high) - self.low) / (self.high - self.low) * 2.0 - 1.0
        for matrix, offset in self.weights[:-1]:
            x = np.tanh(x @ matrix + offset)
        matrix, offset = self.weights[-1]
        force[:, self.dofs] = self.scale * (x @ matrix + offset)
        return force


def trained(model: mujoco.MjModel, residuals: Sequence[ForceResidual], window: float, seed: int) -> BlackBox | None:
    """A network for the force residual of training recordings; None where no motor's joint was seen to move.

    Args:
        model: any of the recordings' models: joints and motors count.
        residuals: one for each training recording.
        window: length of the stretches of time that are held out, s.
        seed: of the weights and batches.
    """
    dofs = driven(model, residuals)
    if not len(dofs):
        return None
    joints = model.dof_jntid[dofs]
    on_joint = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
    drives = on_joint & np.isin(model.actuator_trnid[:, 0], joints)
    motors = np.flatnonzero(drives[actuator_of_input(model)])
    places = model.jnt_qposadr[joints]
    seen = np.concatenate(
        [
            np.concatenate([r.qpos[:, places], r.qvel[:, dofs], r.ctrl[:, motors], r.motor[:, dofs]], 1)
            for r in residuals
        ]
    )
    force = np.concatenate([r.force[:, dofs] for r in residuals])
    span = np.maximum(np.ptp(seen, axis=0), 1e-9)
    low, high = seen.min(axis=0) - _BEYOND * span, seen.max(axis=0) + _BEYOND * span
    scale = np.maximum(force.std(axis=0), 1e-12)
    stretch = np.concatenate([(i + (r.time - r.time[0]) // window).astype(int) for i, r in enumerate(residuals)])
    held = stretch % _EVERY == 0 if np.any(stretch % _EVERY) else np.arange(len(stretch)) % 2 == 0
    x, y = (seen - low) / (high - low) * 2.0 - 1.0, force / scale
    weights = _learned(_Samples(x[~held], y[~held]), _Samples(x[held], y[held]), seed)
    return BlackBox(dofs, places, motors, low, high, scale, [(np.asarray(m), np.asarray(o)) for m, o in weights])


class _Samples(NamedTuple):
    x: np.ndarray  # (samples, inputs) between -1 and 1
    y: np.ndarray  # (samples, outputs) in deviations


def _learned(fitted: _Samples, held: _Samples, seed: int) -> Weights:
    """The weights that predict held-out samples best, of those at the start and after each round."""
    key = jax.random.PRNGKey(seed)
    weights = _first(key, fitted.x.shape[1], fitted.y.shape[1])
    optimiser = optax.adamw(optax.cosine_decay_schedule(_RATE, _ROUNDS * _STEPS), weight_decay=_DECAY)
    state, best, least = optimiser.init(weights), weights, float(_loss(weights, *_single(held)))
    samples = _single(fitted)
    for round_ in range(_ROUNDS):
        weights, state = _round(optimiser, weights, state, samples, jax.random.fold_in(key, round_))
        loss = float(_loss(weights, *_single(held)))
        if loss < least:
            best, least = weights, loss
    return best


def _single(samples: _Samples) -> _Samples:
    return _Samples(samples.x.astype(np.float32), samples.y.astype(np.float32))


def _first(key: jax.Array, n_inputs: int, n_outputs: int) -> Weights:
    """Random hidden layers, and an output that is silent."""
    sizes = (n_inputs, _HIDDEN, _HIDDEN)
    layers = [
        (jax.random.normal(k, (m, n)) / np.sqrt(m), jnp.zeros(n))
        for k, m, n in zip(jax.random.split(key), sizes[:-1], sizes[1:], strict=True)
    ]
    return [*layers, (jnp.zeros((_HIDDEN, n_outputs)), jnp.zeros(n_outputs))]


@jax.jit
def _loss(weights: Weights, x: jax.Array, y: jax.Array) -> jax.Array:
    for matrix, offset in weights[:-1]:
        x = jnp.tanh(x @ matrix + offset)
    matrix, offset = weights[-1]
    return jnp.mean(optax.huber_loss(x @ matrix + offset, y, delta=_JOLT))


@partial(jax.jit, static_argnums=0)
def _round(
    optimiser: optax.GradientTransformation,
    weights: Weights,
    state: optax.OptState,
    samples: _Samples,
    key: jax.Array,
) -> tuple[Weights, optax.OptState]:
    """Weights and the optimiser's state after some steps on random samples."""

    def step(carry: tuple[Weights, optax.OptState], key: jax.Array) -> tuple[tuple[Weights, optax.OptState], None]:
        weights, state = carry
        drawn = jax.random.randint(key, (_BATCH,), 0, len(samples.x))
        slope = jax.grad(_loss)(weights, samples.x[drawn], samples.y[drawn])
        change, state = optimiser.update(slope, state, weights)
        return (optax.apply_updates(weights, change), state), None  # pyright: ignore[reportReturnType]

    return jax.lax.scan(step, (weights, state), jax.random.split(key, _STEPS))[0]
