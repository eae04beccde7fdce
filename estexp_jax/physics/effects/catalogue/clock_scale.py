"""Clock scale: a log's clock runs fast, or that of its readings against that of its commands."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar, final

from estexp_jax.physics.effects.base import Parameter
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.logging_fault import LoggingFault, with_commands_at
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_WHOLE = (0.5, 0.7, 0.8, 0.9, 0.95, 1.05, 1.1, 1.25, 1.45, 2.0)
_APART_S, _MOST_APART = (0.04, 0.08, 0.16, 0.25, 0.35, 0.5), 0.02
"""Two clocks: by how much they are apart at the end of a recording in trials, s; by which share at most."""


@register_effect
@final
class ClockScale(LoggingFault):
    """Logged time = factor * true time; at `*`, only that of all readings, while commands keep the true one."""

    name: ClassVar[str] = "clock_scale"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("factor", "", neutral=1.0),)
    equation: ClassVar[str] = "logged time = factor * true time"
    source: ClassVar[str] = "a nominal rate taken for the true one; two oscillators"
    is_continuous: ClassVar[bool] = True
    displaces_time: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return ("", ALL_ALIKE) if robot.model.nu else ("",)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((1.0 - _MOST_APART, 1.0 + _MOST_APART) if site else (0.4, 2.5),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        how = f"runs fast by a factor of {values['factor']:.5g}"
        return f"the clock of all readings ({site}) {how} against the commands'" if site else f"the log's clock {how}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(1.0 - 0.5 * _MOST_APART,), (1.0 + 0.5 * _MOST_APART,)] if site else [(f,) for f in _WHOLE]

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return ("Stamp commands and readings by one clock when they happen; rows counted by a nominal rate lie.",)

    def tried(self, robot: Robot, site: str, recording: Recording) -> Vectors:
        if not site:
            return [(factor,) for factor in _WHOLE]
        shares = [gap / recording.duration for gap in _APART_S]
        return [(1.0 + sign * share,) for sign in (1, -1) for share in shares if share <= _MOST_APART]

    def looks_like_physics(self, site: str) -> bool:
        """In a log with a fast clock all inertia, damping and weight seem to be larger."""
        return not site

    def logged(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        factor, first = values["factor"], float(recording.time[0])
        if not site:
            return replace(recording, time=first + factor * (recording.time - first))
        held = with_commands_at(recording, first + (recording.time - first) / factor)
        return replace(held, time=first + factor * (held.time - first))

    def mended(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        return self.logged(robot, recording, site, {"factor": 1.0 / values["factor"]})
