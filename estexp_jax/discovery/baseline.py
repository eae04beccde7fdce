"""What changed since a robot was well: its simulator is fitted to healthy recordings, then the change alone explained.

What was found in the healthy robot stays in it: written into its model where MJCF holds it as a value, else simulated
under every hypothesis. What nobody could explain of the healthy recordings counts as noise of each reading, so the
same mismatch is no news later.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig
from estexp_jax.discovery.explain import explain
from estexp_jax.discovery.export import explained_spec, is_plain_value
from estexp_jax.discovery.findings import told_change
from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.selection import NOISE
from estexp_jax.physics.effects import units
from estexp_jax.physics.effects.changes import Change, sentence_of
from estexp_jax.physics.effects.registry import effect, every
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import HEALTHY

_AS_HEALTHY = "as its healthy recordings show it"


@final
@dataclass(frozen=True, eq=False)
class Baseline:
    """A robot when it was well.

    Attributes:
        changes: how it differs from the nominal one: what was claimed, and refitted values of the model.
        finer: part of the model's step that its simulator takes.
        discrepancy: by a reading's name, root mean square of what nobody explained, in its unit; empty where that is
            no more than noise.
        findings: of its recordings.
    """

    changes: tuple[Change, ...]
    finer: int
    discrepancy: Mapping[str, float]
    findings: Mapping[str, Any]

    def told(self, name: str, element: str | None) -> Mapping[str, float]:
        """The values of an effect that the healthy robot has at an element; empty where it has none."""
        own = [told_change(c) for c in self.changes]
        return next((c.values for c in own if (c.effect, c.name) == (name, element)), {})

    def of(self, case: Case) -> Case:
        """A case whose nominal robot is the healthy one."""
        plain = [c for c in self.changes if is_plain_value(case.robot, c)]
        robots = {id(robot): self._written(robot, plain) for robot in (case.robot, *case.robots)}
        return replace(
            case,
            robot=robots[id(case.robot)],
            robots=tuple(robots[id(robot)] for robot in case.robots),
            standing=tuple(c for c in self.changes if c not in plain),
            discrepancy=self.discrepancy,
        )

    def _written(self, robot: Robot, plain: list[Change]) -> Robot:
        return Robot.from_spec(explained_spec(robot, plain, self.finer), f"{robot.source}, {_AS_HEALTHY}")


def explain_change(
    healthy: Case, now: Case, config: ExplainConfig, memory: dict[str, Any]
) -> Generator[Progress, None, Diagnosis]:
    """Explain what changed between two cases of one robot. What was wrong already when it was well is no news.

    Args:
        healthy: recordings of the robot when it was well, fitted and tested for themselves.
        now: recordings of it as it is.
        config: how both are explained.
        memory: as of `explain`.

    Yields:
        Progress.

    Raises:
        InputError: as `explain` does.
    """
    steps = explain(healthy, config, memory.setdefault("healthy", {}))
    while True:
        try:
            step = next(steps)
        except StopIteration as end:
            baseline = baseline_of(end.value)
            break
        yield step._replace(stage=f"healthy robot: {step.stage}")
    changed = baseline.of(now)
    found = yield from explain(changed, config, memory.setdefault("change", {}))
    return _with_baseline(found, healthy, baseline)


def baseline_of(diagnosis: Diagnosis) -> Baseline:
    """The healthy robot, from what was found in its recordings.

    What is left of them is noise, what starts do not tell, and a mismatch that nobody explained. Where it is as loud
    as the first two alone would make it (an error of 1), nothing is put down to the third.
    """
    finer = diagnosis.finer if diagnosis.findings["side"] == "numerics" else 1
    error, discrepancy = _error(diagnosis), dict[str, float]()
    for prediction in diagnosis.predictions if error > NOISE else ():
        left = np.square(prediction.explained - prediction.recorded)
        for channel, squares in zip(prediction.channels, left.T, strict=True):
            if np.isfinite(squares).any():
                size = float(np.sqrt(np.nanmean(squares) * (1.0 - error**-2)))
                discrepancy[channel] = max(discrepancy.get(channel, 0.0), size)
    return Baseline(diagnosis.changes, finer, discrepancy, diagnosis.findings)


def _error(diagnosis: Diagnosis) -> float:
    """Deviations of noise by which the explained simulator is off."""
    selection = diagnosis.selection
    if diagnosis.findings["verdict"] == "missing_physics" and diagnosis.findings["what"]:
        return selection.chosen.error
    nominal = min(selection.nominal.error, selection.corrected.error)
    return min(nominal, selection.parameters.error) if diagnosis.changes else nominal


def _with_baseline(found: Diagnosis, healthy: Case, baseline: Baseline) -> Diagnosis:
    """What was found, told as a change, in the simulator of the healthy robot."""
    body, standing = found.findings, found.case.standing
    well = [{**entry, "role": HEALTHY} for entry in baseline.findings["data"]]
    steps = body["cost"]["robot_steps"] + baseline.findings["cost"]["robot_steps"]
    told = {
        "what": [changed_entry(healthy.robot, entry, baseline) for entry in body["what"]],
        "baseline": list(baseline.findings["what"]),
        "discrepancy": dict(baseline.discrepancy),
        "advice": [*_advice(baseline), *body["advice"]],
        "data": [*well, *body["data"]],
        "cost": {**body["cost"], "robot_steps": steps},
    }
    models = found.competing_models
    if models is not None:
        own = tuple(replace(each, changes=(*standing, *each.changes)) for each in models.models)
        models = replace(models, models=own)
    changes = (*standing, *found.changes)
    return replace(found, findings={**body, **told}, changes=changes, competing_models=models)


def _advice(baseline: Baseline) -> list[str]:
    if baseline.findings["verdict"] != "unexplained":
        return []
    return [
        "The simulator does not describe the healthy robot, for reasons that nobody found: how far it was off then "
        "counts as noise, and smaller changes cannot be seen."
    ]


def changed_entry(robot: Robot, entry: Mapping[str, Any], baseline: Baseline) -> dict[str, Any]:
    """An entry of `what` whose values were found as changes of the healthy robot: as it is now, and as it was.

    Args:
        robot: the nominal one.
        entry: of the change.
        baseline: the healthy robot.
    """
    if entry["effect"] not in {e.name for e in every()}:  # a law in an equation, a step
        return dict(entry)
    e, before = effect(entry["effect"]), baseline.told(entry["effect"], entry["name"])
    amount = e.parameters[0]
    if amount.name not in entry["parameters"] or amount.refers or not np.isfinite(amount.neutral):
        return dict(entry)
    was = before.get(amount.name, amount.neutral)
    own = entry["parameters"][amount.name]

    def now(value: float | None) -> float | None:
        if value is None:
            return None
        return 1.0 - (1.0 - was) * (1.0 - value) if e.is_loss else was + value - amount.neutral

    parameters = {
        **entry["parameters"],
        amount.name: {**own, **{key: now(own[key]) for key in ("value", "low", "high")}, "from": was},
    }
    change = Change(e.name, entry["name"], {name: p["value"] for name, p in parameters.items()})
    sentence = units.unit_at(robot, e.kind, change.name, sentence_of(robot, change)) if before else entry["sentence"]
    since = f"{sentence}; {amount.name} was {was:.3g} {own['unit']}".rstrip() + " when it was healthy"
    return {
        **entry,
        "sentence": since,
        "equation": e.equation_with_values(change.parameters) if before else entry["equation"],
        "parameters": parameters,
    }
