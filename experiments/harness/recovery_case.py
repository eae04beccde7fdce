"""One run of an experiment: what happens to which robot, and how it is diagnosed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

from estexp_jax.recovery.config import Metric, NextTrial, Settings

Size = Literal["tiny", "quick", "small", "medium", "full"]
Method = Literal["paper", "set", "oracle"]

SIZES: dict[Size, dict[str, int]] = {
    "tiny": {"population": 8, "generations": 3, "steps": 60},
    "quick": {"population": 32, "generations": 5, "steps": 150},
    "small": {"population": 48, "generations": 10, "steps": 200},
    "medium": {"population": 100, "generations": 20, "steps": 500},
    "full": {"population": 200, "generations": 40, "steps": 1000},
}
"""Genomes, generations of a phase and control steps of a trial; full is the paper's, tiny shows only that it runs."""

FIRST_SEED = 5000
"""Reported runs have seeds from here on; whatever was tuned was tuned below 1000."""


@dataclass(frozen=True)
class RecoveryCase:
    """A run of the estimation-exploration algorithm.

    Attributes:
        situation: of the paper's Table 1; None: `damage` happens instead.
        seed: of the run, its places among it.
        size: see `SIZES`.
        method: the paper's genetic algorithm, the set search, or the oracle, which knows the true damage.
        metric: what a diagnosis is judged by.
        robot: the robot in the world.
        damage: changes as on the command line.
        next_trial: which controller the robot tries next.
    """

    situation: int | None
    seed: int
    size: Size = "full"
    method: Method = "paper"
    metric: Metric = "rolling-mean"
    robot: Literal["same", "foreign"] = "same"
    damage: tuple[str, ...] = ()
    next_trial: NextTrial = "farthest"

    @property
    def name(self) -> str:
        """Of its folder."""
        what = f"s{self.situation:02d}" if self.situation is not None else "d-" + self.damage[0].split()[0]
        how = self.metric if self.next_trial == "farthest" else f"{self.metric}-{self.next_trial}"
        return f"{what}-{self.method}-{how}-{self.robot}-{self.seed}"

    @property
    def settings(self) -> Settings:
        """Of the run."""
        settings = Settings(
            situation=self.situation,
            damage=self.damage,
            seed=self.seed,
            metric=self.metric,
            robot=self.robot,
            paper=self.method == "paper",
            next_trial=self.next_trial,
        )
        return replace(settings, **SIZES[self.size])

    def labels(self) -> dict[str, Any]:
        """The columns that tell it from the others in a table."""
        return {
            "situation": self.situation,
            "method": self.method,
            "metric": self.metric,
            "robot": self.robot,
            "seed": self.seed,
        }


def seeds(n: int, first: int = FIRST_SEED) -> tuple[int, ...]:
    """Those of n reported runs."""
    return tuple(range(first, first + n))
