"""`estexp experiment planted`: every effect planted and recovered.

estexp experiment planted --quick                    two effects at once, 20 cases
estexp experiment planted --workers 2 [--resume]     the whole set, some 450 cases
python experiments/planted/run.py run|score --part single --out DIR [--publish]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from estexp_jax.errors import InputError  # noqa: E402

SEED = 20261
"""Of the reported set; nothing was developed on it."""
_QUICK = 4000


def main(arguments: list[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    options = _parsed(sys.argv[1:] if arguments is None else arguments)
    for step in _STEPS[options.step]:
        step(options)
    return 0


def _parsed(arguments: list[str]) -> argparse.Namespace:
    from experiments.planted.planned import PARTS

    parser = argparse.ArgumentParser(prog="planted", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("step", nargs="?", default="all", choices=list(_STEPS))
    parser.add_argument("--quick", action="store_true", help="two effects at once only, of another seed")
    parser.add_argument("--resume", action="store_true", help="go on with what an earlier run left")
    parser.add_argument("--workers", type=int, default=None, help="cases at a time; default 1")
    parser.add_argument("--ray", nargs="?", const="local", default=None, metavar="ADDRESS", help="cases as Ray tasks")
    parser.add_argument("--out", type=Path, default=None, help="folder of the set")
    parser.add_argument("--seed", type=int, default=None, help="of another set")
    parser.add_argument("--part", choices=PARTS, default=None, help="a part of the set")
    parser.add_argument("--most", type=int, default=None, help="cases of this run; the next one goes on")
    parser.add_argument("--publish", action="store_true", help="keep the rows beside the README: any machine goes on")
    parser.add_argument("--timeout", type=float, default=1800.0, help="most seconds a case")
    options = parser.parse_args(arguments)
    options.out = (options.out or ROOT / "out" / "planted" / ("quick" if options.quick else "full")).resolve()
    options.seed = options.seed or (_QUICK if options.quick else SEED)
    options.part = options.part or ("two" if options.quick else "all")
    return options


def _run(options: argparse.Namespace) -> None:
    from estexp_jax.runs.fleet import do
    from estexp_jax.runs.lock import hold
    from estexp_jax.runs.workers import crew_of
    from experiments.planted.cases import ESTEXP, entries_of, explained, numbered

    if options.out.is_dir() and any(options.out.iterdir()) and not options.resume:
        right = "--resume goes on with them, --out puts others elsewhere"
        raise InputError("holds results", where=str(options.out), right=right)
    options.out.mkdir(parents=True, exist_ok=True)
    known = entries_of(options.out, options.seed)
    todo = {case: plan for case, plan in numbered(options.seed, options.part).items() if case not in known}
    some = list(todo.items())[: options.most]
    calls = [(explained, (options.out, case, plan, options.timeout, ESTEXP)) for case, plan in some]
    with hold(options.out), crew_of(options.workers, options.ray, [str(ROOT)]) as crew:
        do("cases", calls, crew, options.out / "under_way")


def _score(options: argparse.Namespace) -> None:
    from experiments.planted.cases import entries_of, numbered, publish, row_of
    from experiments.planted.scores import write_scores

    wanted = numbered(options.seed, options.part)
    entries = {case: entry for case, entry in entries_of(options.out, options.seed).items() if case in wanted}
    print(f"scores: {write_scores(options.out, [row_of(entry) for entry in entries.values()], len(wanted))}")
    if options.publish:
        publish(entries, options.seed)


_STEPS = {"all": (_run, _score), "run": (_run,), "score": (_score,)}


if __name__ == "__main__":
    from experiments.common.options import exit_code

    sys.exit(exit_code(main))
