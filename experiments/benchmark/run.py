"""`estexp experiment benchmark`: conceal effects, explain the recordings, score the explanations.

estexp experiment benchmark --quick               a development set of 40 cases, explained and scored
estexp experiment benchmark                       the sealed set of this commit: seal, run, rivals, open
python experiments/benchmark/run.py draw --out DIR --seed 7 --cases 20 --robots leg planar
python experiments/benchmark/run.py seal|run|rivals|score|open --out DIR
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

QUICK, FULL = 40, 420
_DONE, _WRONG, _INTERRUPTED = 0, 2, 3


def main(arguments: list[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from estexp_jax.errors import InputError
    from experiments.benchmark import sets

    options = _parsed(sys.argv[1:] if arguments is None else arguments)
    try:
        return _STEPS[options.step](options)
    except (sets.Tampered, InputError, RuntimeError, FileNotFoundError) as error:
        print(f"concealed: {error}", file=sys.stderr)
        return _WRONG
    except KeyboardInterrupt:
        print(f"concealed: interrupted; --resume goes on in {options.out}", file=sys.stderr)
        return _INTERRUPTED


def _parsed(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="benchmark", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("step", nargs="?", default="all", choices=list(_STEPS))
    parser.add_argument("--quick", action="store_true", help="a small development set instead of the sealed one")
    parser.add_argument("--resume", action="store_true", help="go on with what an earlier run left")
    parser.add_argument("--workers", type=int, default=None, help="cases at a time; default 1")
    parser.add_argument(
        "--ray", nargs="?", const="local", default=None, metavar="ADDRESS", help="explain on a Ray cluster"
    )
    parser.add_argument("--out", type=Path, default=None, help="folder of the set")
    parser.add_argument("--seed", type=int, default=1, help="of a development set")
    parser.add_argument("--cases", type=int, default=QUICK, help="of a development set")
    parser.add_argument("--robots", nargs="+", default=["leg", "planar"], help="of a development set")
    parser.add_argument("--most", type=int, default=100, help="cases that rivals get, drawn by the set's seed")
    parser.add_argument("--timeout", type=float, default=1800.0, help="most seconds a case")
    options = parser.parse_args(arguments)
    kind = "quick" if options.quick else "sealed"
    options.out = options.out or ROOT / "out" / "benchmark" / kind
    return options


def _draw(options: argparse.Namespace) -> int:
    from experiments.benchmark import sets

    unknown = set(options.robots) - set(sets.DEVELOPED)
    if unknown:
        raise RuntimeError(f"no development on {', '.join(sorted(unknown))}; there are {', '.join(sets.DEVELOPED)}")
    sets.draw(options.out, options.seed, options.cases, options.robots, workers=options.workers or 1)
    return _DONE


def _seal(options: argparse.Namespace) -> int:
    from experiments.benchmark import sets

    if (options.out / "commitment.json").is_file():
        return _DONE
    commit = sets.frozen_commit(ROOT)
    sets.draw(options.out, sets.seed_of(commit), FULL, sets.SEALED, commit=commit, workers=options.workers or 1)
    print(f"sealed {FULL} cases of commit {commit} in {options.out}; publish its commitment.json")
    return _DONE


def _run(options: argparse.Namespace) -> int:
    from experiments.harness.explain_runner import Runner

    left = Runner(options.out, options.workers, options.timeout, ray=options.ray).run()
    return _INTERRUPTED if left else _DONE


def _rivals(options: argparse.Namespace) -> int:
    from experiments.benchmark.baselines.all import run_rivals

    run_rivals(options.out, most=options.most)
    return _DONE


def _score(options: argparse.Namespace) -> int:
    from experiments.benchmark.page import write_page

    print(f"scores: {write_page(options.out)}")
    return _DONE


def _open(options: argparse.Namespace) -> int:
    from experiments.benchmark.page import log_opening

    code = _score(options)
    log_opening(options.out, Path(__file__).with_name("openings.jsonl"))
    return code


def _all(options: argparse.Namespace) -> int:
    if options.out.is_dir() and not options.resume:
        raise RuntimeError(f"{options.out} holds results; --resume goes on with them, --out puts others elsewhere")
    begin = _draw if options.quick else _seal
    steps = [begin, _run, _score] if options.quick else [begin, _run, _rivals, _open]
    for step in steps:
        code = step(options)
        if code:
            return code
    return _DONE


_STEPS = {"all": _all, "draw": _draw, "seal": _seal, "run": _run, "rivals": _rivals, "score": _score, "open": _open}


if __name__ == "__main__":
    sys.exit(main())
