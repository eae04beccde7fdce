"""What is remembered from step to step: a part of every `explained.py`, for NumPy."""

from __future__ import annotations

import bisect
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np


class CommandMemory:
    """What was commanded, as its integral over time: a late command is the mean of what was commanded so long ago."""

    def __init__(self, delay: float) -> None:
        self.delay, self.times, self.areas, self.first = delay, list[float](), list[Any](), 0.0

    def arriving(self, start: float, length: float, command: Any) -> Any:
        """The mean command that arrives in a step, in which another one is given."""
        if not self.times:
            self.times, self.areas, self.first = [start], [0.0 * command], command
        if start > self.times[-1]:
            self.times.append(start)
            self.areas.append(self.areas[-1])
        self.times.append(start + length)
        self.areas.append(self.areas[-1] + length * command)
        begin = start - self.delay
        found = (self._area(begin + length) - self._area(begin)) / length
        while len(self.times) > 2 and self.times[1] < begin - length:
            del self.times[0], self.areas[0]
        return found

    def _area(self, when: float) -> Any:
        if when <= self.times[0]:
            return self.areas[0] + (when - self.times[0]) * self.first
        i = min(bisect.bisect_right(self.times, when), len(self.times) - 1)
        share = (when - self.times[i - 1]) / (self.times[i] - self.times[i - 1])
        return self.areas[i - 1] + share * (self.areas[i] - self.areas[i - 1])


class ReadingMemory:
    """What was read: a late reading lies between two of them."""

    def __init__(self, delay: float) -> None:
        self.delay, self.times, self.values = delay, list[float](), list[Any]()

    def arriving(self, time: float, value: Any) -> Any:
        """The reading that is shown now."""
        self.times.append(time)
        self.values.append(np.array(value))
        when = time - self.delay
        while len(self.times) > 2 and self.times[1] <= when:
            del self.times[0], self.values[0]
        if when <= self.times[0] or len(self.times) == 1:
            return self.values[0]
        share = (when - self.times[0]) / (self.times[1] - self.times[0])
        return self.values[0] + share * (self.values[1] - self.values[0])


@dataclass
class Memory:
    """What is remembered of a robot from step to step."""

    hidden: dict[tuple[int, int], Any] = field(default_factory=dict)
    commands: Mapping[int, CommandMemory] = field(default_factory=dict)
    readings: Mapping[int, ReadingMemory] = field(default_factory=dict)
    time: float = 0.0
