"""The oracle: the true robot with its true effect, from the same estimated window starts and logged commands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from experiments.benchmark.baselines.logs import Log, windows
from experiments.benchmark.generator.case import Case, Plan, Planted
from experiments.benchmark.generator.making import make
from experiments.benchmark.generator.plant import Plant
from experiments.benchmark.generator.readings import reading
from experiments.benchmark.generator.robots import ROBOTS, layout
from experiments.benchmark.generator.sensing import channels


def rebuilt(answer: Mapping[str, Any]) -> Case:
    """The case of an answer."""
    plan = answer["plan"]
    return make(
        Plan(**{**plan, "planted": tuple(Planted(**p) for p in plan["planted"])}),
        shorter=answer["shorter"],
        refit=False,
    )


def error(answer: Mapping[str, Any], model: mujoco.MjModel, logs: list[Log]) -> float:
    """nrmse of the oracle on the test recordings."""
    return float(np.sqrt(np.mean(np.square(errors(answer, model, logs)))))


def errors(answer: Mapping[str, Any], model: mujoco.MjModel, logs: list[Log]) -> list[float]:
    """nrmse of the oracle on each of the test recordings."""
    case, place = rebuilt(answer), layout(answer["robot"])
    robot, parts = ROBOTS[answer["robot"]], []
    tests = [r for r in case.recorded if r.name.startswith("test")]
    for recorded, log in zip(tests, [log for log in logs if log.role == "test"], strict=True):
        for effect in case.effects:
            effect.start = -1e9
        plant = Plant(robot, case.truth, case.motors, case.effects, case.plan.by_hand)
        starts = {float(log.time[w.rows[0]]): (w.qpos, w.qvel) for w in windows(model, log)}
        rows, steps = plant.replay(recorded.rows, starts)
        again = recorded.__class__(recorded.name, rows, steps)
        true_readings = [
            reading(c, again, rows.time, case.effects, case.plan.planted, robot.name)
            for c in channels(robot.model, place)
        ]
        truth = np.stack(true_readings, axis=1)
        at = np.abs(log.time[:, None] - rows.time[None, :]).argmin(axis=1)
        kept = np.concatenate([w.rows[1:] for w in windows(model, log)])
        off = (truth[at] - log.sensor)[kept]
        parts.append(float(np.sqrt(np.mean(np.mean(off**2, axis=0) / np.ptp(log.sensor, axis=0) ** 2))))
    return parts
