"""Draws docs/signatures/*.svg, what each effect does to a reading: `python docs/draw_effects.py`; takes minutes."""

import re
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from estexp_jax.package_data import model_path
from estexp_jax.physics.effects.changes import Change, parse_change
from estexp_jax.physics.effects.controller_fault import CommandRoute, ControllerFault
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.readers.read import read_table
from estexp_jax.recordings.table import Table
from estexp_jax.replay.synthetic_recordings import RecordConfig, write_recordings
from estexp_jax.report.channels import unit_of
from estexp_jax.runs import open_run

DOCS = Path(__file__).parent
FOLDER = DOCS / "signatures"
_LENGTH, _POINTS = 3.0, 120
_LEAST = 1e-5
"""Difference, as a share of the range, below which an effect does not act."""
_GREY, _NOMINAL, _REAL = "#808080", "#d95f02", "#3b8fd4"  # on white and on black


def examples() -> list[tuple[str, str]]:
    """Robot and effect of each planted example of the page."""
    page = (DOCS / "effects_reference.md").read_text(encoding="utf-8")
    return re.findall(r'models/(\w+)\.xml --effect "(.*)"', page)


def can_be_drawn(change: Change) -> bool:
    """Whether a replay of commands shows it."""
    own = effect(change.effect)
    return not isinstance(own, ControllerFault) or isinstance(own, CommandRoute)


def draw(robot: Robot, change: Change, nominal: Table) -> Figure | None:
    """The column on which the effect acts most, without and with it, and what it adds; None where it does not act."""
    real = recorded(robot, change)
    columns = [name for name in nominal.names if name != "time"]
    name = max(columns, key=lambda n: _difference(nominal.column(n), real.column(n)))
    if _difference(nominal.column(name), real.column(name)) < _LEAST:
        return None
    shown = np.linspace(0.0, _LENGTH, _POINTS)
    before, after = (np.interp(shown, table.column("time"), table.column(name)) for table in (nominal, real))
    figure = Figure(figsize=(5.4, 2.8), layout="constrained", facecolor="none")
    above, below = figure.subplots(2, 1, sharex=True)
    above.plot(shown, before, color=_NOMINAL, lw=1.4, label="without")
    above.plot(shown, after, color=_REAL, lw=1.4, label="with the effect")
    below.plot(shown, after - before, color=_REAL, lw=1.4)
    plain = name.partition(".")[2]
    unit = unit_of(robot, plain) if name.startswith("sensor.") else ""
    for axes, label in ((above, plain), (below, "difference")):
        axes.set_facecolor("none")
        axes.set_ylabel(f"{label}\n({unit})" if unit else label, color=_GREY, fontsize=9)
        axes.tick_params(colors=_GREY, labelsize=8)
        axes.spines[["top", "right"]].set_visible(False)
        axes.spines[["left", "bottom"]].set_color(_GREY)
    low, high = min(0.0, float(np.min(after - before))), max(0.0, float(np.max(after - before)))
    below.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
    below.set_xlabel("time (s)", color=_GREY, fontsize=9)
    figure.legend(loc="outside upper right", fontsize=8, frameon=False, labelcolor=_GREY, ncols=2)
    return figure


def recorded(robot: Robot, change: Change | None) -> Table:
    """The larger of the motions that `estexp record` makes, without noise."""
    config = RecordConfig(duration=_LENGTH, noise=0.0, bits=24)
    with tempfile.TemporaryDirectory() as folder:
        write_recordings(robot, () if change is None else (change,), config, open_run(Path(folder) / "out"))
        return read_table(Path(folder) / "out" / "test_0.csv")


def _difference(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.sqrt(np.mean((other - one) ** 2)) / max(np.ptp(one), np.ptp(other), 1e-9))


def main(names: list[str]) -> None:
    """Draw those effects, or all."""
    FOLDER.mkdir(exist_ok=True)
    robots: dict[str, tuple[Robot, Table]] = {}
    for name, text in examples():
        if name not in robots:
            robot = Robot.from_xml(model_path(name))
            robots[name] = robot, recorded(robot, None)
        robot, nominal = robots[name]
        change = parse_change(text, robot)
        if names and change.effect not in names:
            continue
        path = FOLDER / f"{change.effect}.svg"
        path.unlink(missing_ok=True)
        figure = draw(robot, change, nominal) if can_be_drawn(change) else None
        if figure is not None:
            with rc_context({"svg.fonttype": "none", "svg.hashsalt": "estexp"}):
                figure.savefig(path, metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    main(sys.argv[1:])
