"""`estexp experiment repertoire`: the full algorithm against recovery without diagnosis, by trials on the robot.

estexp experiment repertoire --quick                 one seed, very small runs
estexp experiment repertoire --workers 8             10 seeds, both robots, at the paper's size
python experiments/recover/repertoire/run.py --size small --robot same
python experiments/recover/repertoire/run.py --size small --report     table and figure of what is finished
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from experiments.harness.options import Options
    from experiments.harness.recovery_case import RecoveryCase, Size

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Maps, trials, and the runs that they stand against; then the table and the figure."""
    from experiments.harness.options import options_of, options_parser
    from experiments.harness.recovery_runs import each, run_cases
    from experiments.harness.study import Study
    from experiments.recover.oracle_diagnosis.run import ROBOTS
    from experiments.recover.repertoire import trials

    study = Study.of(__file__, __doc__)
    parser = options_parser(study, seeds=10)
    parser.add_argument("--robot", choices=ROBOTS, help="default: both")
    options = options_of(study, arguments, seeds=10, quick_seeds=1, parser=parser)
    cases, store = cases_of(options.size, options.n), options.store.parent / "repertoires"
    if not options.report:
        mine = [case for case in cases if options.given.robot in (None, case.robot)]
        run_cases(mine, options)
        pairs = [(case, way) for case in mine for way in trials.MAPS]
        first = {trials.map_path(*pair, store): pair for pair in pairs}
        missing = [pair for path, pair in first.items() if not path.is_file()]
        each("maps", [(trials.evolve_map, *pair, store) for pair in missing], options)
        missing = [pair for pair in pairs if not trials.trials_path(*pair, store).is_file()]
        each("trials", [(trials.try_gaits, *pair, store) for pair in missing], options)
    report(cases, store, options)
    study.publish(options.out, options.publish)
    return 0


def cases_of(size: Size, n: int) -> list[RecoveryCase]:
    """Runs with the set search, seed by seed: those of `oracle_diagnosis`."""
    from experiments.recover.oracle_diagnosis.run import pairs_of

    return [own for own, _ in pairs_of(size, n)]


def report(cases: Sequence[RecoveryCase], store: Path, options: Options) -> None:
    """Table, numbers and figure."""
    from experiments.harness.recovery_rows import write_summary
    from experiments.harness.rows import write_rows
    from experiments.recover.repertoire.summary import draw, summary
    from experiments.recover.repertoire.trials import rows_of

    rows = rows_of(cases, store, options.store)
    write_rows(options.out / "rows.parquet", rows)
    seeds = sorted({row["seed"] for row in rows})
    write_summary(options.out / "summary.json", summary(rows), seeds=seeds, size=options.size)
    draw(rows, options.out)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
