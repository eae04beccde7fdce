"""`estexp propose`: the motion that tells apart what an explanation left open."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

if TYPE_CHECKING:
    from estexp_jax.api.propose import OpenQuestions, Proposal
    from estexp_jax.experiment_design.propose import ProposeConfig


@dataclass(frozen=True)
class Options:
    """Find what to record next: the motion on which the explanations that are left disagree most.

    Writes commands.csv, rivals/<n>.csv (what each explanation predicts), advice.md and report.html.

    Example:
        estexp explain recordings.toml --out out/explain
        estexp propose out/explain --out out/propose
    """

    folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="DIR")]
    """Where `estexp explain` wrote its results."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Where commands, predictions, advice and report go."""
    duration: float = 8.0
    """Of the motion, s."""
    margin: float = 0.9
    """Share of each range of command, joint and motor force that may be used."""
    speed: float = 3.0
    """How many times as fast as in the recordings joints may move."""
    engine: Annotated[str, tyro.conf.arg(metavar="auto|lanes|mjx")] = "auto"
    """What simulates: lanes, the fast one, where it can simulate the robot; else mjx."""
    seed: int = 0
    """Of the search."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted search; short as it is, it is done again."""


def run(options: Options) -> int:
    """Search, tell, and write.

    Raises:
        InputError: the folder holds no explanation with rivals, an option is wrong, or DIR cannot be used.
    """
    from estexp_jax.api.propose import propose_config_of, read_open_questions
    from estexp_jax.api.propose_files import write_proposal
    from estexp_jax.runs import open_run

    config = propose_config_of(options.duration, options.margin, options.speed, options.seed, options.engine)
    left = read_open_questions(options.folder)
    marker = {"command": "propose", "config": {"folder": str(options.folder), **vars(config)}}
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    proposal = _proposed(left, config)
    report = write_proposal(folder, proposal.proposed)
    print(proposal.summary())
    print(f"Commands: {folder.path / 'commands.csv'}\nAdvice: {folder.path / 'advice.md'}\nReport: {report}")
    return 0


def _proposed(left: OpenQuestions, config: ProposeConfig) -> Proposal:
    """Search with progress."""
    from estexp_jax.api.propose import run_proposal
    from estexp_jax.runs import ProgressDisplay

    running = ""
    with ProgressDisplay() as progress:

        def report(step: Any) -> None:
            nonlocal running
            if step.stage != running:
                running = step.stage
                progress.stage(step.stage, total=step.total)
            if step.done:
                progress.advance(note=step.note)

        return run_proposal(left, config, report)
