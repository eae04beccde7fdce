"""Channels exchanged: two columns of a log stand in each other's place."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import ClassVar, final

import numpy as np

from estexp_jax.physics.effects.base import Parameter
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.logging_fault import LoggingFault, Suspicion
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model.log_channels import LogChannel
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_MOST = 16
"""Of more channels of a kind, pairs are not tried."""


@register_effect
@final
class ChannelsExchanged(LoggingFault):
    """What is logged as one channel is that of `with`, and the other way round; `with` is 1 + its index."""

    name: ClassVar[str] = "channels_exchanged"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("with", "1 + channel index", refers="channel"),)
    equation: ClassVar[str] = "logged = true of `with`, logged of `with` = true"
    source: ClassVar[str] = "columns mapped by their order where names do not tell"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return tuple(name for name in robot.channels if self._partners(robot, name))

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((1.0, float(len(robot.channels))),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the log has {site} and channel number {int(values['with'])} in each other's place"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(1.0 + k,) for k in self._partners(robot, site)]

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return (
            "Exchange the two columns in the manifest, and move one joint at a time in a short recording to see that "
            "each name is right.",
        )

    def tried(self, robot: Robot, site: str, recording: Recording) -> Vectors:
        own = list(robot.channels).index(site)
        return [(1.0 + k,) for k in self._partners(robot, site) if k > own]

    def tried_together(self, robot: Robot) -> Sequence[tuple[Suspicion, ...]]:
        by_joint: dict[int, dict[tuple[str, int], str]] = {}
        for name, channel in robot.channels.items():
            if channel.joint is not None:
                by_joint.setdefault(channel.joint, {}).setdefault(channel.quantity, name)
        index = {name: k for k, name in enumerate(robot.channels)}
        found = []
        for one, other in combinations(by_joint.values(), 2):
            both = [q for q in one if q in other]
            if len(both) > 1 and len(by_joint) <= _MOST:
                found.append(tuple(Suspicion(one[q], (1.0 + index[other[q]],)) for q in both))
        return found

    def logged(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        channels, number = list(robot.channels.values()), int(values["with"])
        if not 1 <= number <= len(channels) or channels[number - 1].table != robot.channels[site].table:
            return recording
        return _exchanged(recording, robot.channels[site], channels[number - 1])

    def mended(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        return self.logged(robot, recording, site, values)

    def _partners(self, robot: Robot, site: str) -> list[int]:
        """Indices of the channels in whose place it may stand."""
        own = robot.channels[site]
        alike = [k for k, (name, c) in enumerate(robot.channels.items()) if name != site and c.quantity == own.quantity]
        return alike if len(alike) < _MOST else []


def _exchanged(recording: Recording, one: LogChannel, other: LogChannel) -> Recording:
    table = np.array(getattr(recording, one.table))
    table[:, [one.column, other.column]] = table[:, [other.column, one.column]]
    return replace(recording, **{one.table: table})
