"""What was found, as objects: the entries of `findings.json` by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final


@final
@dataclass(frozen=True)
class ClaimedNumber:
    """A number of a claim.

    Attributes:
        value: in `unit`; the name of an element where the number is one; None: unknown.
        low, high: its 90 % interval; None: open.
        unit: empty for pure numbers.
    """

    value: float | str | None
    low: float | None
    high: float | None
    unit: str

    def __str__(self) -> str:
        if not isinstance(self.value, float | int):
            return str(self.value)
        ends = " to ".join("?" if x is None else f"{x:.3g}" for x in (self.low, self.high))
        return f"{self.value:.3g} ({ends}) {self.unit}".rstrip()


@final
@dataclass(frozen=True)
class ClaimedEffect:
    """Something that the simulator lacks.

    Attributes:
        effect: its name in the catalogue.
        kind, name: of the element at which it acts; name is None for the environment, `*` for all alike.
        probability: that this effect at this place is present, among all explanations tried.
        in_mjcf: whether `model_explained.xml` holds it.
        sentence: in plain words.
        equation: with its parameters.
        parameters: by name.
    """

    effect: str
    kind: str
    name: str | None
    probability: float
    in_mjcf: bool
    sentence: str
    equation: str
    parameters: Mapping[str, ClaimedNumber]

    def __str__(self) -> str:
        return f"{self.sentence} (probability {self.probability:.0%})"


@final
@dataclass(frozen=True)
class ErrorPlace:
    """A place of the mismatch.

    Attributes:
        kind, name: of the element.
        share: of the error that an effect there removes.
        p_value: of the same reduction by chance; None: not known.
    """

    kind: str
    name: str | None
    share: float
    p_value: float | None


@final
@dataclass(frozen=True)
class FitErrors:
    """Errors as shares of the sensors' ranges, by role (`train`, `test`); None where there is none.

    Attributes:
        noise_floor, nominal: of noise alone; of the nominal simulator.
        parameters_only, explained: of the nominal simulator with its values refitted; of the explained one.
        mjcf: of `model_explained.xml`.
        gain: share of the nominal error above the noise that is gone, on test recordings.
        gain_interval: its 90 % interval.
    """

    noise_floor: Mapping[str, float | None]
    nominal: Mapping[str, float | None]
    parameters_only: Mapping[str, float | None]
    explained: Mapping[str, float | None]
    mjcf: Mapping[str, float | None]
    gain: float | None
    gain_interval: tuple[float | None, float | None]


def claimed_effects(findings: Mapping[str, Any]) -> tuple[ClaimedEffect, ...]:
    """The entries of `what`."""
    found = []
    for entry in findings["what"]:
        parameters = {name: ClaimedNumber(**number) for name, number in entry["parameters"].items()}
        found.append(ClaimedEffect(**{**entry, "parameters": parameters}))
    return tuple(found)


def error_places(findings: Mapping[str, Any]) -> tuple[ErrorPlace, ...]:
    """The entries of `where`, the largest share first."""
    return tuple(ErrorPlace(**entry) for entry in findings["where"])


def fit_errors(findings: Mapping[str, Any]) -> FitErrors:
    """The entries of `fit` but for rivals."""
    fit = findings["fit"]
    names = ("noise_floor", "nominal", "parameters_only", "explained", "mjcf")
    errors, gain = {name: dict(fit[name]) for name in names}, fit["gain"]
    return FitErrors(**errors, gain=gain["value"], gain_interval=(gain["low"], gain["high"]))
