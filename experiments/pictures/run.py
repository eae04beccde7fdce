"""`estexp experiment pictures`: the README's two pictures, from what `make demo` leaves; runs it where need be.

python experiments/pictures/run.py --demo out/demo --publish
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw both."""
    from experiments.harness.study import ROOT, Study, words

    study = Study.of(__file__, __doc__)
    parser = study.parser(quick="changes nothing")
    parser.add_argument("--demo", type=Path, default=ROOT / "out" / "demo", help="where `estexp demo` left its results")
    given = parser.parse_args(words(arguments))
    if not (given.demo / "explain" / "findings.json").exists():
        from estexp_jax.cli.main import main as estexp

        if code := estexp(["demo", "--out", str(given.demo), "--resume"]):
            return code
    out = study.results(given.out)
    draw_recovery(given.demo / "recover", out / "recover.png")
    draw_explanation(given.demo / "explain", out / "explain.png")
    study.publish(out, given.publish)
    return 0


def draw_recovery(run: Path, path: Path) -> None:
    """The ways of the robot: before the damage, damaged, and in the last trial."""
    from estexp_jax.recovery.state import RunState
    from estexp_jax.report.recover.figure import path_figure
    from estexp_jax.runs import load_checkpoint
    from experiments.harness.figures import write_figure

    axis = json.loads((run / "run.json").read_text())["config"]["axis"]
    figure = path_figure(RunState.from_tree(load_checkpoint(run / "checkpoint.npz")), axis)
    write_figure(path, figure, dpi=130)


def draw_explanation(run: Path, path: Path) -> None:
    """The reading of the test recording that the nominal simulator misses most, before and after."""
    from estexp_jax.discovery.diagnosis import Prediction
    from estexp_jax.recordings.readers.read import read_table
    from estexp_jax.report.explain.figures import figure_prediction
    from experiments.harness.figures import write_figure

    [test] = [d["file"] for d in json.loads((run / "findings.json").read_text())["data"] if d["role"] == "test"]
    table = read_table(run / "predictions" / f"{Path(test).stem}.csv")
    channels = tuple(name.removesuffix(".recorded") for name in table.names if name.endswith(".recorded"))
    values = [
        np.stack([table.column(f"{channel}.{kind}") for channel in channels], axis=1)
        for kind in ("recorded", "nominal", "explained")
    ]
    window = table.column("window").astype(int)
    prediction = Prediction(test, "test", table.column("time"), window, channels, *values)
    error = np.nanstd(values[1] - values[0], axis=0) / np.ptp(values[0], axis=0)
    write_figure(path, figure_prediction(prediction, int(np.argmax(error))), dpi=130)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
