"""Findings in the words of `findings.json`: sentences, numbers, intervals, rivals, advice."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from estexp_jax.discovery.hypotheses import Free
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import NOISE, Explanation, Selection, tied
from estexp_jax.discovery.slopes import Fit
from estexp_jax.estimation.channels import channel_ranges
from estexp_jax.physics.effects import units
from estexp_jax.physics.effects.changes import Change, sentence_of
from estexp_jax.physics.effects.laws.base import UNKNOWN_LAW
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.written import mjcf_refusal
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

TOLD = 0.01
"""Smallest probability of an alternative worth a line."""
_LOUD, _LOUDER = 0.1, 10.0
"""Share of its range that the noise of a reading is at least, and how many times that of most, where it is told."""
_AT_BOUND = 1e-6
"""Share of the range between a parameter's bounds within which a value is at one."""
_TIED = 8
"""Alternatives after which those without a probability are left out, however well they fit."""


def presence(selection: Selection, shares: np.ndarray, change: Change) -> float:
    """Probability that an effect is present: share of all explanations that tell of it, by their probabilities."""
    everything, wanted = [selection.parameters, *selection.tried], told_place(change)
    told = [set(told_places(e)) for e in everything]
    total = sum(share for places, share in zip(told, shares, strict=True) if wanted in places)
    return min(float(total), 1.0)  # a sum of many shares may come out a rounding error above


def told_change(change: Change) -> Change:
    """A change under the name and with the values that it is reported with."""
    name, values = effect(change.effect).reported_as(change.parameters)
    return Change(name, change.name, dict(values))


def told_place(change: Change) -> str:
    """`effect@name` as it is reported: terms of a law are all one."""
    if not effect(change.effect).named:
        return f"{UNKNOWN_LAW}@{change.name}"
    return told_change(change).place


def told_places(explanation: Explanation) -> list[str]:
    """What an explanation claims, as it is reported."""
    return list(dict.fromkeys(map(told_place, explanation.claims)))


def what_entry(robot: Robot, change: Change, fitted: Fit, intervals: np.ndarray, probability: float) -> dict[str, Any]:
    """One claimed effect with its numbers."""
    e = effect(change.effect)
    told = told_change(change)
    rows = {
        f.parameter: i
        for i, f in enumerate(fitted.hypothesis.free)
        if (f.effect, f.site) == (e.name, change.name or "")
    }
    own_units = {p.name: p.unit for p in (*e.parameters, *effect(told.effect).parameters)}
    parameters = {
        name: {
            "value": value,
            **_interval(fitted.hypothesis.free[rows[name]], value, intervals[rows[name]]),
            "unit": units.unit_at(robot, e.kind, change.name, own_units[name]),
        }
        for name, value in told.parameters.items()
    }
    return {
        "effect": told.effect if e.named else UNKNOWN_LAW,
        "kind": e.kind,
        "name": change.name,
        "probability": probability,
        "in_mjcf": not (mjcf_refusal(robot, change) and mjcf_refusal(robot, told)),
        "sentence": units.unit_at(robot, e.kind, change.name, sentence_of(robot, told)),
        "equation": effect(told.effect).equation_with_values(told.parameters),
        "parameters": parameters,
    }


def _interval(free: Free, value: float, interval: np.ndarray) -> dict[str, float | None]:
    """Low and high ends; a value at its bound may lie beyond it, so that this end is not known."""
    near = _AT_BOUND * (free.high - free.low)
    low, high = (float(x) for x in interval)
    if free.chosen or not near > 0.0:
        return {"low": low, "high": high}
    lowest, highest = value <= free.low + near, value >= free.high - near
    return {
        "low": None if lowest and free.low != free.neutral else low,
        "high": None if highest and free.high != free.neutral else high,
    }


def side(changes: Sequence[Change]) -> str | None:
    """The side the first claim is on; None for no claim."""
    return effect(changes[0].effect).side if changes else None


def alternatives(
    selection: Selection, shares: np.ndarray, test_errors: Callable[[Sequence[Fit]], Sequence[float]]
) -> list[dict[str, Any]]:
    """Other explanations, by probability, and those that nothing tells from the chosen one; at least the next three.

    Args:
        selection: all explanations.
        shares: probability of (parameters, *tried).
        test_errors: gives the nrmse of fits on test recordings; asked only for those that are told.
    """
    told = others(selection, shares, 3)
    errors = test_errors([explanation.fitted for explanation, _ in told])
    return [
        {"effects": told_places(explanation), "probability": share, "test_error": error}
        for (explanation, share), error in zip(told, errors, strict=True)
    ]


