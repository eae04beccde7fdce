"""What joints feel by a law, from position, speed and motor torque: the truth, and named effects that act beside it.

Laws that depend on anything else have no entry.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

Force = Callable[[Mapping[str, float], np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""(parameters, q, w, motor torque) -> force."""


def _magnet(p: Mapping[str, float], q: np.ndarray, w: np.ndarray, m: np.ndarray) -> np.ndarray:
    x = (q - p["q0"]) / p["s"]
    return -p["A"] * x / (1.0 + x**2) ** 2


FORCES: dict[str, Force] = {
    "viscous_friction": lambda p, q, w, m: -p["c"] * w,
    "coulomb_friction": lambda p, q, w, m: -p["T"] * np.sign(w),
    "stribeck_friction": lambda p, q, w, m: -(p["T"] + p["S"] * np.exp(-((w / p["w_s"]) ** 2))) * np.sign(w),
    "load_dependent_friction": lambda p, q, w, m: -p["mu"] * np.abs(m) * np.sign(w),
    "quadratic_drag": lambda p, q, w, m: -p["c"] * np.abs(w) * w,
    "joint_stiffness": lambda p, q, w, m: -p["k"] * (q - p["q0"]),
    "cogging": lambda p, q, w, m: p["A"] * np.sin(p["n"] * q + p["phase"]),
    "torque_offset": lambda p, q, w, m: p["T"] + 0.0 * q,
    "motor_weakness": lambda p, q, w, m: -p["loss"] * m,
    "torque_saturation": lambda p, q, w, m: np.clip(m, -p["limit"], p["limit"]) - m,
    "tightening_cable": lambda p, q, w, m: -p["k"] * np.maximum(q - p["q0"], 0.0) ** 1.5,
    "fading_magnet": _magnet,
    "one_way_damper": lambda p, q, w, m: -p["c"] * np.where(w * p["way"] > 0.0, w, p["share"] * w),
    "rubber_buffer": lambda p, q, w, m: -p["k"] * p["s"] * np.sinh(q / p["s"]),
}
