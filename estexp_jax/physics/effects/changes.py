"""Changes: named differences between a robot and its nominal model, and their arrays.

A `Change` is what people read and write: one effect at one place with its numbers. `encode` lays a set of them out
over a catalogue as `Values`: per effect an array (n_sites, n_parameters), neutral where nothing differs. The structure
of the arrays depends on robot and catalogue only, so one compiled simulation serves every hypothesis.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.errors import InputError, known
from estexp_jax.physics.effects.base import Effect, neutral_values
from estexp_jax.physics.effects.registry import Catalogue, effect
from estexp_jax.physics.model.robot import Robot

Values = dict[str, Any]
"""Effect name -> array (n_sites, n_parameters), or (batch, n_sites, n_parameters); float32."""


@final
@dataclass(frozen=True)
class Change:
    """One effect at one place.

    Attributes:
        effect: its name in the catalogue.
        name: the element it acts on; None for the environment.
        parameters: parameter name to value; those left out are neutral.
    """

    effect: str
    name: str | None
    parameters: Mapping[str, float]

    @property
    def kind(self) -> str:
        """Kind of element it acts on."""
        return effect(self.effect).kind

    @property
    def values(self) -> dict[str, float]:
        """Every parameter of the effect: those given, the others neutral."""
        return {p.name: p.neutral for p in effect(self.effect).parameters} | dict(self.parameters)

    @property
    def place(self) -> str:
        """`effect@name`, or the effect alone for the environment."""
        return self.effect if self.name is None else f"{self.effect}@{self.name}"

    def sentence(self) -> str:
        """What it says, in plain words."""
        return effect(self.effect).sentence(self.name or "", self.values)

    def to_json(self) -> dict[str, Any]:
        """As in `run.json` and `findings.json`."""
        return {"effect": self.effect, "kind": self.kind, "name": self.name, "parameters": dict(self.parameters)}

    @classmethod
    def from_json(cls, entry: Mapping[str, Any]) -> Change:
        """The inverse of `to_json`.

        Raises:
            KeyError, TypeError, ValueError: it is none of its results.
        """
        name, parameters = entry["name"], {key: entry["parameters"][key] for key in entry["parameters"]}
        if not isinstance(entry["effect"], str) or not isinstance(name, str | None):
            raise ValueError("an effect and a place are names")
        for key, value in parameters.items():
            if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
                raise ValueError(f"{key} is no number")
        return cls(entry["effect"], name, parameters)


def sentence_of(robot: Robot, change: Change) -> str:
    """The sentence of a change, with the names of the elements to which its numbers refer."""
    sentence = change.sentence()
    for p in effect(change.effect).parameters:
        number = round(change.parameters.get(p.name, 0.0)) if p.refers else 0
        if number:
            names = robot.names(p.refers)
            sentence = sentence.replace(f"number {number}", names[min(number, len(names)) - 1])
    return sentence


def parse_change(text: str, robot: Robot) -> Change:
    """Read `effect@name parameter=value ...`, as typed on the command line.

    Raises:
        InputError: unknown effect, place or parameter, or no number; or the model's options switch off what it is.
    """
    head, *assignments = text.split() or [""]
    name, at, place = head.partition("@")
    e = effect(name)
    disabled = robot.model.opt.disableflags
    if off := [f for f in e.flags if disabled & getattr(mujoco.mjtDisableBit, f"mjDSBL_{f.upper()}")]:
        flags = " ".join(f'{flag}="enable"' for flag in off)
        raise InputError(
            f"'{name}' does nothing here: the model's options disable {' and '.join(off)}",
            where=text,
            right=f"<option><flag {flags}/></option> in the model",
        )
    sites = e.sites(robot)
    if sites == ("",):
        if at:
            raise InputError(
                f"'{name}' acts on the {e.kind} and takes no place", where=text, right=f"write '{name} ...'"
            )
    elif place not in sites:
        raise InputError(f"'{name}' cannot act on '{place}'", where=text, right=known(sites))
    names = [p.name for p in e.parameters]
    parameters: dict[str, float] = {}
    for assignment in assignments:
        key, equals, value = assignment.partition("=")
        if not equals or key not in names:
            raise InputError(f"'{assignment}' is not a parameter of {name}", where=text, right=known(names))
        parameters[key] = _value(e, key, value, robot, text)
    if not parameters:
        parameters = fixed_values(e, robot, place)
    if not parameters:
        raise InputError(
            "no parameter is given", where=text, right=f"add one of {', '.join(n + '=...' for n in names)}"
        )
    return Change(name, place or None, parameters)


def fixed_values(e: Effect, robot: Robot, site: str) -> dict[str, float]:
    """Its parameters at a site where each can have but one value; else nothing."""
    bounds = e.bounds(robot, site)
    is_fixed = all(low == high for low, high in bounds)
    return {p.name: low for p, (low, _) in zip(e.parameters, bounds, strict=True)} if is_fixed else {}


def _value(e: Effect, key: str, value: str, robot: Robot, text: str) -> float:
    """A number, or for `tied_outputs with=` and the like an element's name."""
    [refers] = [p.refers for p in e.parameters if p.name == key]
    if refers and value in robot.names(refers):
        return 1.0 + robot.index(refers, value)
    try:
        number = float(value)
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise InputError(f"'{value}' is no finite number", where=f"{text}, parameter '{key}'") from None
    return number


