"""The posterior of an explanation as models to train on: draws of what was found, and ranges of MuJoCo's own fields."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.written import mjcf_refusal, written
from estexp_jax.physics.engines.c.batches import lane_fields
from estexp_jax.physics.model.robot import Robot

_INTERVAL = 1.645
"""Standard deviations of a normal distribution to either end of its 90 % interval."""
_ENDS = 5.0, 95.0
_OWNERS = {
    "actuator": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "body": mujoco.mjtObj.mjOBJ_BODY,
    "geom": mujoco.mjtObj.mjOBJ_GEOM,
    "jnt": mujoco.mjtObj.mjOBJ_JOINT,
    "sensor": mujoco.mjtObj.mjOBJ_SENSOR,
    "tendon": mujoco.mjtObj.mjOBJ_TENDON,
}
_LINEAR = 1
"""MuJoCo's number of reading delays linearly between samples."""

Interval = tuple[float, float]


@final
@dataclass(frozen=True)
class FieldRange:
    """Where the recordings leave one number of a model.

    Attributes:
        field: MuJoCo's, with `opt.` before those of its options.
        name: of the element it belongs to; empty for options.
        index: in the field.
        low, value, high: ends of the 90 % interval, and the value found.
    """

    field: str
    name: str
    index: tuple[int, ...]
    low: float
    value: float
    high: float


@final
@dataclass(frozen=True, eq=False)
class Randomisation:
    """What was found, as draws from its posterior.

    Attributes:
        robot: the nominal robot.
        changes: what was found, as far as MJCF holds it.
        intervals: 90 % of each of their parameters, by place and parameter; others are exact.
        model: with the values found; draws have its structure.
        ranges: of the numbers in which draws differ.
    """

    robot: Robot
    changes: tuple[Change, ...]
    intervals: Mapping[tuple[str, str], Interval]
    model: mujoco.MjModel
    ranges: tuple[FieldRange, ...]

    def fields(self, n: int, seed: int = 0) -> dict[str, np.ndarray]:
        """Fields (n, ...) of the models of so many draws, those alone in which draws differ.

        They fit `expand` of a `mujoco.batch.Batch` of `model`, and the fields of these names of an MJX model.
        """
        return _differing(self.model, _models(self.robot, _draws(self.changes, self.intervals, n, seed)))

    def __repr__(self) -> str:
        lines = [f"{r.field}{list(r.index)} {r.name}: {r.value:.6g} ({r.low:.6g} to {r.high:.6g})" for r in self.ranges]
        return "\n".join(lines) or "nothing to randomise: MJCF holds none of what was found"


def randomisation_of(
    robot: Robot, changes: Sequence[Change], intervals: Mapping[tuple[str, str], Interval], *, draws: int, seed: int
) -> Randomisation:
    """The posterior of changes of a robot.

    Args:
        robot: the nominal robot.
        changes: what was found; what MJCF cannot hold is left out.
        intervals: as of `Randomisation`.
        draws: from which ranges are taken.
        seed: of them.
    """
    held = tuple(c for c in changes if not mjcf_refusal(robot, c))
    found, *models = _models(robot, [held, *_draws(held, intervals, draws, seed)])
    ranges = list[FieldRange]()
    for name, drawn in _differing(found, models).items():
        low, high = np.percentile(drawn, _ENDS, axis=0)
        value = np.asarray(_field(found, name))
        for index in np.argwhere(np.ptp(drawn, axis=0) > 0.0).tolist():
            at = tuple(index)
            ranges.append(
                FieldRange(name, _owner(found, name, at), at, float(low[at]), float(value[at]), float(high[at]))
            )
    return Randomisation(robot, held, dict(intervals), found, tuple(ranges))


def _draws(
    changes: Sequence[Change], intervals: Mapping[tuple[str, str], Interval], n: int, seed: int
) -> list[tuple[Change, ...]]:
    """Sets of changes: each value normal about the one found, to either side as wide as its interval."""
    rng, found = np.random.default_rng(seed), list[tuple[Change, ...]]()
    for _ in range(n):
        drawn = list[Change]()
        for change in changes:
            values = dict(change.parameters)
            for p in effect(change.effect).parameters:
                if (ends := intervals.get((change.place, p.name))) and p.name in values and not p.refers:
                    value, z = values[p.name], rng.standard_normal()
                    reach = (ends[1] - value if z > 0.0 else value - ends[0]) / _INTERVAL
                    values[p.name] = value + z * reach
                    if not p.signed:
                        values[p.name] = max(values[p.name], 0.0)
            drawn.append(Change(change.effect, change.name, values))
        found.append(tuple(drawn))
    return found


def _models(robot: Robot, sets: Sequence[Sequence[Change]]) -> list[mujoco.MjModel]:
    """Models of sets of changes, of one structure: delays are read linearly, from buffers of one length."""
    specs = [written(robot, changes) for changes in sets]
    kinds = [(spec.actuators, spec.sensors) for spec in specs]
    for elements in zip(*([e for some in kind for e in some] for kind in kinds), strict=True):
        longest = max(e.nsample for e in elements)
        for spec, e in zip(specs, elements, strict=True):
            if e.nsample > 0 and int(e.interp) != _LINEAR:
                e.delay, e.interp = math.ceil(e.delay / spec.option.timestep) * spec.option.timestep, _LINEAR
        for e in elements:
            e.nsample = longest + 1 if longest else 0
    return [spec.compile() for spec in specs]


def _differing(model: mujoco.MjModel, others: Sequence[mujoco.MjModel]) -> dict[str, np.ndarray]:
    found = dict[str, np.ndarray]()
    for name in lane_fields():
        own = np.asarray(_field(model, name))
        if own.dtype.kind not in "fiub" or name.startswith("name"):
            continue
        drawn = np.stack([np.asarray(_field(other, name)) for other in others])
        if (drawn != own).any():
            found[name] = drawn
    return found


def _field(model: mujoco.MjModel, name: str) -> Any:
    return getattr(model.opt, name.removeprefix("opt.")) if name.startswith("opt.") else getattr(model, name)


def _owner(model: mujoco.MjModel, field: str, index: tuple[int, ...]) -> str:
    kind = field.partition("_")[0]
    if kind == "dof" and index:
        kind, index = "jnt", (int(model.dof_jntid[index[0]]),)
    return mujoco.mj_id2name(model, _OWNERS[kind], index[0]) or "" if kind in _OWNERS and index else ""
