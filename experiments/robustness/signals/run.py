"""`estexp experiment signals`: signals at random moments, and the same command gone on with.

estexp experiment signals --quick                                       two signals a command
estexp experiment signals                                               200 of three kinds, 100 kills
python experiments/robustness/signals/run.py --count 40 --only check --publish
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

EARLY_S = 4.0
"""Every second signal comes before this processor time, when modules are loaded and programs compiled."""


def main(arguments: Sequence[str] | None = None) -> int:
    """References, trials, summary; what is there already is kept."""
    from estexp_jax.runs import write_json
    from experiments.harness.study import Study
    from experiments.robustness.crash_recovery.subjects import prepare
    from experiments.robustness.signals.trial import COMMANDS

    study = Study.of(__file__, __doc__)
    options = _parsed(study, arguments)
    out = study.results(options.out)
    prepare(out / "inputs")
    lengths = _references(out)
    signals, kills = (2, 1) if options.quick else (options.count, options.kills)
    for number in range(max(signals, kills)):
        for command in options.only or COMMANDS:
            if number < signals:
                kind = ("SIGINT", "SIGTERM", "SIGHUP")[number % 3]
                _trial(out, command, number, kind, lengths[command], ends_only=options.endings)
            if number < kills:
                _trial(out, command, number, "SIGKILL", lengths[command], ends_only=options.endings)
            write_json(out / "summary.json", summary(out))
    found = summary(out)
    for name, entry in found["signals"].items():
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in entry.items()))
    study.publish(out, options.publish)
    return int(any(entry["wrong"] or entry["not_resumed"] for entry in found["signals"].values()))


def _parsed(study: Any, arguments: Sequence[str] | None) -> argparse.Namespace:
    from experiments.harness.study import words
    from experiments.robustness.signals.trial import COMMANDS

    parser = study.parser(quick="two signals and one kill a command")
    parser.add_argument("--count", type=int, default=50, help="signals a command")
    parser.add_argument("--kills", type=int, default=25, help="SIGKILLs a command")
    parser.add_argument("--endings", action="store_true", help="do not go on after each: fast, and says half as much")
    parser.add_argument("--only", nargs="+", choices=COMMANDS, help="commands")
    return parser.parse_args(words(arguments))


def _references(out: Path) -> dict[str, float]:
    """Results without a signal, made where they are missing, and the processor time of each command, s."""
    from estexp_jax.runs import write_json
    from experiments.robustness.signals.trial import COMMANDS, whole

    kept = out / "reference.json"
    lengths = json.loads(kept.read_text()) if kept.is_file() else {}
    for command in COMMANDS:
        if command not in lengths:
            lengths[command] = whole(command, out / "inputs", out / "reference" / command)
            write_json(kept, lengths)
    return lengths


def _trial(out: Path, command: str, number: int, name: str, length: float, *, ends_only: bool) -> None:
    import numpy as np

    from estexp_jax.runs import write_json
    from experiments.robustness.signals.trial import COMMANDS, SIGNALS, interrupted

    kept = out / "trials" / f"{command}-{name}-{number}.json"
    if kept.is_file():
        return
    kept.parent.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng([COMMANDS.index(command), SIGNALS.index(name), number])
    at = float(random.uniform(0.0, min(EARLY_S, length) if number % 2 else length))
    run = out / "runs" / kept.stem
    reference = None if ends_only else out / "reference" / command
    found = interrupted(command, name, at, out / "inputs", reference, run)
    write_json(kept, found)
    if found["right"] and not found["again"] and not found["differs"]:
        shutil.rmtree(run, ignore_errors=True)
    print(f"{kept.stem}: at {at:.2f} s, exit code {found['code']} after {found['took_s']:.2f} s, ", end="")
    print(
        f"{'right' if found['right'] else 'WRONG'}; again {found['again']}, differs in {found['differs']}", flush=True
    )


def summary(out: Path) -> dict[str, Any]:
    """Counts of all trials that are finished, by command and kind of signal."""
    from estexp_jax.runs import versions
    from experiments.robustness.signals.trial import COMMANDS, SIGNALS

    rows: dict[str, Any] = {}
    for command in COMMANDS:
        for name in SIGNALS:
            trials = [json.loads(p.read_text()) for p in sorted((out / "trials").glob(f"{command}-{name}-*.json"))]
            if trials:
                rows[f"{command} {name}"] = {
                    "sent": sum(t["came"] for t in trials),
                    "exit_3": sum(t["came"] and t["code"] == 3 for t in trials),
                    "done": sum(t["came"] and t["code"] == 0 for t in trials),
                    "wrong": sum(not t["right"] for t in trials),
                    "longest_s": round(max((t["took_s"] for t in trials if t["came"]), default=0.0), 2),
                    "gone_on": sum(t["again"] is not None for t in trials),
                    "not_resumed": sum(bool(t["again"] or t["differs"]) for t in trials),
                }
    return {"signals": rows, "versions": versions()}


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
