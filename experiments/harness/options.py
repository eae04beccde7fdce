"""Options of studies that make runs: how large they are, how many seeds, and the folder of runs that studies share."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from estexp_jax.runs.workers import WorkerPool, worker_pool_of
from experiments.harness.recovery_case import SIZES, Size
from experiments.harness.study import ROOT, Study, words


@dataclass(frozen=True)
class Options:
    """What a study is asked for.

    Attributes:
        size: of its runs.
        n: seeds.
        workers: runs at a time; None: one, and with Ray as many as its machines have room for.
        ray: address of a Ray cluster, or `local`; None: processes of this machine.
        out: where its tables and figures go.
        store: where its runs go; studies on the same runs share it.
        publish: whether tables and figures are copied beside the study's README.
        report: only tables and figures, of the runs finished so far.
        given: all that was asked for, a study's own options among it.
    """

    size: Size
    n: int
    workers: int | None
    ray: str | None
    out: Path
    store: Path
    publish: bool = False
    report: bool = False
    given: argparse.Namespace = field(default_factory=argparse.Namespace)

    @property
    def quick(self) -> bool:
        """Whether the runs only show that everything works; nothing of them is published."""
        return self.size == "quick"

    def crew(self) -> WorkerPool:
        """Who does the runs."""
        return worker_pool_of(self.workers, self.ray, [str(ROOT)])


def options_parser(study: Study, *, seeds: int, sizes: bool = True) -> argparse.ArgumentParser:
    """A parser of the options that these studies share, for one to add its own.

    Args:
        study: which.
        seeds: how many there are by default.
        sizes: whether its runs have sizes.
    """
    parser = study.parser()
    parser.set_defaults(size="full")
    if sizes:
        parser.add_argument("--size", choices=list(SIZES), default="full", help="of the runs; full is the paper's")
    parser.add_argument("--seeds", type=int, default=seeds, help=f"how many, default {seeds}")
    parser.add_argument("--report", action="store_true", help="only tables and figures, of what is finished")
    return parser


def options_of(
    study: Study,
    arguments: Sequence[str] | None,
    *,
    seeds: int,
    quick_seeds: int,
    parser: argparse.ArgumentParser | None = None,
) -> Options:
    """The options of a study.

    Args:
        study: which.
        arguments: of the command line; None: those of the process.
        seeds: how many there are by default.
        quick_seeds: and with `--quick`.
        parser: with the study's own options; None: it has none.
    """
    parser = parser or options_parser(study, seeds=seeds)
    given = parser.parse_args(words(arguments))
    size: Size = "quick" if given.quick else given.size
    n = quick_seeds if given.quick and given.seeds == seeds else given.seeds
    out = given.out or ROOT / "out" / "experiments"
    folder = study.results(out, size, study.name)
    store = out.resolve() / size / "runs"
    return Options(
        size, n, given.workers, given.ray, folder, store, given.publish and not given.quick, given.report, given
    )
