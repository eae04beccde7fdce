"""The sealed set in parts, for it takes longer than a machine may be at hand.

python experiments/benchmark/sealed.py run --workers 2 --most 60 --publish   some more cases, with their rivals
python experiments/benchmark/sealed.py score                                 once all are there: opened

A case is drawn, explained, given to the rivals if it is one of a random 100, and scored by the frozen code; nobody
looks before all of them are there. What is published in sealed.json no machine does again. The seed is that of the
commit at which the first case was drawn, and every other one must be drawn there:

git worktree add FOLDER COMMIT && cp experiments/benchmark/sealed.json FOLDER/experiments/benchmark/
"""

from __future__ import annotations

import json
import sys
from collections.abc import Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from experiments.benchmark.generator.case import Plan  # noqa: E402
from experiments.benchmark.generator.plans import plans  # noqa: E402
from experiments.harness.explain_study import CaseSet, row_of  # noqa: E402

CASES, QUICK, RIVALS = 420, (4007, "all"), 100
"""Size of the sealed set; seed of one for development; cases that rivals get, too."""
_PUBLISHED = Path(__file__).with_name("sealed.json")
_OPENINGS = Path(__file__).with_name("openings.jsonl")


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    return sealed_set(seed_asked(_PUBLISHED, arguments)).main(__doc__, arguments)


def sealed_set(seed: int) -> CaseSet:
    """The set of a seed."""
    return CaseSet(
        name="benchmark",
        planned=planned,
        parts=("all",),
        seed=seed,
        quick=QUICK,
        published=_PUBLISHED,
        command=command,
        write_scores=partial(opened, _OPENINGS if seed != QUICK[0] else None),
        more=partial(beside, rivalled(seed)),
    )


def planned(seed: int, _: str) -> list[Plan]:
    """The plans of a sealed set."""
    from experiments.benchmark.sets import SEALED

    return plans(seed, CASES, SEALED)


def command(_: Plan) -> tuple[str, ...]:
    """What explains a case, as users would."""
    return (sys.executable, "-m", "estexp_jax.cli.main", "explain", "--no-pictures")


def rivalled(seed: int) -> set[str]:
    """Ids of the cases that rivals get."""
    return {f"c{i:03d}" for i in np.random.default_rng([seed, 9]).choice(CASES, RIVALS, replace=False)}


def beside(rivalled: Collection[str], out: Path, case: str, answer: dict[str, Any]) -> dict[str, Any]:
    """What is kept beside a case's row: of its answer what the page tells, a hash of its recordings, its rivals."""
    from experiments.benchmark.baselines.all import rivals_of
    from experiments.benchmark.sets import recordings_hash

    folder = out / "cases" / case
    return {
        "answer": {name: answer[name] for name in ("effects", "visibility")},
        "recordings_sha256": recordings_hash(folder),
        "rivals": rivals_of(folder, answer) if case in rivalled else None,
    }


def opened(log: Path | None, out: Path, entries: Sequence[Mapping[str, Any]], whole: int) -> Path:
    """The page of a whole set; that it was opened is noted in a log, unless it is one for development (None).

    Raises:
        InputError: some cases have not been explained yet, or not all at one commit.
    """
    from estexp_jax.errors import InputError
    from experiments.benchmark.page import log_opened, write_scored
    from experiments.benchmark.sets import SEALED, seed_of

    if len(entries) < whole:
        raise InputError(f"{len(entries)} of {whole} cases are explained", right="`run` goes on; then it is opened")
    rows, answers = [row_of(e) for e in entries], {e["case"]: e["answer"] for e in entries if "answer" in e}
    rivals = {e["case"]: e["rivals"] for e in entries if e.get("rivals")}
    commits = sorted({str(e["commit"]) for e in entries})
    if len(commits) > 1:
        raise InputError(f"cases of {len(commits)} commits: {', '.join(commits)}", right="a sealed set has one")
    [commit] = commits
    sealed = {"seed": seed_of(commit), "commit": commit} if log else {"seed": QUICK[0], "commit": None}
    public = sealed | {"cases": whole, "robots": list(SEALED)}
    page = write_scored(out, public, rows, answers, rivals)
    if log:
        log_opened(out, public, log)
    return page


def seed_asked(published: Path, arguments: Sequence[str] | None = None) -> int:
    """The seed of what the command line asks for: a small set for development, or that which `published` is of.

    Raises:
        InputError: as `sealed_seed`.
    """
    asked = sys.argv[1:] if arguments is None else arguments
    return QUICK[0] if "--quick" in asked else sealed_seed(published)


def sealed_seed(published: Path) -> int:
    """The seed of the commit that all is frozen at, but for a file of results.

    Raises:
        InputError: it is not the one at which the published cases were explained, or not frozen.
    """
    from estexp_jax.errors import InputError
    from experiments.benchmark.sets import frozen_commit, seed_of

    try:
        commit = frozen_commit(ROOT, but=published)
    except RuntimeError as error:
        raise InputError(str(error), where=str(ROOT)) from None
    known = json.loads(published.read_text(encoding="utf-8")) if published.is_file() else None
    if known is not None and known["seed"] != seed_of(commit):
        first = known["rows"][0]["commit"]
        raise InputError(f"its set was sealed at {first}", where=str(published), right=f"check {first} out, see --help")
    return seed_of(commit)


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
