"""What the names of a log's columns say: whose value it is, which quantity, commanded or measured, in which unit."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, final

Quantity = Literal["position", "velocity", "effort", ""]

COMMAND = frozenset(
    "command commands commanded cmd cmds ctrl control goal goals target targets action actions desired des"
    " reference references ref setpoint setpoints con soll sollwert consigne".split()
)
"""Words of a command. They count more than others: `goal_position` is one."""
SWITCH = frozenset({"enable", "enabled"})
"""Words of a motor's switch."""
_QUANTITY_WORDS: Mapping[Quantity, str] = {
    "position": "position positions pos angle angles q qpos encoder theta",
    "velocity": "velocity velocities vel speed speeds qd dq qvel omega",
    "effort": "effort efforts torque torques tau force",
}
_QUANTITIES: dict[str, Quantity] = {
    word: quantity for quantity, text in _QUANTITY_WORDS.items() for word in text.split()
}
_SECONDS = ("s", "sec", "secs", "seconds")
_UNITS = {
    **dict.fromkeys(("deg", "degree", "degrees"), "deg"),
    **{"dps": "deg/s", **{unit: unit for unit in ("mrad", "rpm", "cm", "mm", "ms", "us", "ns")}},
    **dict.fromkeys(("rad", *_SECONDS), ""),
    **{"msec": "ms", "milliseconds": "ms", "usec": "us", "microseconds": "us", "nsec": "ns", "nanoseconds": "ns"},
}
_MEASURED = frozenset(
    "meas measured measurement actual feedback present observation observations state states ist istwert obs".split()
)
_GENERIC = frozenset(
    "joint joints motor motors servo servos actuator sensor data value values raw controller controllers".split()
)
_NAMELESS = COMMAND | SWITCH | _QUANTITIES.keys() | _MEASURED | _GENERIC | _UNITS.keys()
"""Words that say what a column is, not whose."""
_SIDES = {"l": "left", "r": "right"}
_ASIDE = frozenset(
    "error errors err layout offset stride seq secs nsecs sec nanosec nanos seconds temperature temp".split()
)
_CLOCK = frozenset("time timestamp timestamps stamp t zeit temps tiempo tempo".split())


def words(name: str) -> tuple[str, ...]:
    """`pos_meas1` is pos, meas and 1; `goalPosition` is goal and position; `/a.left[Elbow]` is a, left and elbow."""
    return tuple(word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+|[^\W\d_a-zA-Z]+", name))


def owner_words(name: str) -> tuple[str, ...]:
    """The words of a name that say whose it is; `l` and `r` are left and right."""
    return tuple(_SIDES.get(word, word) for word in words(name) if word not in _NAMELESS)


@final
@dataclass(frozen=True)
class NamedColumn:
    """A column of a log, or one value of a list column, and what its name says.

    Attributes:
        name: in the log.
        index: of the value in a list column whose values have no names; None for others.
        label: the name that another topic of the log gives it; empty where none does.
        label_from: where that name stands.
    """

    name: str
    index: int | None = None
    label: str = ""
    label_from: str = ""

    @property
    def words(self) -> tuple[str, ...]:
        """The words of its name; a label stands in place of the index at its end."""
        return words(self._spoken)

    @property
    def _spoken(self) -> str:
        return f"{self.name.rpartition('[')[0]}[{self.label}]" if self.label else self.name

    @property
    def owner(self) -> tuple[str, ...]:
        """The words that say whose it is."""
        return owner_words(self._spoken)

    @property
    def is_aside(self) -> bool:
        """Whether it is no command and no reading of a joint: an error, a stamp, a later point of a trajectory."""
        return bool(_ASIDE & set(self.words)) or bool(re.search(r"points\[[1-9]", self.name))

    @property
    def is_switch(self) -> bool:
        """Whether it switches a motor."""
        return bool(SWITCH & set(self.words))

    @property
    def is_command(self) -> bool:
        """Whether it is commanded, not measured."""
        return bool(COMMAND & set(self.words)) and not self.is_switch

    @property
    def is_clock(self) -> bool:
        """Whether it is a time."""
        stated = [word for word in self.words if word not in _UNITS]
        half = self.name.endswith((".sec", ".secs", ".seconds"))  # whole seconds, without their nanoseconds
        return bool(stated) and stated[-1] in _CLOCK and not self.is_command and not half

    @property
    def quantity(self) -> Quantity:
        """What it is a value of: the last word that says so; empty where none does."""
        spoken: list[Quantity] = [_QUANTITIES[word] for word in self.words if word in _QUANTITIES]
        return spoken[-1] if spoken else ""

    @property
    def unit(self) -> str:
        """The unit in its name, of those that a manifest knows; empty for SI and where there is none."""
        units = [word for word in reversed(self.words) if word in _UNITS]
        if units[1:] and units[0] in _SECONDS and _UNITS[units[1]] not in ("", "ms", "us", "ns"):
            units = units[1:]  # a second says per what
        unit = _UNITS[units[0]] if units else ""
        per_second = re.search(r"deg(rees)?\s*(/|_?per_?|_|\s)\s*s(ec(ond)?)?s?(?![a-z])", self.name.lower())
        return "deg/s" if unit == "deg" and (per_second or self.quantity == "velocity") else unit


def owners(names: Mapping[str, Iterable[str]]) -> dict[tuple[str, ...], str]:
    """The words by which elements are known, each with its element; those of two elements are left out.

    Args:
        names: of each element (a joint, say), the names by which it is known: its own, its motor's, its sensors'.
    """
    spoken = {element: [w for w in (owner_words(name) for name in each) if w] for element, each in names.items()}
    shared = set.intersection(*(set(each[0]) for each in spoken.values() if each)) if len(spoken) > 1 else set()
    found: dict[tuple[str, ...], set[str]] = {}
    for element, each in spoken.items():
        for one in each:
            # A robot's own name in front of all its joints' names may be missing in the log.
            for spelled in {one, tuple(word for word in one if word not in shared)} - {()}:
                found.setdefault(spelled, set()).add(element)
    return {spelled: next(iter(elements)) for spelled, elements in found.items() if len(elements) == 1}


def owner_of(
    column: NamedColumn, known: Mapping[tuple[str, ...], str], behind: int = 0
) -> tuple[str, tuple[str, ...]] | None:
    """Whose column it is: the element with the longest name at the end of the column's, and the words of that name.

    A name of the same words in another order is its as well: `elbow_left` of `left_elbow`.

    Args:
        column: of a log.
        known: elements by their words.
        behind: how many words at the end of the column's name say nothing.
    """
    own = column.owner[: len(column.owner) - behind]
    for length in range(len(own), 0, -1):
        if own[-length:] in known:
            return known[own[-length:]], own[-length:]
    turned = {known[each] for each in known if sorted(each) == sorted(own) and not all(w.isdecimal() for w in own)}
    return (turned.pop(), own) if len(turned) == 1 else None


def are_numbers(spelled: Sequence[tuple[str, ...]]) -> bool:
    """Whether names tell elements apart by numbers alone."""
    return bool(spelled) and all(len(each) == 1 and each[0].isdecimal() for each in spelled)
