"""`estexp experiment one_case`: one case from log to report, with the pictures of its page.

estexp experiment one_case                          draws the recordings, explains them, draws the pictures
python experiments/explain/one_case/run.py --publish        ... and copies the pictures beside this script
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from estexp_jax.discovery.fitting import Progress
    from estexp_jax.recordings.table import Table

SEED, CASE, SHOWN = 90417, "leg", "train_0.csv"
JOINTS = ("roll", "swing", "knee")


def main(arguments: Sequence[str] | None = None) -> int:
    """Do all of it; gives the exit code."""
    import estexp_jax as ee
    from estexp_jax.recordings.readers.read import read_table
    from estexp_jax.report.drawing.gl import NoGlError
    from estexp_jax.report.explain.ghosts import ghosts_of
    from estexp_jax.report.explain.marked import claimed_places, marked_of
    from experiments.benchmark.generator.__main__ import write_one
    from experiments.benchmark.generator.case import Plan, Planted
    from experiments.harness.figures import write_figure
    from experiments.harness.study import Study, words

    study = Study.of(__file__, __doc__)
    given = study.parser(quick="changes nothing").parse_args(words(arguments))
    out = study.results(given.out)
    planted = (Planted("load_dependent_friction", 1, 0.5), Planted("command_delay", 2, 0.3))
    answer = write_one(out, CASE, Plan("pair", "leg", planted, SEED, plain=True, tests=(0.9,)))
    logs = out / "cases" / CASE
    stages = set[str]()

    def tell(step: Progress) -> None:
        if step.stage not in stages:
            stages.add(step.stage)
            print(step.stage, flush=True)

    found = ee.explain(logs / "recordings.toml", progress=tell)
    report = found.write(out / "explained", force=True)
    write_figure(out / "log.png", figure_of_log(read_table(logs / SHOWN)), dpi=100)
    for name in ("where", "fit", "rivals", "ranking"):
        getattr(found, f"plot_{name}")().save(str(out / f"{name}.png"))
    with suppress(NoGlError):
        marked = marked_of(found.diagnosis.case.robot, claimed_places(found.findings))
        ghosts = ghosts_of(found.diagnosis)
        for name, picture in (("robots", ghosts and ghosts[0]), ("marked", marked)):
            if picture is not None:
                (out / f"{name}.jpg").write_bytes(picture)
    print(found.summary())
    for effect in answer["effects"]:
        numbers = ", ".join(f"{name} = {value:.3g}" for name, value in effect["parameters"].items())
        print(f"Hidden was: {effect['effect']} at {effect['name']}, {numbers}.")
    print(f"Report: {report}")
    study.publish(out, given.publish)
    return 0


def figure_of_log(log: Table) -> Figure:
    """A joint a row: angle with its command, and the torque of its motor."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 5.4), layout="constrained")
    rows = figure.subplots(len(JOINTS), 2, sharex=True)
    time = log.column("time")
    for joint, (angle, torque) in zip(JOINTS, rows, strict=True):
        angle.plot(time, log.column(f"ctrl.{joint}_servo"), color="0.6", lw=1.0, label="command")
        angle.plot(time, log.column(f"sensor.{joint}_angle"), color="k", lw=1.0, label="angle")
        torque.plot(time, log.column(f"sensor.{joint}_torque"), color="k", lw=0.8)
        angle.set_ylabel(f"{joint}, rad")
        torque.set_ylabel("torque, N m")
    rows[0][0].legend(frameon=False, ncols=2, fontsize="small")
    for axes in rows[-1]:
        axes.set_xlabel("time, s")
    return figure


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
