"""`estexp experiment crash_recovery`: kill commands at random moments and go on; the results are the same.

estexp experiment crash_recovery --quick          one run of each command, killed twice
estexp experiment crash_recovery                  six runs of each, killed three times
python experiments/robustness/crash_recovery/run.py --only recover --runs 20
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


def main(arguments: Sequence[str] | None = None) -> int:
    """References, trials, summary; what is there already is kept."""
    from estexp_jax.runs import write_json
    from experiments.harness.study import Study
    from experiments.robustness.crash_recovery.subjects import COMMANDS, prepare

    study = Study.of(__file__, __doc__)
    options = _parsed(study, arguments)
    out = study.results(options.out, *([] if options.out else ["quick" if options.quick else "full"]))
    runs, kills = (1, 2) if options.quick else (options.runs, options.kills)
    prepare(out / "inputs")
    for number in range(runs):
        for index, command in enumerate(COMMANDS):
            if command in (options.only or COMMANDS):
                _trial(out, command, [index, number], kills)
    found = summary(out)
    write_json(out / "summary.json", found)
    for name, entry in found["commands"].items():
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in entry.items()))
    study.publish(out, options.publish)
    return int(any(entry["differ"] or entry["half_files"] or entry["failed"] for entry in found["commands"].values()))


def _parsed(study: Any, arguments: Sequence[str] | None) -> argparse.Namespace:
    from experiments.harness.study import words

    parser = study.parser(quick="one run of each command, killed twice")
    parser.add_argument("--runs", type=int, default=6, help="of each command")
    parser.add_argument("--kills", type=int, default=3, help="of each run")
    parser.add_argument("--only", nargs="+", choices=("recover", "explain", "experiment"), help="commands")
    return parser.parse_args(words(arguments))


def _reference(out: Path, command: str) -> tuple[Path, float]:
    """The results of a run that nobody kills, made twice and compared; and its processor time, s."""
    from estexp_jax.runs import write_json
    from experiments.robustness.crash_recovery.subjects import differences
    from experiments.robustness.crash_recovery.trial import whole

    first, second = (out / "reference" / f"{command}-{n}" for n in (1, 2))
    kept = out / "reference" / f"{command}.json"
    if not kept.is_file():
        each = [whole(command, out / "inputs", folder) for folder in (first, second)]
        write_json(kept, {"runs": each, "differs": differences(first, second)})
    return first, json.loads(kept.read_text())["runs"][1]["cpu_s"]  # of the second: the first may have compiled


def _trial(out: Path, command: str, seed: list[int], kills: int) -> None:
    import numpy as np

    from estexp_jax.runs import write_json
    from experiments.robustness.crash_recovery.trial import killed

    kept = out / "trials" / f"{command}-{seed[1]}.json"
    if kept.is_file():
        return
    kept.parent.mkdir(parents=True, exist_ok=True)
    reference, cpu = _reference(out, command)
    run = out / "runs" / f"{command}-{seed[1]}"
    found = killed(command, out / "inputs", reference, run, cpu, kills, np.random.default_rng(seed))
    write_json(kept, {"command": command, "seed": seed, "cpu_s": cpu, **found})
    if not found["differs"] and found["code"] == 0:
        shutil.rmtree(run)
    print(f"{kept.stem}: {sum(k['came'] for k in found['kills'])} kills, exit code {found['code']}, ", end="")
    print(f"differs in {found['differs'] or 'nothing'}", flush=True)


def _new_drafts(trial: dict) -> int:
    """Kills of a run that left a draft which the kill before had not."""
    left = [set(kill["drafts"]) for kill in trial["kills"]]
    return sum(bool(now - then) for then, now in zip([set(), *left[:-1]], left, strict=True))


def summary(out: Path) -> dict:
    """Numbers of all trials that are finished."""
    from estexp_jax.runs import versions
    from experiments.robustness.crash_recovery.subjects import COMMANDS

    commands = {}
    for command in COMMANDS:
        trials = [json.loads(path.read_text()) for path in sorted((out / "trials").glob(f"{command}-*.json"))]
        if not trials:
            continue
        kills = [kill for trial in trials for kill in trial["kills"] if kill["came"]]
        reference = json.loads((out / "reference" / f"{command}.json").read_text())
        commands[command] = {
            "runs": len(trials),
            "kills": len(kills),
            "in_a_write": sum(map(_new_drafts, trials)),
            "half_files": sum(len(k["unreadable"]) for k in kills) + sum(len(t["unreadable"]) for t in trials),
            "differ": sum(bool(trial["differs"]) for trial in trials),
            "failed": sum(trial["code"] != 0 or trial["traceback"] for trial in trials),
            "drafts_left": sum(len(trial["drafts_left"]) for trial in trials),
            "same_twice": not reference["differs"],
            "cpu_s": round(reference["runs"][1]["cpu_s"], 1),
        }
    return {"commands": commands, "versions": versions()}


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
