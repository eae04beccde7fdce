"""Softness of a constraint: its impedance, spring and damper by solref and solimp, and the stiffness of its rows.

Source: MuJoCo documentation, "Computation": "Constraint model", "Parameters".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import Scalar, is_number, maximum
from estexp_jax.lanes.model_parameters import ModelParameters


@final
@dataclass(frozen=True, eq=False)
class Softness:
    """solref and solimp of alike constraints.

    Attributes:
        ref: two scalars.
        imp: five.
    """

    ref: tuple[Scalar, ...]
    imp: tuple[Scalar, ...]

    @classmethod
    def of(cls, params: ModelParameters, ref: np.ndarray, imp: np.ndarray) -> Softness:
        """From solref (k, 2) and solimp (k, 5)."""
        low, high = mujoco.mjMINIMP, mujoco.mjMAXIMP
        imp = imp.copy()
        imp[:, :2], imp[:, 3] = np.clip(imp[:, :2], low, high), np.clip(imp[:, 3], low, high)
        imp[:, 2] = np.maximum(imp[:, 2], mujoco.mjMINVAL)
        imp[:, 4] = np.maximum(imp[:, 4], 1.0)
        return cls(tuple(params.known(ref[:, i]) for i in range(2)), tuple(params.known(imp[:, i]) for i in range(5)))

    def impedance(self, violation: Scalar) -> Scalar:
        """d(r), between 0 and 1."""
        start, end, width, middle, power = self.imp
        x = jnp.minimum(jnp.abs(violation) / width, 1.0)
        if is_number(power, 1):
            return start + x * (end - start)
        power = int(power) if isinstance(power, float) and power.is_integer() else power
        below = x**power / middle ** (power - 1)
        above = 1.0 - (1.0 - x) ** power / (1.0 - middle) ** (power - 1)
        return start + jnp.where(x <= middle, below, above) * (end - start)

    def spring(self, dt: Scalar, *, safe: bool) -> tuple[Scalar, Scalar]:
        """The k and b of a_ref = -b v - k d r; `ref` is a time constant and a damping ratio, or minus k and b."""
        end, small = self.imp[1], mujoco.mjMINVAL
        time = maximum(self.ref[0], 2.0 * dt) if safe else self.ref[0]
        soft = maximum(end * end * time * time * self.ref[1] * self.ref[1], small)
        stiffness, damping = 1.0 / soft, 2.0 / maximum(end * time, small)
        if isinstance(self.ref[0], (int, float)):
            return (stiffness, damping) if self.ref[0] > 0 else (-self.ref[0] / (end * end), -self.ref[1] / end)
        direct = self.ref[0] <= 0
        return (
            jnp.where(direct, -self.ref[0] / (end * end), stiffness),
            jnp.where(direct, -self.ref[1] / end, damping),
        )


def regularised(weight: Scalar, impedance: Scalar) -> Scalar:
    """D of a row: impedance over (1 - impedance) times the inverse inertia it meets."""
    return impedance / (maximum(weight, mujoco.mjMINVAL) * (1.0 - impedance))
