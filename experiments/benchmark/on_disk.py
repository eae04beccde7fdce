"""Steps of a set that stands whole on disk, with its commitment; see run.py and sets.py."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from estexp_jax.errors import InputError
from experiments.benchmark import sets
from experiments.benchmark.baselines.all import run_baselines
from experiments.benchmark.page import log_opening, write_page
from experiments.harness.explain_runner import Runner
from experiments.harness.study import ROOT, Study

QUICK, FULL = 40, 420
"""Cases of a development set and of a sealed one."""
OPENINGS = "openings.jsonl"
"""The log of opened sets, beside the README."""
_DONE, _WRONG, _INTERRUPTED = 0, 2, 3


def main(study: Study, arguments: Sequence[str]) -> int:
    """Do a step, or all of them; gives the exit code."""
    options = _parsed(study, arguments)
    try:
        return _all(options) if options.step == "all" else _STEPS[options.step](options)
    except (sets.Tampered, InputError, RuntimeError, FileNotFoundError) as error:
        print(f"benchmark: {error}", file=sys.stderr)
        return _WRONG
    except KeyboardInterrupt:
        print(f"benchmark: interrupted; --resume goes on in {options.out}", file=sys.stderr)
        return _INTERRUPTED


def _parsed(study: Study, arguments: Sequence[str]) -> argparse.Namespace:
    parser = study.parser(quick="a small development set instead of the sealed one")
    parser.add_argument("step", nargs="?", default="all", choices=["all", *_STEPS])
    parser.add_argument("--seed", type=int, default=1, help="of a development set")
    parser.add_argument("--cases", type=int, default=QUICK, help="of a development set")
    parser.add_argument("--robots", nargs="+", default=["leg", "planar"], help="of a development set")
    parser.add_argument("--most", type=int, default=100, help="cases that the baselines get, drawn by the set's seed")
    parser.add_argument("--timeout", type=float, default=1800.0, help="most seconds a case")
    options = parser.parse_args(arguments)
    kind = "quick" if options.quick else "full"
    options.out = options.out or ROOT / "out" / "experiments" / study.name / kind
    options.log = study.folder / OPENINGS
    return options


def _draw(options: argparse.Namespace) -> int:
    unknown = set(options.robots) - set(sets.DEVELOPED)
    if unknown:
        raise RuntimeError(f"no development on {', '.join(sorted(unknown))}; there are {', '.join(sets.DEVELOPED)}")
    sets.draw(options.out, options.seed, options.cases, options.robots, workers=options.workers or 1)
    return _DONE


def _seal(options: argparse.Namespace) -> int:
    if (options.out / "commitment.json").is_file():
        return _DONE
    commit = sets.frozen_commit(ROOT)
    sets.draw(options.out, sets.seed_of(commit), FULL, sets.SEALED, commit=commit, workers=options.workers or 1)
    print(f"sealed {FULL} cases of commit {commit} in {options.out}; publish its commitment.json")
    return _DONE


def _run(options: argparse.Namespace) -> int:
    left = Runner(options.out, options.workers, options.timeout, ray=options.ray).run()
    return _INTERRUPTED if left else _DONE


def _baselines(options: argparse.Namespace) -> int:
    run_baselines(options.out, most=options.most)
    return _DONE


def _score(options: argparse.Namespace) -> int:
    print(f"scores: {write_page(options.out)}")
    return _DONE


def _open(options: argparse.Namespace) -> int:
    code = _score(options)
    log_opening(options.out, options.log)
    return code


def _all(options: argparse.Namespace) -> int:
    if options.out.is_dir() and not options.resume:
        raise RuntimeError(f"{options.out} holds results; --resume goes on with them, --out puts others elsewhere")
    steps = [_draw, _run, _score] if options.quick else [_seal, _run, _baselines, _open]
    for step in steps:
        code = step(options)
        if code:
            return code
    return _DONE


_STEPS = {"draw": _draw, "seal": _seal, "run": _run, "baselines": _baselines, "score": _score, "open": _open}
