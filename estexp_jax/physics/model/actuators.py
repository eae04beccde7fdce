"""Where a model's actuators have their inputs and outputs: MuJoCo's arrays count actuators, inputs, or outputs.

An actuator has one input and one output as a rule. Since MuJoCo 4 a PID controller has up to three inputs, an
orientation servo three or four and three outputs, and a passive motor none. `ctrl`, `actuator_ctrlrange` and
`actuator_ctrllimited` go by inputs, `actuator_gear` and `actuator_force` by outputs, all others by actuators.

Source: MuJoCo documentation, "Actuation model".
"""

from __future__ import annotations

import mujoco
import numpy as np

_GAINS = (int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtGain.mjGAIN_AFFINE))
_BIASES = (int(mujoco.mjtBias.mjBIAS_NONE), int(mujoco.mjtBias.mjBIAS_AFFINE))

HAS_DECLARED_INPUTS = hasattr(mujoco, "mjtCtrlInput")
"""Whether this MuJoCo is 4 or newer: PID controllers, motors that say what their inputs are, passive ones, batches."""
POSITION, VELOCITY, NO_INPUT = 1, 2, 16
"""MuJoCo's bits of inputs, `mjtCtrlInput`: a target position, a target velocity, and of passive motors none."""
_DECLARING = tuple(int(getattr(mujoco.mjtGain, f"mjGAIN_{name}")) for name in ("PID", "DCMOTOR") if HAS_DECLARED_INPUTS)
"""Gains of actuators that say what their inputs are."""


def inputs_of(model: mujoco.MjModel, actuator: int) -> range:
    """Addresses in `ctrl` of an actuator's inputs."""
    first = int(model.actuator_ctrladr[actuator])
    return range(first, first + int(model.actuator_ctrlnum[actuator]))


def first_input(model: mujoco.MjModel) -> np.ndarray:
    """Address in `ctrl` of each actuator's first input, (nactuator,); any where it has none."""
    return np.clip(model.actuator_ctrladr, 0, max(model.nu - 1, 0))


def actuator_of_input(model: mujoco.MjModel) -> np.ndarray:
    """Index of the actuator that each command goes to, (nu,)."""
    return np.repeat(np.arange(model.nactuator), model.actuator_ctrlnum)


def single_inputs(model: mujoco.MjModel) -> np.ndarray:
    """Indices of the actuators with just one input."""
    return np.flatnonzero(model.actuator_ctrlnum == 1)


def gear_of(model: mujoco.MjModel, actuator: int) -> float:
    """First number of the gear of an actuator's first output."""
    return float(model.actuator_gear[model.actuator_outadr[actuator], 0])


def affine_actuators(model: mujoco.MjModel) -> np.ndarray:
    """Whether each actuator (nactuator,) has one input, one output, and a force that is affine in its input."""
    simple = np.isin(model.actuator_gaintype, _GAINS) & np.isin(model.actuator_biastype, _BIASES)
    return simple & (model.actuator_ctrlnum == 1) & (model.actuator_outnum == 1)


def unusual_actuator(model: mujoco.MjModel) -> tuple[int, str] | None:
    """The first actuator that has not one input and one output, and what it has instead; None where all have."""
    odd = np.flatnonzero((model.actuator_ctrlnum != 1) | (model.actuator_outnum != 1))
    if not odd.size:
        return None
    n = int(model.actuator_ctrlnum[odd[0]])
    return int(odd[0]), "no input" if n == 0 else f"{n} inputs" if n > 1 else "several outputs"


def declared_inputs(model: mujoco.MjModel, actuator: int) -> tuple[int, ...]:
    """The bit of each input of a PID controller or a DC motor, in their order; empty for other actuators."""
    if int(model.actuator_gaintype[actuator]) not in _DECLARING:
        return ()
    bits = int(model.actuator_ctrlspec[actuator])
    return tuple(1 << k for k in range(bits.bit_length()) if bits >> k & 1 and 1 << k != NO_INPUT)


def position_input(model: mujoco.MjModel, actuator: int) -> int | None:
    """Address in `ctrl` of an actuator's input that is a target position; None where none is."""
    inputs = inputs_of(model, actuator)
    if not inputs:
        return None
    if int(model.actuator_gaintype[actuator]) in _DECLARING:
        return inputs[0] if POSITION in declared_inputs(model, actuator) else None
    affine = int(model.actuator_biastype[actuator]) == int(mujoco.mjtBias.mjBIAS_AFFINE)
    return inputs[0] if affine and model.actuator_biasprm[actuator, 1] != 0.0 else None