def others(selection: Selection, shares: np.ndarray, fewest: int) -> list[tuple[Explanation, float]]:
    """Explanations that tell of something else than the chosen one: the probable, the tied, and at least `fewest`.

    They come by probability, which is told with them; those of the same, by held-out error. The first of those that
    tell of the same stands for all, with their probability: the same effects in another order, forms of one effect,
    terms of one law.
    """
    everything = [selection.parameters, *selection.tried]
    order = sorted(range(len(everything)), key=lambda i: (-shares[i], everything[i].error))
    chosen, found = frozenset(told_places(selection.chosen)), dict[frozenset[str], tuple[Explanation, float]]()
    for i in order:
        own = frozenset(told_places(everything[i]))
        if own != chosen:
            first, share = found.get(own, (everything[i], 0.0))
            found[own] = first, share + float(shares[i])
    ranked = sorted(found.values(), key=lambda told: -told[1])
    return [
        told
        for rank, told in enumerate(ranked)
        if rank < fewest or told[1] >= TOLD or (rank < _TIED and tied(told[0], selection.chosen))
    ]


def advice(verdict: str, changes: Sequence[Change], recordings: Sequence[Recording], shares: np.ndarray) -> list[str]:
    """What to record next to settle what is open."""
    lines = list(dict.fromkeys(line for c in changes for line in effect(c.effect).advice(recordings)))
    if shares.size and shares.max() < 0.8 and verdict == "missing_physics":
        lines.append(
            "Several explanations predict held-out data about equally well: `estexp propose` finds what to record next."
        )
    if verdict == "unexplained":
        lines.append(
            "No effect of the catalogue explains these recordings: record joints one at a time to locate it better."
        )
    if len(recordings) < 3:
        lines.append("Give at least three recordings of different motions, so that whole recordings can be held out.")
    return lines


def belied(changes: Sequence[Change]) -> list[str]:
    """A line on claims under which the test recordings are predicted worse; none without claims."""
    if not changes:
        return []
    return [
        "The test recordings are predicted worse with this explanation than without: do not use it beyond the training "
        "recordings' motions, and record more motions like those of the test to learn from."
    ]


def data_entries(recordings: Sequence[Recording]) -> list[dict[str, Any]]:
    """What was read."""
    return [{"file": r.name, "role": r.role, "rows": r.rows, "hz": r.rate, "notes": list(r.notes)} for r in recordings]


def engine_advice(simulator: OpenLoopSimulator) -> list[str]:
    """A line on each thing of a model that is left out of its simulation, contacts of what came near included."""
    return [f"See that this does not matter to your motions: simulated without {x}." for x in simulator.left_out]


def noise_advice(problem: Problem) -> list[str]:
    """A line on each reading that jumps from row to row by much of its range, and far more than its fellows do."""
    loud: dict[str, float] = {}
    for recording, noise in zip(problem.recordings, problem.noise, strict=True):
        quiet = np.sort(noise[np.isfinite(noise)])
        usual = quiet[(len(quiet) - 1) // 2] if len(quiet) else np.inf
        shares = noise / channel_ranges(problem.channels, recording)
        for name, own, share in zip(problem.channels.names, noise, shares, strict=True):
            if share > _LOUD and own > _LOUDER * usual:
                loud[name] = max(share, loud.get(name, 0.0))
    return [
        f"Record more rows a second, or see what swings: the reading {name} jumps from row to row by {share:.0%} of "
        "its range. That is taken for noise, under which little can be seen."
        for name, share in loud.items()
    ]


def step_advice(selection: Selection, timestep: float) -> list[str]:
    """A line if the nominal step alone gives an error that can be told from noise.

    Args:
        selection: all explanations.
        timestep: of the nominal simulator, s.
    """
    nominal, corrected = selection.nominal.error, selection.corrected.error
    if nominal <= NOISE or corrected > 0.5 * nominal:
        return []
    share, step = f"{1.0 - corrected / nominal:.0%}", f"{1e3 * timestep:g} ms"
    return [f"Take a smaller time step: {share} of the nominal simulator's error comes from its step of {step}."]


def black_box_advice(verdict: str, fit: Mapping[str, Any]) -> list[str]:
    """The black-box correction, offered under that name where nothing could be named and it helps.

    Args:
        verdict: of the findings.
        fit: errors of all rivals.
    """
    learned, own = fit["black_box"].get("test", np.inf), fit["parameters_only"]["test"]
    if verdict != "unexplained" or not learned < own:
        return []
    return [
        "A black-box correction, a small network of positions, speeds, commands and torques, names nothing but brings"
        f" the test error from {100.0 * own:.3g} % with refitted parameters to {100.0 * learned:.3g} %."
    ]
