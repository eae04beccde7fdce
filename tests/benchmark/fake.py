"""An engine that only counts."""

import numpy as np

from estexp_jax.benchmark.engines import Runner
from estexp_jax.physics.engines.closed_loop_agreement import Agreement, engine_agreement


class Fake(Runner):
    """An engine that says how wrong it is."""

    def __init__(self, name: str, error: float = 0.0) -> None:
        self.name, self.robots, self.steps, self.error, self.walks = name, 3, 6, error, []

    def simulate(self, robots: int, steps: int) -> None:
        self.walks.append((robots, steps))

    def agreement(self) -> Agreement:
        return engine_agreement(np.full((4, 2), self.error), np.zeros((4, 2)), 2)
