"""The paper's controller and the closed loop in plain numpy over the C engine, written apart from the package's."""

from dataclasses import dataclass, field

import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot
from tests.physics.reference import Mapping, mapping

N_INPUTS, N_HIDDEN, N_MOTORS, GAIN = 8, 3, 8, 3.0
N_WEIGHTS = N_HIDDEN * (N_INPUTS + 1) + N_HIDDEN**2 + N_MOTORS * (N_HIDDEN + 1)


@dataclass
class Twin:
    """One quadruped's controller with its faults.

    Attributes:
        weights: (68,).
        neuron_gain: of the hidden neurons.
        tied: motor -> motor whose command it repeats.
        sensor_gain: (8,) of touch f l b r, angle f l b r.
    """

    weights: np.ndarray
    neuron_gain: np.ndarray = field(default_factory=lambda: np.ones(N_HIDDEN))
    tied: dict[int, int] = field(default_factory=dict)
    sensor_gain: np.ndarray = field(default_factory=lambda: np.ones(N_INPUTS))

    def __post_init__(self) -> None:
        self.hidden = np.zeros(N_HIDDEN)

    def respond(self, readings: np.ndarray) -> np.ndarray:
        """Commands of the 8 servos, rad."""
        inputs = np.clip(readings / ([1.0] * 4 + [np.pi / 4] * 4), -1.0, 1.0)
        w = iter(self.weights)
        first = np.array([[next(w) for _ in range(N_INPUTS + 1)] for _ in range(N_HIDDEN)])
        again = np.array([[next(w) for _ in range(N_HIDDEN)] for _ in range(N_HIDDEN)])
        second = np.array([[next(w) for _ in range(N_HIDDEN + 1)] for _ in range(N_MOTORS)])
        drive = first[:, :-1] @ inputs + first[:, -1] + again @ self.hidden
        self.hidden = np.tanh(GAIN * drive) * self.neuron_gain
        motors = np.tanh(GAIN * (second[:, :-1] @ self.hidden + second[:, -1]))
        for motor, other in self.tied.items():
            motors[motor] = np.tanh(GAIN * (second[other, :-1] @ self.hidden + second[other, -1]))
        return np.pi / 4 * motors


@dataclass
class Body:
    """A quadruped in the C engine, whole or with parts gone.

    Attributes:
        robot: the nominal one.
        model: the changed, compiled one.
    """

    robot: Robot
    model: mujoco.MjModel

    def __post_init__(self) -> None:
        self.where: Mapping = mapping(self.robot, self.model)
        self.data = mujoco.MjData(self.model)

    def place(self, qpos: np.ndarray, qvel: np.ndarray, warmstart: np.ndarray, touch: np.ndarray) -> None:
        """Put it into a state of the nominal robot's size; `touch` is what its four sensors show at first."""
        self.data.qpos[:] = qpos[self.where.qpos]
        self.data.qvel[:] = qvel[self.where.dof]
        self.data.qacc_warmstart[:] = warmstart[self.where.dof]
        for name, value in zip("flbr", touch, strict=True):
            if self._has(f"touch_{name}"):
                self.data.sensor(f"touch_{name}").data[:] = value

    def readings(self) -> np.ndarray:
        """Touch of the last physics step as +-1, knee angles of the present configuration; of lost legs -1 and 0."""
        touch = [self._has(f"touch_{n}") and self.data.sensor(f"touch_{n}").data[0] > 0.0 for n in "flbr"]
        angles = [self.data.joint(f"knee_{n}").qpos[0] if self._has(f"touch_{n}") else 0.0 for n in "flbr"]
        return np.array([1.0 if t else -1.0 for t in touch] + angles)

    def step(self, commands: np.ndarray) -> None:
        """One control step: four physics steps."""
        self.data.ctrl[:] = commands[self.where.actuator]
        for _ in range(4):
            mujoco.mj_step(self.model, self.data)

    def _has(self, sensor: str) -> bool:
        return mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_SENSOR, sensor) >= 0
