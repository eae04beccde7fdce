"""`estexp experiment pictures`: the README's two pictures, from what `make demo` leaves; runs it where need be.

python experiments/pictures/run.py --demo out/demo --publish
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

NAMES = ("recover.png", "explain.png")


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw both."""
    parser = argparse.ArgumentParser(prog="pictures", description=__doc__)
    parser.add_argument("--demo", type=Path, default=ROOT / "out" / "demo", help="where `estexp demo` left its results")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "experiments" / "pictures")
    parser.add_argument("--publish", action="store_true", help="copy the pictures beside this script")
    for flag in ("--quick", "--resume"):
        parser.add_argument(flag, action="store_true", help="changes nothing")
    given = parser.parse_args(arguments)
    if not (given.demo / "explain" / "findings.json").exists():
        from estexp_jax.cli.main import main as estexp

        if code := estexp(["demo", "--out", str(given.demo), "--resume"]):
            return code
    given.out.mkdir(parents=True, exist_ok=True)
    draw_recovery(given.demo / "recover", given.out / NAMES[0])
    draw_explanation(given.demo / "explain", given.out / NAMES[1])
    for name in NAMES:
        if given.publish:
            shutil.copy(given.out / name, Path(__file__).parent / name)
        print(f"wrote {given.out / name}")
    return 0


def draw_recovery(run: Path, path: Path) -> None:
    """The ways of the robot: before the damage, damaged, and in the last trial."""
    from estexp_jax.report.recover_figure import path_figure

    from estexp_jax.recovery.state import RunState
    from estexp_jax.runs import load_checkpoint

    axis = json.loads((run / "run.json").read_text())["config"]["axis"]
    path_figure(RunState.from_tree(load_checkpoint(run / "checkpoint.npz")), axis).savefig(path, dpi=130)


def draw_explanation(run: Path, path: Path) -> None:
    """The reading of the test recording that the nominal simulator misses most, before and after."""
    from estexp_jax.recordings.read import read_table
    from estexp_jax.report.explain_figures import figure_prediction

    from estexp_jax.discovery.diagnosis import Prediction

    [test] = [d["file"] for d in json.loads((run / "findings.json").read_text())["data"] if d["role"] == "test"]
    table = read_table(run / "predictions" / f"{Path(test).stem}.csv")
    channels = tuple(name.removesuffix(".recorded") for name in table.names if name.endswith(".recorded"))
    told = [
        np.stack([table.column(f"{channel}.{kind}") for channel in channels], axis=1)
        for kind in ("recorded", "nominal", "explained")
    ]
    window = table.column("window").astype(int)
    prediction = Prediction(test, "test", table.column("time"), window, channels, *told)
    error = np.nanstd(told[1] - told[0], axis=0) / np.ptp(told[0], axis=0)
    figure_prediction(prediction, int(np.argmax(error))).savefig(path, dpi=130)


if __name__ == "__main__":
    sys.exit(main())
