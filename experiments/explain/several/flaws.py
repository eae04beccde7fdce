"""Flaws of real arms that no name fits, drawn in the scales of an arm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, final

import mujoco
import numpy as np

from experiments.explain.several.arms import Arm, home

MOUNT = "soft_mount"
_AT_THE_JOINT = ("unknown_law",)
_OF_THE_BASE = ("mount_compliance", "unknown_law")


@final
@dataclass(frozen=True)
class Flaw:
    """What is wrong besides.

    Attributes:
        name: one of `FLAWS`, or empty: nothing.
        joint: where; None: the base.
        depth: by how much friction varies, relative to its mean, or inertia, relative to the joint's; 0: a mount.
        waves: how often in a radian.
        phase: rad.
        inertia: of the joint, kg m2, where it varies.
        mount: stiffness (N m/rad) and damping (N m s/rad) about x and y.
    """

    name: str = ""
    joint: int | None = None
    depth: float = 0.0
    waves: float = 0.0
    phase: float = 0.0
    inertia: float = 0.0
    mount: Mapping[str, float] = field(default_factory=dict)

    def friction(self, q: np.ndarray) -> np.ndarray:
        """By how much a joint's friction differs at its position, relative to the mean."""
        return self.depth * np.sin(self.waves * q + self.phase)

    def rotor(self, q: float, w: float) -> tuple[float, float]:
        """What the linkage adds to the rotor's inertia, and its torque, which follows from the inertia's slope."""
        angle = self.waves * q + self.phase
        slope = self.inertia * self.depth * self.waves * np.cos(angle)
        return self.inertia * self.depth * float(np.sin(angle)), float(-0.5 * slope * w * w)


def drawn_flaw(name: str, joint: int, arm: Arm, rng: np.random.Generator) -> Flaw:
    """Draw a flaw; its joint is given, as the maker knows that joint's mean friction."""
    if name == MOUNT:
        stiffness = arm.inertia.sum() * (2.0 * np.pi * rng.uniform(5.0, 9.0)) ** 2
        return Flaw(name, mount={"k": stiffness, "d": 0.1 * np.sqrt(stiffness * arm.inertia.sum())})
    if name == "friction_along_path":
        depth, waves = rng.uniform(0.5, 0.9), rng.uniform(2.0, 6.0)
        return Flaw(name, joint, depth, waves, _even(waves, joint, arm, rng))
    depth, waves = rng.uniform(0.05, 0.12), rng.uniform(1.0, 3.0)
    return Flaw(name, joint, depth, waves, _even(waves, joint, arm, rng), float(arm.inertia[joint]))


def _even(waves: float, joint: int, arm: Arm, rng: np.random.Generator) -> float:
    """A phase with which as much is added on one side of the home pose as is taken off on the other.

    So what the model knows remains the mean along the path, and a claim that it is another one is wrong.
    """
    return float(np.pi * round(rng.uniform()) - waves * home(arm.joints)[joint])


def soften(spec: mujoco.MjSpec, flaw: Flaw) -> None:
    """Let the base tilt about two axes."""
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) if flaw.mount else ():
        hinge = spec.body("base").add_joint(axis=axis)
        hinge.stiffness, hinge.damping = [flaw.mount["k"], 0.0, 0.0], [flaw.mount["d"], 0.0, 0.0]


def names_flaw(claim: Mapping[str, Any], axis: str | None, flaw: Mapping[str, Any]) -> bool:
    """Whether a claim says the flaw: a law in an equation at its joint, or a mount that gives.

    Args:
        claim: of the findings.
        axis: the joint that it belongs to.
        flaw: as in the answer.
    """
    if flaw["joint"] is None:
        return claim["effect"] in _OF_THE_BASE
    return claim["effect"] in _AT_THE_JOINT and axis == f"j{flaw['joint'] + 1}"