def neutral(robot: Robot, catalogue: Catalogue) -> Values:
    """The values of the nominal robot."""
    return {
        e.name: np.array(neutral_values(e, len(e.sites(robot))), np.float32).reshape(-1, len(e.parameters))
        for e in catalogue
    }


def encode(robot: Robot, catalogue: Catalogue, changes: Iterable[Change]) -> Values:
    """The values of one robot with these changes. Changes at one place add up: each by how far it is from neutral.

    Raises:
        InputError: a change's effect is not in the catalogue or cannot act there.
    """
    return {name: values[0] for name, values in encode_all(robot, catalogue, [changes]).items()}


def encode_all(robot: Robot, catalogue: Catalogue, sets: Sequence[Iterable[Change]]) -> Values:
    """The values (sets, n_sites, n_parameters) of several robots, each with its changes, as `encode` has them.

    Raises:
        InputError: a change's effect is not in the catalogue or cannot act there.
    """
    nominal, rows = _layout(robot, tuple(catalogue))
    values = {name: np.repeat(array[None], len(sets), axis=0) for name, array in nominal.items()}
    for i, changes in enumerate(sets):
        for change in changes:
            if change.effect not in values:
                raise InputError(f"'{change.effect}' is not in this catalogue", right=known(values))
            e, sites = rows[change.effect]
            if (change.name or "") not in sites:
                raise InputError(f"'{change.effect}' cannot act on '{change.name}'", right=known(sites))
            row = values[change.effect][i, sites[change.name or ""]]
            for column, parameter in enumerate(e.parameters):
                value = change.parameters.get(parameter.name, parameter.neutral)
                # Not simply added: a neutral value may be so large that single precision loses the rest.
                row[column] = value if row[column] == parameter.neutral else row[column] + value - parameter.neutral
    return values


@lru_cache(maxsize=32)
def _layout(robot: Robot, catalogue: Catalogue) -> tuple[Values, dict[str, tuple[Effect, dict[str, int]]]]:
    """Neutral values, effects and rows of their sites; searches encode thousands of hypotheses on one robot."""
    rows = {e.name: (effect(e.name), {site: i for i, site in enumerate(e.sites(robot))}) for e in catalogue}
    return neutral(robot, catalogue), rows


def stack(batch: Sequence[Values]) -> Values:
    """One batch of several robots' values."""
    return {name: np.stack([values[name] for values in batch]) for name in batch[0]}
