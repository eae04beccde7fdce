"""A robot in the world with a reality gap: another engine, errors in every parameter, and sensor noise.

It is simulated by MuJoCo's C engine at a quarter of the physics step. Masses with their inertias, motor gains, joint
dampings and contact frictions have random relative errors of 3 %. Encoders have 12 bits a turn and noise of 0.005 rad;
2 % of the touch readings flip their sign. Damage is planted by recompiling the model. The robot settles before each
trial.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.base import Distortion, Edit
from estexp_jax.physics.effects.changes import Change, encode
from estexp_jax.physics.effects.controller_fault import ControllerFault
from estexp_jax.physics.effects.registry import catalogue, effect
from estexp_jax.physics.engines.controller_interface import Interface
from estexp_jax.physics.model.robot import Robot, spec_element
from estexp_jax.physics.model.travel import root_position_map
from estexp_jax.recovery.control.network import Network
from estexp_jax.recovery.control.trial import Controller, Trial, controller_step

_RELATIVE_ERROR, _SUBSTEPS = 0.03, 4
_NOISE, _BITS, _FLIPS = 0.005, 12, 0.02
_TAG = 17


@final
class RealityGapTarget:
    """A `Target` with a reality gap: see the module.

    Its noise depends on seed and controller only, so that a resumed run gets the same trials.

    Args:
        robot: the nominal robot.
        planted: the damage: edits, sensor faults and controller faults.
        seed: of its errors and noise.
        settle_steps: control steps with motors at home before a trial.

    Raises:
        InputError: a planted effect cannot be written into MJCF.
    """

    def __init__(self, robot: Robot, planted: Sequence[Change], seed: int, settle_steps: int) -> None:
        self._robot, self._planted, self._seed, self._settle = robot, tuple(planted), seed, settle_steps
        self._model = _damaged(robot, self._planted, np.random.default_rng([seed, _TAG]))
        self._map = _CoordinateMap(robot, self._model)

    def __call__(self, controller: Controller) -> Trial:
        """See `Target`."""
        return self._simulate(controller)[0]

    def motion(self, controller: Controller, rows: Sequence[int]) -> np.ndarray:
        """See `FilmedTarget`."""
        return self._simulate(controller)[1][list(rows)]

    def _simulate(self, controller: Controller) -> tuple[Trial, np.ndarray]:
        """A trial, and its configurations (rows, nq)."""
        face, model, shape = controller.interface, self._model, (controller.steps,)
        random = np.random.default_rng([self._seed, _TAG, zlib.crc32(np.asarray(controller.weights, "<f4").tobytes())])
        data, repeats = self._at_rest(face, controller.control_step)
        network, hidden, faults = self._network(controller), controller.rest(), self._faults(face)
        readings, commands = np.zeros((*shape, face.n_inputs)), np.zeros((*shape, face.n_outputs))
        position, path = np.zeros((*shape, 3)), np.zeros((*shape, self._robot.model.nq))
        matrix, offset = root_position_map(self._robot)
        for row in range(controller.steps):
            qpos, sensordata = self._map.qpos(data), self._map.sensordata(data, face)
            position[row], path[row] = matrix @ qpos + offset, qpos
            readings[row] = self._sensed(face, self._map.true(face, qpos, sensordata), faults, random)
            hidden, commands[row] = controller_step(network, face, controller.gain, hidden, readings[row])
            data.ctrl[:] = commands[row, self._map.actuators]
            mujoco.mj_step(model, data, repeats)
        return Trial(controller.control_step * np.arange(controller.steps), readings, commands, position), path

    def _at_rest(self, face: Interface, control_step: float) -> tuple[mujoco.MjData, int]:
        data = mujoco.MjData(self._model)
        data.qpos[self._map.here] = self._robot.home()[self._map.there]
        data.ctrl[:] = face.ctrl_centre[self._map.actuators]
        repeats = max(1, round(control_step / self._model.opt.timestep))
        mujoco.mj_step(self._model, data, repeats * self._settle)
        return data, repeats

    def _network(self, controller: Controller) -> Network:
        network = controller.network()
        for e, values in self._values(ControllerFault):
            network = e.damage(self._robot, network, jnp.asarray(values))
        return jax.tree.map(np.asarray, network)

    def _faults(self, face: Interface) -> tuple[np.ndarray, np.ndarray]:
        """Scale and shift (n_inputs,) of the planted sensor faults; all are affine in the reading."""

        def distorted(x: float) -> np.ndarray:
            whole = jnp.full(self._robot.model.nsensordata, x)
            for e, values in self._values(Distortion):
                whole = e.distort(self._robot, whole, jnp.asarray(values))
            return np.asarray(whole, float)[face.columns]

        return distorted(1.0) - distorted(0.0), distorted(0.0)

    def _sensed(
        self, face: Interface, true: np.ndarray, faults: tuple[np.ndarray, np.ndarray], random: np.random.Generator
    ) -> np.ndarray:
        """Noise and quantization first, then the planted faults of the reading."""
        angles = true + _NOISE * random.standard_normal(face.n_inputs)
        step = 2.0 * np.pi / 2**_BITS
        flips = np.where(random.random(face.n_inputs) < _FLIPS, -1.0, 1.0)
        quantized = np.where(face.is_touch, true * flips, np.round(angles / step) * step)
        return np.where(self._map.lost_input(face), face.rest, quantized) * faults[0] + faults[1]

    def _values(self, kind: type) -> list[tuple]:
        mine = [c for c in self._planted if isinstance(effect(c.effect), kind)]
        effects = catalogue(dict.fromkeys(c.effect for c in mine))
        values = encode(self._robot, effects, mine)
        return [(e, values[e.name]) for e in effects]


@final
class _CoordinateMap:
    """Maps coordinates, motors and sensors of a model that may have lost parts to the nominal robot's."""

    def __init__(self, robot: Robot, model: mujoco.MjModel) -> None:
        self._robot = robot
        damaged = Robot(robot.spec, model, robot.source)
        joints = [(robot.index("joint", name), damaged.index("joint", name)) for name in damaged.names("joint")]
        ranges = [(_addresses(robot.model, there), _addresses(model, here)) for there, here in joints]
        self.there = np.concatenate([there for there, _ in ranges])
        self.here = np.concatenate([here for _, here in ranges])
        self.actuators = [robot.index("actuator", name) for name in damaged.names("actuator")]
        self._sensors = {robot.index("sensor", n): i for i, n in enumerate(damaged.names("sensor"))}
        self._model = model

    def qpos(self, data: mujoco.MjData) -> np.ndarray:
        """The configuration (nq,) in the nominal robot's coordinates; lost joints at home."""
        qpos = self._robot.home()
        qpos[self.there] = data.qpos[self.here]
        return qpos

    def sensordata(self, data: mujoco.MjData, face: Interface) -> np.ndarray:
        """Sensor values (nsensordata,) in the nominal robot's order; zero where lost."""
        whole = np.zeros(self._robot.model.nsensordata)
        for there, here in self._sensors.items():
            a, b, n = self._robot.model.sensor_adr[there], self._model.sensor_adr[here], self._model.sensor_dim[here]
            whole[a : a + n] = data.sensordata[b : b + n]
        return whole

    def true(self, face: Interface, qpos: np.ndarray, sensordata: np.ndarray) -> np.ndarray:
        """Raw readings without noise: touch as +1/-1."""
        touch = np.where(sensordata[face.columns] > 0.0, 1.0, -1.0)
        return np.where(face.is_touch, touch, qpos[face.qpos])

    def lost_input(self, face: Interface) -> np.ndarray:
        """Whether each input has lost its sensor, (n_inputs,) bool."""
        return np.array([self._robot.index("sensor", name) not in self._sensors for name in face.names])


