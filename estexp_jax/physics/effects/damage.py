"""What recovery asks of effects: the amounts of a damage, and how far an undamaged robot is off its model."""

from __future__ import annotations

import abc
from typing import ClassVar, NamedTuple

from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.model.robot import Robot


class Amounts(NamedTuple):
    """Amounts of a damage that are searched: lowest, highest, and those tried first."""

    low: float
    high: float
    tried: tuple[float, ...]


SHARE = Amounts(0.0, 1.0, (0.2, 0.4, 0.7, 1.0))
"""A share of something that is lost."""
PRESENT = Amounts(1.0, 1.0, (1.0,))
"""Of a damage that is there or not."""


class Damage(Effect):
    """A modification of the simulator that the estimation of a damaged robot chooses from, with one amount a place.

    Source: Bongard and Lipson 2004, section 2.2, "The Estimation Phase".
    """

    #: Amounts of the full catalogue.
    amounts: ClassVar[Amounts] = SHARE
    #: Amounts of the paper's catalogue, where these differ.
    paper_amounts: ClassVar[Amounts | None] = None
    #: Number in the paper's genome, of its six modifications.
    gene: ClassVar[int | None] = None
    #: Whether it does something even at an amount of 0.
    acts_at_zero: ClassVar[bool] = False

    @abc.abstractmethod
    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        """Its parameters at an amount.

        Args:
            robot: the nominal robot.
            site: where it acts.
            amount: of the damage; a percentage is a share of 1.
            partner: 1 + index of the element that its first parameter refers to; 0 where it refers to none.
        """

    def amount_of_gene(self, value: float) -> float:
        """The amount that the last value in [-1, 1] of a gene of the paper's genome stands for."""
        return float((value + 1.0) / 2.0)

    def combine(self, a: float, b: float) -> float:
        """The amount that does the same as two at one place."""
        return a + b

    def damages(self, robot: Robot, site: str) -> bool:
        """Whether it is a damage at a site."""
        return True


class ModelError(Effect):
    """A value of the model in which simulators of undamaged robots are a little off."""

    @abc.abstractmethod
    def off_by(self, robot: Robot, site: str, error: float) -> dict[str, float]:
        """Its parameters where the model's value is off by a relative error."""
