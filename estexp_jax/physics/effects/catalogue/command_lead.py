"""Command lead: a logged command acts before its row."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, final

import numpy as np

from estexp_jax.physics.effects.base import Parameter
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.logging_fault import LoggingFault, with_commands_at
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_MOST_S = 0.2
_TRIED_S = (0.006, 0.012, 0.02, 0.03, 0.045, 0.07, 0.12, 0.2)
_BESIDE_PHYSICS_S = (0.02,)


@register_effect
@final
class CommandLead(LoggingFault):
    """The command logged at t acts at t - lead; below zero, after its row: the stamps of commands, or a delay."""

    name: ClassVar[str] = "command_lead"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("lead", "s", signed=True),)
    equation: ClassVar[str] = "u(t) = logged command(t + lead)"
    source: ClassVar[str] = "stamped when it was written down, not when it was sent"
    is_continuous: ClassVar[bool] = True
    displaces_time: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return ("",) if robot.model.nu else ()

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((-_MOST_S, _MOST_S),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        lead = values["lead"]
        when = f"{1000 * abs(lead):.3g} ms {'before' if lead > 0.0 else 'after'} their rows"
        return f"the logged commands act {when}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(lead,) for lead in _TRIED_S]

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return ("Stamp commands when they are sent and readings when they are taken, by one clock.",)

    def tried(self, robot: Robot, site: str, recording: Recording) -> Vectors:
        least = 0.5 * float(np.median(np.diff(recording.time)))
        return [(sign * lead,) for sign in (1.0, -1.0) for lead in _TRIED_S if lead >= least]

    def tried_beside_physics(self, robot: Robot, site: str, recording: Recording) -> Vectors:
        least = 0.5 * float(np.median(np.diff(recording.time)))
        return [(lead,) for lead in _BESIDE_PHYSICS_S if lead >= least]

    def is_undone(self, values: Mapping[str, float]) -> bool:
        """A command that acts late may as well be a delay of the robot, which the search finds."""
        return values["lead"] > 0.0

    def logged(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        return with_commands_at(recording, recording.time + values["lead"])

    def mended(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        return with_commands_at(recording, recording.time - values["lead"])
