"""The sealed set in parts, for it takes longer than a machine may be at hand.

python experiments/benchmark/run.py sealed run --workers 2 --most 60 --publish   some more cases, with their baselines
python experiments/benchmark/run.py sealed score                                 once all are there: opened

A case is drawn, explained, given to the baselines if it is one of a random 100, and scored by the frozen code; nobody
looks before all of them are there. What is published in sealed.parquet no machine does again. The seed is that of the
commit at which the first case was drawn, and every other one must be drawn there:

git worktree add FOLDER COMMIT && cp experiments/benchmark/sealed.parquet FOLDER/experiments/benchmark/
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.errors import InputError
from experiments.benchmark.baselines.all import baselines_of
from experiments.benchmark.generator.case import Plan
from experiments.benchmark.generator.plans import plans
from experiments.benchmark.on_disk import FULL, OPENINGS
from experiments.benchmark.page import log_opened, write_scored
from experiments.benchmark.sets import SEALED, frozen_commit, recordings_hash, seed_of
from experiments.harness.explain_study import Entry, ExplainStudy, numbered, row_of
from experiments.harness.rows import read_about, read_rows
from experiments.harness.study import ROOT, Study

QUICK, WITH_BASELINES = (4007, "all"), 100
"""Seed of a set for development; cases that the baselines get, too."""


def main(study: Study, arguments: Sequence[str]) -> int:
    """Do what is asked; gives the exit code."""
    published = study.folder / "sealed.parquet"
    return sealed_set(study, seed_asked(published, arguments), published).main(arguments)


def sealed_set(study: Study, seed: int, published: Path) -> ExplainStudy:
    """The set of a seed.

    Args:
        study: with the folder of the log of openings.
        seed: of the commit at which it is sealed, or the one for development.
        published: where its rows are kept.
    """
    return ExplainStudy(
        study=study,
        planned=partial(numbered, planned),
        parts=("all",),
        seed=seed,
        quick=QUICK,
        published=published,
        write_scores=partial(opened, study.folder / OPENINGS if seed != QUICK[0] else None),
        beside=partial(beside, with_baselines(seed)),
    )


def planned(seed: int, _: str) -> list[Plan]:
    """The plans of a sealed set."""
    return plans(seed, FULL, SEALED)


def with_baselines(seed: int) -> set[str]:
    """Ids of the cases that the baselines get."""
    return {f"c{i:03d}" for i in np.random.default_rng([seed, 9]).choice(FULL, WITH_BASELINES, replace=False)}


def beside(chosen: Collection[str], out: Path, case: str, answer: Mapping[str, Any]) -> dict[str, Any]:
    """What is kept beside a case's row: of its answer what the page says, a hash of its recordings, its baselines."""
    folder = out / "cases" / case
    return {
        "answer": {name: answer[name] for name in ("effects", "visibility")},
        "recordings_sha256": recordings_hash(folder),
        "baselines": baselines_of(folder, answer) if case in chosen else None,
    }


def opened(log: Path | None, out: Path, entries: Sequence[Entry], whole: int) -> Path:
    """The page of a whole set; that it was opened is noted in a log, unless it is one for development (None).

    Raises:
        InputError: some cases have not been explained yet, or not all at one commit.
    """
    if len(entries) < whole:
        raise InputError(f"{len(entries)} of {whole} cases are explained", right="`run` goes on; then it is opened")
    rows, answers = [row_of(e) for e in entries], {e["case"]: e["answer"] for e in entries if e.get("answer")}
    baselines = {e["case"]: e["baselines"] for e in entries if e.get("baselines")}
    commits = sorted({str(e["commit"]) for e in entries})
    if len(commits) > 1:
        raise InputError(f"cases of {len(commits)} commits: {', '.join(commits)}", right="a sealed set has one")
    [commit] = commits
    sealed = {"seed": seed_of(commit), "commit": commit} if log else {"seed": QUICK[0], "commit": None}
    public = sealed | {"cases": whole, "robots": list(SEALED)}
    page = write_scored(out, public, rows, answers, baselines)
    if log:
        log_opened(out, public, log)
    return page


def seed_asked(published: Path, arguments: Sequence[str]) -> int:
    """The seed of what the command line asks for: a small set for development, or that which `published` is of.

    Raises:
        InputError: as `sealed_seed`.
    """
    frozen = not {"--quick", "-h", "--help"}.intersection(arguments)
    return sealed_seed(published) if frozen else QUICK[0]


def sealed_seed(published: Path) -> int:
    """The seed of the commit that all is frozen at, but for a file of results.

    Raises:
        InputError: it is not the one at which the published cases were explained, or not frozen.
    """
    try:
        commit = frozen_commit(ROOT, but=published)
    except RuntimeError as error:
        raise InputError(str(error), where=str(ROOT)) from None
    if published.is_file() and read_about(published)["seed"] != seed_of(commit):
        first = read_rows(published)[0]["commit"]
        raise InputError(f"its set was sealed at {first}", where=str(published), right=f"check {first} out, see --help")
    return seed_of(commit)
