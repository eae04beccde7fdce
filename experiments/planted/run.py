"""`estexp experiment planted`: every effect planted and recovered.

estexp experiment planted --quick                    two effects at once, 20 cases
estexp experiment planted --workers 2 [--resume]     the whole set, some 450 cases
python experiments/planted/run.py draw|run|score --part single --out DIR
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

SEED = 20261
"""Of the reported set; nothing was developed on it."""
_QUICK = 4000
_DONE, _WRONG, _INTERRUPTED = 0, 2, 3


def main(arguments: list[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.concealed.sets import Tampered

    options = _parsed(sys.argv[1:] if arguments is None else arguments)
    try:
        for step in _STEPS[options.step]:
            code = step(options)
            if code:
                return code
    except (Tampered, RuntimeError, FileNotFoundError) as error:
        print(f"planted: {error}", file=sys.stderr)
        return _WRONG
    except KeyboardInterrupt:
        print(f"planted: interrupted; --resume goes on in {options.out}", file=sys.stderr)
        return _INTERRUPTED
    return _DONE


def _parsed(arguments: list[str]) -> argparse.Namespace:
    from experiments.planted.planned import PARTS

    parser = argparse.ArgumentParser(prog="planted", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("step", nargs="?", default="all", choices=list(_STEPS))
    parser.add_argument("--quick", action="store_true", help="two effects at once only, of another seed")
    parser.add_argument("--resume", action="store_true", help="go on with what an earlier run left")
    parser.add_argument("--workers", type=int, default=1, help="cases at a time")
    parser.add_argument("--out", type=Path, default=None, help="folder of the set")
    parser.add_argument("--seed", type=int, default=None, help="of another set")
    parser.add_argument("--part", choices=PARTS, default=None, help="a part of the set")
    parser.add_argument("--timeout", type=float, default=1800.0, help="most seconds a case")
    options = parser.parse_args(arguments)
    options.out = options.out or ROOT / "out" / "planted" / ("quick" if options.quick else "full")
    options.seed = options.seed or (_QUICK if options.quick else SEED)
    options.part = options.part or ("two" if options.quick else "all")
    return options


def _fresh(options: argparse.Namespace) -> int:
    if options.out.is_dir() and not options.resume:
        raise RuntimeError(f"{options.out} holds results; --resume goes on with them, --out puts others elsewhere")
    return _DONE


def _draw(options: argparse.Namespace) -> int:
    from experiments.concealed.sets import draw_plans
    from experiments.planted.planned import planned

    public = {"seed": options.seed, "part": options.part}
    draw_plans(options.out, planned(options.seed, options.part), public, workers=options.workers)
    return _DONE


def _run(options: argparse.Namespace) -> int:
    from experiments.concealed.runner import Runner

    return _INTERRUPTED if Runner(options.out, options.workers, options.timeout).run() else _DONE


def _score(options: argparse.Namespace) -> int:
    from experiments.planted.scores import write_scores

    print(f"scores: {write_scores(options.out)}")
    return _DONE


_STEPS = {"all": (_fresh, _draw, _run, _score), "draw": (_draw,), "run": (_run,), "score": (_score,)}


if __name__ == "__main__":
    sys.exit(main())
