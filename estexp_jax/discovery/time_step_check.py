"""Whether the simulator's own time step is what makes it differ."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import Explanation, Selection, p_value
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.effects.catalogue.time_step import TimeStep

_PLAIN = 0.022
"""An error over the readings' range (nrmse) below which ordinary steps cause what they cause everywhere."""
_ALONE = 0.3
"""Share of the nominal simulator's error that may remain once its step's error is taken out."""
_ORDINARY = 0.005
"""Longest step of ordinary models of robots, s: MuJoCo's own is 2 ms, and those of robots to buy have 1 to 5 ms."""
_PLAINLY = 2.0
"""Factor by which a longer step must increase what the best values of the model leave."""


@final
@dataclass(frozen=True, eq=False)
class Step:
    """The error that the simulator's step makes.

    Attributes:
        length: the step, s.
        mended, stepped: what the best values of the model leave of the fitted windows, without and with that error.
    """

    length: float
    mended: Explanation
    stepped: Explanation

    @property
    def times(self) -> float:
        """By which factor it increases what is left."""
        return self.stepped.error / self.mended.error

    def entry(self) -> dict[str, Any]:
        """Its entry in `what`: the step at which its error would be no more than what is left without it.

        The error grows in proportion to the step. No interval: the step is a rule, not a measurement.
        """
        e, step = TimeStep(), self.length / self.times
        return {
            "effect": e.name,
            "kind": e.kind,
            "name": None,
            "probability": 1.0,
            "in_mjcf": True,
            "sentence": e.sentence("", {"step": step}),
            "equation": e.equation,
            "parameters": {"step": {"value": step, "low": None, "high": None, "unit": "s"}},
        }

    def place(self) -> dict[str, Any]:
        """Its entry in `where`."""
        share = 1.0 - float(self.mended.held_out.sum() / self.stepped.held_out.sum())
        return {"kind": "numerics", "name": None, "share": share, "p_value": p_value(self.mended, self.stepped)}


def step_of(problem: Problem, fitted: Fit) -> Step:
    """The error of the step at the best values of the model."""

    def left(p: Problem) -> Explanation:
        return Explanation(fitted, np.square(p.residuals([fitted.member], p.fitted)[0], dtype=float).sum(axis=-1))

    mended, stepped = left(problem.corrected([fitted.member])), left(replace(problem, lacking=0.0))
    return Step(float(problem.replayer.robot.model.opt.timestep), mended, stepped)


def to_blame(step: Step, selection: Selection, nominal: float) -> bool:
    """Whether the step makes most of a plain mismatch.

    A step longer than ordinary ones is suspected first: it need not make more of the error than wrong values do, only
    much more than is left once these are mended.

    Args:
        step: its error.
        selection: what was tried; nothing was claimed.
        nominal: error of the nominal simulator on the training windows, an nrmse.
    """
    if step.length > _ORDINARY and step.times > _PLAINLY:
        return True
    return nominal > _PLAIN and selection.corrected.error < _ALONE * selection.nominal.error
