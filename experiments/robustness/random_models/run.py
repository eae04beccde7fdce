"""`estexp experiment random_models`: models drawn at random, through `ee.simulate`, against plain MuJoCo.

estexp experiment random_models --quick
python experiments/robustness/random_models/run.py --count 200 --resume --publish
"""

from __future__ import annotations

import json
import sys
import traceback
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

FIRST_SEED = 5000
"""The generator was written on smaller ones."""
_PATIENCE_S = 300.0
FAILURES = ("wrong", "crashed")


def main(arguments: Sequence[str] | None = None) -> int:
    """All seeds; those of an earlier run are not tried again with --resume."""
    from estexp_jax.runs.versions import version
    from experiments.harness.isolated import isolated
    from experiments.harness.rows import write_rows
    from experiments.harness.study import Study, words

    study = Study.of(__file__, __doc__)
    parser = study.parser(quick="10 models")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=FIRST_SEED, help="the first one")
    parser.add_argument("--engine", default="auto", help="of `ee.simulate`")
    given = parser.parse_args(words(arguments))
    out = study.results(given.out)
    kept = out / f"{given.engine}.jsonl"
    if not given.resume:
        kept.unlink(missing_ok=True)
    rows = [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []
    seeds = range(given.seed, given.seed + (10 if given.quick else given.count))
    todo = sorted(set(seeds) - {row["seed"] for row in rows})
    for seed, found in zip(todo, isolated(attempt, [(seed, given.engine) for seed in todo], _PATIENCE_S), strict=True):
        row = {"seed": seed, **found}
        rows.append(row)
        with kept.open("a") as stream:
            stream.write(json.dumps(row) + "\n")
        if row["result"] != "right":
            print(f"seed {row['seed']}: {row['result']} {row.get('message', '')}", flush=True)
    rows.sort(key=lambda row: row["seed"])
    versions = {name: version(name) for name in ("estexp_jax", "mujoco")}
    name = "rows" if given.engine == "auto" else f"rows_{given.engine}"
    write_rows(out / f"{name}.parquet", rows, engine=given.engine, **versions)
    (out / name.replace("rows", "summary")).with_suffix(".json").write_text(
        json.dumps(summary(rows) | {"engine": given.engine, "versions": versions}, indent=1) + "\n"
    )
    study.publish(out, given.publish)
    return int(any(row["result"] in FAILURES for row in rows))


def attempt(seed: int, engine: str) -> dict[str, Any]:
    """What becomes of the model of a seed, as `tried` says; "crashed" where anything else than a refusal is raised."""
    from experiments.robustness.public_models.trial import tried
    from experiments.robustness.random_models.draw import random_mjcf

    with TemporaryDirectory() as folder:
        path = Path(folder) / f"drawn_{seed}.xml"
        path.write_text(random_mjcf(seed)[0])
        try:
            found = tried(path, engine)
        except Exception:
            found = {"result": "crashed", "message": traceback.format_exc()[-600:]}
    return found


def summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Counts of results, and the largest error of what is right."""
    largest = max((row["worst"] for row in rows if row["result"] == "right"), default=None)
    return {"models": len(rows), "results": dict(Counter(row["result"] for row in rows)), "largest_error": largest}


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
