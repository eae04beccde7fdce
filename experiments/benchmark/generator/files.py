"""A case on disk: the nominal MJCF, recordings, a manifest; no label, no seed, no name that tells anything."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.benchmark.generator.case import Case, Recorded
from experiments.benchmark.generator.readings import is_slide, reading, size_of
from experiments.benchmark.generator.robots import ROBOTS, layout
from experiments.benchmark.generator.sensing import captured, channels, measured


def write_case(case: Case, folder: Path) -> None:
    """Write what an explainer may see."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "nominal.xml").write_text(case.nominal, encoding="utf-8")
    for i, recorded in enumerate(case.recorded):
        rng = np.random.default_rng([case.plan.seed, 3, i])
        _write_csv(folder / recorded.name, columns(case, recorded, rng))
    entries = [
        f'[[recording]]\nfile = "{r.name}"\nrole = "{"test" if r.name.startswith("test") else "train"}"\n'
        for r in case.recorded
    ]
    (folder / "recordings.toml").write_text("\n".join(['model = "nominal.xml"\n', *entries]), encoding="utf-8")


def columns(case: Case, recorded: Recorded, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """What the logger wrote, dropped rows left out."""
    robot = ROBOTS[case.plan.robot]
    model, place, rows = robot.model, layout(case.plan.robot), recorded.rows
    n = len(rows.time)
    table = {"time": np.round(rows.time + case.instruments.stamp * rng.standard_normal(n), 6)}
    table |= {f"ctrl.{a}": np.round(rows.command[:, i], 6) for i, a in enumerate(place.actuators)}
    if not np.all(rows.enable):
        table |= {f"enable.{a}": rows.enable[:, i] for i, a in enumerate(place.actuators)}
    for c in channels(model, place):
        true = reading(c, recorded, rows.time, case.effects, case.plan.planted, case.plan.robot)
        size, slide = size_of(c, case.recorded, case.plan.robot), is_slide(model, place, c)
        table[f"sensor.{c.name}"] = measured(c, true, case.instruments, size, slide, rng)
    if place.free:
        qpos, qvel = captured(rows, rng)
        table |= {f"qpos.root.{i}": qpos[:, i] for i in range(7)} | {f"qvel.root.{i}": qvel[:, i] for i in range(6)}
    kept = rng.random(n) >= case.instruments.dropped
    kept[0] = True
    return {name: column[kept] for name, column in table.items()}


def _write_csv(path: Path, table: dict[str, np.ndarray]) -> None:
    rows = np.column_stack(list(table.values()))
    np.savetxt(path, rows, fmt="%.9g", delimiter=",", header=",".join(table), comments="")
