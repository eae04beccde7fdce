"""The explanations that recordings leave open, with all it takes to simulate them and to compare what they predict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from estexp_jax.discovery.findings import TOLD, others, told_change
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import Explanation, Selection, tied
from estexp_jax.estimation.noise import median
from estexp_jax.physics.effects.changes import Change

_FEWEST, _MOST = 2, 6
"""Rivals of the chosen explanation: at least so many, however improbable, and at most so many with it."""


@final
@dataclass(frozen=True)
class CompetingModel:
    """One explanation.

    Attributes:
        claims: what it says the simulator lacks, as it is told; empty: values of the model are off, nothing else.
        changes: how its simulator differs from the nominal one: the claims under the names that they are simulated
            under, and refitted values of the model.
        probability: of it.
        error: deviations of noise that it is off on held-out windows.
        tied: whether these windows do not tell it from the chosen one, however improbable its numbers make it.
    """

    claims: tuple[Change, ...]
    changes: tuple[Change, ...]
    probability: float
    error: float
    tied: bool = False

    @property
    def open(self) -> bool:
        """Whether it is not refuted."""
        return self.tied or self.probability >= TOLD

    @property
    def label(self) -> str:
        """`effect@name` of each claim, joined by +."""
        return " + ".join(claim.place for claim in self.claims) or "refitted values of the model"

    @property
    def sentence(self) -> str:
        """What it says, in plain words."""
        return "; ".join(claim.sentence() for claim in self.claims) or "only values that the model has are off"

    def to_json(self) -> dict[str, Any]:
        """As in `rivals.json`."""
        return {
            "effects": [claim.place for claim in self.claims],
            "sentence": self.sentence,
            "probability": self.probability,
            "held_out_error": self.error,
            "tied": self.tied,
            "claims": [claim.to_json() for claim in self.claims],
            "changes": [change.to_json() for change in self.changes],
        }

    @classmethod
    def from_json(cls, entry: Mapping[str, Any]) -> CompetingModel:
        """The inverse of `to_json`."""
        claims, changes = (tuple(map(Change.from_json, entry[key])) for key in ("claims", "changes"))
        error = entry["held_out_error"]
        off = float("nan") if error is None else float(error)
        return cls(claims, changes, float(entry["probability"]), off, bool(entry.get("tied", False)))


@final
@dataclass(frozen=True, eq=False)
class CompetingModels:
    """Explanations of the same recordings.

    Attributes:
        models: the chosen one first.
        channels: names of the readings that were recorded, as in `Channels`.
        deviations: (channels,) what counts as one deviation of a reading's noise, in its unit; NaN where unknown.
        rate: of the training recordings, Hz.
        commands: (nu, 2) lowest and highest command in the training recordings.
        speeds: (nv,) fastest speed in the training recordings; 0 where nothing measured it.
        recordings: file name and role of each.
    """

    models: tuple[CompetingModel, ...]
    channels: tuple[str, ...]
    deviations: np.ndarray
    rate: float
    commands: np.ndarray
    speeds: np.ndarray
    recordings: tuple[tuple[str, str], ...]

    def to_json(self) -> dict[str, Any]:
        """As in `rivals.json`."""
        return {
            "rivals": [rival.to_json() for rival in self.models],
            "channels": list(self.channels),
            "deviations": self.deviations.tolist(),
            "rate_hz": self.rate,
            "commands": self.commands.tolist(),
            "speeds": self.speeds.tolist(),
            "recordings": [{"file": name, "role": role} for name, role in self.recordings],
        }

    @classmethod
    def from_json(cls, entry: Mapping[str, Any]) -> CompetingModels:
        """The inverse of `to_json`."""
        return cls(
            tuple(map(CompetingModel.from_json, entry["rivals"])),
            tuple(entry["channels"]),
            np.array(entry["deviations"], float),
            float(entry["rate_hz"]),
            np.array(entry["commands"], float).reshape(-1, 2),
            np.array(entry["speeds"], float),
            tuple((recording["file"], recording["role"]) for recording in entry["recordings"]),
        )


def competing_models_of(
    problem: Problem, selection: Selection, shares: np.ndarray, changes: Sequence[Change]
) -> CompetingModels:
    """What remains open after a selection.

    Args:
        problem: the comparison about the chosen explanation.
        selection: all explanations.
        shares: probability of (parameters, *tried).
        changes: of the explained simulator; none: the nominal one agrees with the recordings, and has no rival.
    """
    everything = [selection.parameters, *selection.tried]
    own = float(sum(share for e, share in zip(everything, shares, strict=True) if e is selection.chosen))
    chosen = _rival(selection.chosen, own, changes)
    rest = [
        replace(_rival(e, share), tied=tied(e, selection.chosen))
        for e, share in (others(selection, shares, len(everything)) if changes else [])
    ]
    trained = [i for i, r in enumerate(problem.recordings) if r.role == "train"]
    ctrl = np.concatenate([problem.recordings[i].ctrl for i in trained])
    paths = [s.path.qvel for s in problem.segments if s.recording in trained and s.path is not None]
    return CompetingModels(
        _left([chosen, *rest]),
        problem.channels.names,
        np.array([median(column) for column in problem.noise[trained].T]),
        float(np.median([problem.recordings[i].rate for i in trained])),
        np.stack([ctrl.min(axis=0), ctrl.max(axis=0)], axis=1),
        np.max([np.abs(speeds).max(axis=0) for speeds in paths], axis=0),
        tuple((r.name, r.role) for r in problem.recordings),
    )


def _rival(explanation: Explanation, share: float, changes: Sequence[Change] | None = None) -> CompetingModel:
    """An explanation with its own changes, or with those given, that it was refitted to."""
    fitted = explanation.fitted
    every = fitted.hypothesis.changes(fitted.vector) if changes is None else tuple(changes)
    claimed = [c for c in every if (c.effect, c.name or "") in explanation.places]
    return CompetingModel(tuple(told_change(c) for c in claimed), tuple(every), share, explanation.error)


def _left(rivals: Sequence[CompetingModel]) -> tuple[CompetingModel, ...]:
    """The chosen one, those that are open, and at least the next few; without forms of one effect told alike.

    The first of those stands for all, with their probability.
    """
    found: dict[frozenset[str], CompetingModel] = {}
    for rival in rivals:
        key = frozenset(claim.place for claim in rival.claims)
        first = found.get(key)
        if first is None:
            found[key] = rival
        else:
            found[key] = replace(first, probability=first.probability + rival.probability)
    open_ones = [rival for n, rival in enumerate(found.values()) if n <= _FEWEST or rival.open]
    return tuple(open_ones[:_MOST])
