"""A kind of effect: its class, where it belongs, how its parameters follow from a strength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.benchmark.generator.effect import Effect
from experiments.benchmark.generator.scales import Scales

Draw = Callable[[float, int, Scales, np.random.Generator], dict[str, float]]
"""Parameters from strength, index of the joint, the robot's sizes, random numbers."""


@dataclass(frozen=True)
class Kind:
    """A kind of effect.

    Attributes:
        name: as the answers call it: of the package's list, or `unknown_law`.
        kind: of its place: joint, actuator, sensor, body, environment, numerics.
        make: its class.
        draw: its parameters.
        scored: the parameters whose values are compared.
        accepted: names that count as right beside its own (a near relative has one in the catalogue).
        law: its own name where the catalogue has none.
    """

    name: str
    kind: str
    make: type[Effect]
    draw: Draw
    scored: tuple[str, ...] = ()
    accepted: tuple[str, ...] = ()
    law: str | None = None


def sign(rng: np.random.Generator) -> float:
    """Plus or minus one."""
    return float(rng.choice([-1.0, 1.0]))