def _addresses(model: mujoco.MjModel, joint: int) -> np.ndarray:
    width = {int(mujoco.mjtJoint.mjJNT_FREE): 7, int(mujoco.mjtJoint.mjJNT_BALL): 4}
    return int(model.jnt_qposadr[joint]) + np.arange(width.get(int(model.jnt_type[joint]), 1))


def _damaged(robot: Robot, planted: Sequence[Change], random: np.random.Generator) -> mujoco.MjModel:
    """The compiled model with the damage in it and random errors of its parameters."""
    spec = robot.spec.copy()
    for key in list(spec.keys):
        spec.delete(key)
    _name_all(robot, spec)
    # Bodies are deleted last, so that every other edit finds its element.
    for change in sorted(planted, key=lambda c: effect(c.effect).removes_part):
        e = effect(change.effect)
        if isinstance(e, Edit):
            if not e.in_mjcf:
                raise InputError(f"'{e.name}' cannot be written into MJCF", where="--damage", right="--robot same")
            e.write_mjcf(robot, spec, change.name or "", change.values)
        elif not isinstance(e, Distortion | ControllerFault):
            raise InputError(f"the foreign robot cannot carry '{e.name}'", where="--damage", right="--robot same")
    model = spec.compile()
    model.opt.timestep = robot.model.opt.timestep / _SUBSTEPS
    _perturb(model, random)
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def _name_all(robot: Robot, spec: mujoco.MjSpec) -> None:
    """Give every element a name, by which it is found again after parts are lost."""
    for kind in ("joint", "actuator", "sensor"):
        for name in robot.names(kind):
            spec_element(spec, robot, kind, name).name = name


def _perturb(model: mujoco.MjModel, random: np.random.Generator) -> None:
    def off(n: int) -> np.ndarray:
        return 1.0 + _RELATIVE_ERROR * random.standard_normal(n)

    mass, gain = off(model.nbody), off(model.nu)
    model.body_mass[:] *= mass
    model.body_inertia[:] *= mass[:, None]
    model.actuator_gainprm[:] *= gain[:, None]
    model.actuator_biasprm[:] *= gain[:, None]
    model.dof_damping[:] *= off(model.nv)
    model.geom_friction[:] *= off(model.ngeom)[:, None]
