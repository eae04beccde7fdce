"""`estexp experiment repertoire`: the full algorithm against recovery without diagnosis, by trials on the robot.

estexp experiment repertoire --quick                 one seed, very small runs
estexp experiment repertoire --workers 8             10 seeds, both robots, at the paper's size
python experiments/recover/repertoire/run.py --size small --robot same
python experiments/recover/repertoire/run.py --size small --report     table and figure of what is finished
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

TRIALS = 20
"""On the damaged robot, without diagnosis; the full algorithm has five, that of the old controller among them."""
MAPS = {"repertoire": 1, "tenfold": 10}
"""Walks that a map is made of, as multiples of those that the full algorithm simulates in its explorations."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Maps, trials, and the runs that they stand against; then the table and the figure."""
    from experiments.harness.options import parsed, publish
    from experiments.harness.runs import each, run_all
    from experiments.recover.oracle_diagnosis.run import ROBOTS

    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--robot", choices=ROBOTS)
    parser.add_argument("--report", action="store_true")
    own, rest = parser.parse_known_args(sys.argv[1:] if arguments is None else list(arguments))
    options = parsed("repertoire", __doc__, seeds=10, quick_seeds=1, arguments=rest)
    cases, store = cases_of(options.size, options.n), options.store.parent / "repertoires"
    if not own.report:
        mine = [case for case in cases if own.robot in (None, case.robot)]
        run_all(mine, options)
        pairs = [(case, way) for case in mine for way in MAPS]
        first = {_map(case, way, store): (case, way) for case, way in pairs}
        each("maps", [(_mapped, *pair, store) for path, pair in first.items() if not path.is_file()], options)
        each("trials", [(_tried, *pair, store) for pair in pairs if not _path(*pair, store).is_file()], options)
    report(_rows(cases, store, options.store), options)
    publish(options, __file__)
    return 0


def cases_of(size, n: int) -> list:
    """Runs with the set search, seed by seed: those of `handed`."""
    from experiments.recover.oracle_diagnosis.run import pairs_of

    return [own for own, _ in pairs_of(size, n)]


def _map(case, way: str, store: Path) -> Path:
    return store / way / f"{case.robot}-{case.seed}.npz"


def _path(case, way: str, store: Path) -> Path:
    return store / way / f"{case.name}.json"


def budget(settings) -> int:
    """Walks that the full algorithm simulates in its explorations, those that judge the last generation included."""
    from estexp_jax.recovery.exploration import jury

    each = settings.population + (settings.generations - 1 + jury(settings)) * (settings.population // 2)
    return (settings.passes + 1) * each


def _mapped(case, way: str, store: Path) -> None:
    """The map of a seed's healthy robot."""
    import numpy as np

    from estexp_jax.runs.files import replacing
    from experiments.harness.world import world
    from experiments.recover.repertoire.repertoire import evolved

    path = _map(case, way, store)
    path.parent.mkdir(parents=True, exist_ok=True)
    *_, found = evolved(world(case.size), case.settings, MAPS[way] * budget(case.settings))
    with replacing(path) as stream:
        np.savez_compressed(stream, weights=found.weights, duty=found.duty, distance=found.distance)


def _tried(case, way: str, store: Path) -> None:
    """A damaged robot's trials."""
    import numpy as np

    from estexp_jax.runs import write_json
    from experiments.harness.world import job, trial_of
    from experiments.recover.repertoire.repertoire import Repertoire, adapted

    with np.load(_map(case, way, store)) as archive:
        gaits = Repertoire(archive["weights"], archive["duty"], archive["distance"])
    run, settings = job(case), case.settings

    def trial(weights: np.ndarray) -> float:
        return trial_of(run, weights, settings.steps).distance(settings.axis)

    tried = adapted(gaits, trial, TRIALS)
    write_json(
        _path(case, way, store),
        {"gaits": len(gaits.distance), "best": float(np.max(gaits.distance)), "distances": [d for _, d in tried]},
    )


def _rows(cases: Sequence, store: Path, runs: Path) -> list[dict[str, Any]]:
    """A row for each case of which all is finished."""
    import json

    from experiments.harness.runs import finished
    from experiments.harness.tables import result

    found = []
    for case in cases:
        paths = {way: _path(case, way, store) for way in MAPS}
        if finished(case, runs) and all(path.is_file() for path in paths.values()):
            own = result(case, runs)
            trials = [own["distance"]["damaged"], *(each["hardware_m"] for each in own["passes"])]
            row = {"robot": case.robot, "situation": case.situation, "seed": case.seed}
            row |= {"before": own["distance"]["before"], **{f"diagnosis_{i}": d for i, d in enumerate(trials)}}
            for way, path in paths.items():
                other = json.loads(path.read_text(encoding="utf-8"))
                row |= {f"gaits_{way}": other["gaits"], f"best_{way}": other["best"]}
                row |= {f"{way}_{i}": d for i, d in enumerate(other["distances"])}
            found.append(row)
    return found


def report(rows: Sequence[dict[str, Any]], options) -> None:
    """Table, numbers and figure."""
    from experiments.harness.tables import write_rows, write_summary
    from experiments.recover.repertoire.summary import draw, summary

    write_rows(options.out / "repertoire.csv", rows)
    seeds = sorted({row["seed"] for row in rows})
    write_summary(options.out / "summary.json", summary(rows), seeds=seeds, size=options.size)
    draw(rows, options.out)


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
