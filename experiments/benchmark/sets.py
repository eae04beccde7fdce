"""Sets of cases on disk: drawn from a seed, sealed by a commitment, checked before they are opened.

    out/cases/<id>/      recordings, manifest, nominal MJCF: what an explainer sees
    out/answers.json     the answers and a salt, in one file; no program but the scorer reads it
    out/commitment.json  seed, size, SHA-256 of (salt + answers) and of all recordings: may be published at once

The seed of a sealed set is the SHA-256 of the commit that froze package, thresholds and scoring, so nobody chooses it.
"""

from __future__ import annotations

import hashlib
import json
import secrets
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from experiments.benchmark.generator.__main__ import write_set
from experiments.benchmark.generator.plans import plans

DEVELOPED = ("leg", "planar", "arm6", "cartpole", "quadruped")
"""Robots of development sets."""
SEALED = (*DEVELOPED, "scara")
"""Robots of sealed sets: one more, on which nothing was developed."""


class Tampered(Exception):
    """Answers or recordings are not those that were committed to."""


def draw(
    out: Path,
    seed: int,
    n: int,
    robots: Sequence[str],
    *,
    shorter: float = 1.0,
    commit: str | None = None,
    workers: int = 1,
) -> None:
    """Write a set, or what is missing of it.

    Args:
        out: its folder.
        seed: decides everything.
        n: number of cases.
        robots: names.
        shorter: share of the recordings' usual length.
        commit: of a sealed set, the commit its seed comes from.
        workers: processes that draw.
    """
    if (out / "commitment.json").is_file():
        return
    answers = write_set(out, plans(seed, n, robots), shorter, workers)
    kept = {"salt": secrets.token_hex(16), "answers": answers}
    _write(out / "answers.json", kept)
    public = {"seed": seed, "cases": len(answers), "robots": list(robots), "commit": commit}
    public |= {"answers_sha256": answers_hash(kept), "recordings_sha256": recordings_hash(out / "cases")}
    _write(out / "commitment.json", public)
    shutil.rmtree(out / "drawn")


def open_answers(out: Path) -> dict[str, dict[str, Any]]:
    """The answers of a set, after a check against its commitment.

    Raises:
        Tampered: answers or recordings are others than those committed to.
    """
    public = json.loads((out / "commitment.json").read_text(encoding="utf-8"))
    kept = json.loads((out / "answers.json").read_text(encoding="utf-8"))
    if answers_hash(kept) != public["answers_sha256"]:
        raise Tampered(f"{out / 'answers.json'} is not what was committed to")
    if recordings_hash(out / "cases") != public["recordings_sha256"]:
        raise Tampered(f"the recordings in {out / 'cases'} are not those that were committed to")
    return kept["answers"]


def answers_hash(kept: dict[str, Any]) -> str:
    """SHA-256 of the salt and the answers in canonical JSON; the salt keeps answers from being guessed."""
    text = kept["salt"] + json.dumps(kept["answers"], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def recordings_hash(folder: Path) -> str:
    """SHA-256 of all files of a folder with their paths."""
    total = hashlib.sha256()
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        total.update(f"{path.relative_to(folder).as_posix()} {content}\n".encode())
    return total.hexdigest()


def frozen_commit(repository: Path, but: Path | None = None) -> str:
    """The commit everything is frozen at, but for a file of results.

    Raises:
        RuntimeError: there are changes that no commit holds.
    """
    except_it = [] if but is None else [f":(exclude){but.relative_to(repository)}"]
    if _git(repository, "status", "--porcelain", "--", ".", *except_it):
        raise RuntimeError("commit everything first: a sealed set's seed is the commit that froze the package")
    return _git(repository, "rev-parse", "HEAD")


def seed_of(commit: str) -> int:
    """The seed of a commit: the first 60 bits of its SHA-256."""
    return int(hashlib.sha256(commit.encode()).hexdigest()[:15], 16)


def _git(repository: Path, *arguments: str) -> str:
    done = subprocess.run(["git", "-C", str(repository), *arguments], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def _write(path: Path, content: Any) -> None:
    part = path.with_suffix(".part")
    part.write_text(json.dumps(content, indent=1, sort_keys=True), encoding="utf-8")
    part.replace(path)
