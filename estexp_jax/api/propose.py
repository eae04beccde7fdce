"""`propose`, from Python and as the command: what to record next, to settle what an explanation left open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal, NamedTuple

from estexp_jax.api.options.keywords import front_door
from estexp_jax.api.options.propose import ProposeOptions
from estexp_jax.discovery.fitting import Progress as Step
from estexp_jax.experiment_design.propose import ProposeConfig, search_experiment
from estexp_jax.report.propose.files import write_proposal
from estexp_jax.report.propose.open_questions import OpenQuestions, read_open_questions
from estexp_jax.report.propose.result import Proposal
from estexp_jax.runs import ProgressDisplay, enable_compilation_cache, forget_programs, open_run


@front_door(ProposeOptions)
def propose(
    folder: str | Path,
    *,
    duration: float = 8.0,
    margin: float = 0.9,
    speed: float = 3.0,
    engine: Literal["auto", "lanes", "c", "mjx"] = "auto",
    seed: int = 0,
    progress: Callable[[Step], None] | None = None,
) -> Proposal:
    """Find the motion on which the explanations that are left disagree most.

    Args:
        folder: where `explain` wrote its results.
        duration: of the motion, s.
        margin: share of each range of command, joint and motor force that it may use.
        speed: how many times as fast as in the recordings joints may move.
        engine: auto, lanes, c or mjx.
        seed: of the search.
        progress: called with each step of the work.

    Raises:
        InputError: a keyword or a value is wrong; the folder holds no explanation, or one without alternatives.
    """
    config = ProposeConfig(duration=duration, margin=margin, speed=speed, seed=seed, engine=engine)
    return run_proposal(read_open_questions(folder), config, progress or (lambda _: None))


class WrittenProposal(NamedTuple):
    """What `propose_to_folder` found, and where it is."""

    proposal: Proposal
    commands: Path
    advice: Path
    report: Path


def propose_to_folder(options: ProposeOptions) -> WrittenProposal:
    """Propose as the command does: with progress, into a folder.

    Raises:
        InputError: the folder of the explanation holds none with alternatives, or that of the results cannot be used.
    """
    names = ("duration", "margin", "speed", "seed", "engine")
    config = replace(ProposeConfig(), **{name: getattr(options, name) for name in names})
    questions = read_open_questions(options.folder)
    marker = {"command": "propose", "config": {"folder": str(options.folder), **vars(config)}}
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    proposal = _propose_with_progress(questions, config)
    report = write_proposal(folder, proposal.proposed)
    return WrittenProposal(proposal, folder.path / "commands.csv", folder.path / "advice.md", report)


def run_proposal(questions: OpenQuestions, config: ProposeConfig, report: Callable[[Step], None]) -> Proposal:
    """Search.

    Args:
        questions: what is open.
        config: how to search.
        report: called after each step.
    """
    enable_compilation_cache()
    forget_programs()
    steps = search_experiment(questions.robot, questions.competing_models, questions.finer, config)
    while True:
        try:
            report(next(steps))
        except StopIteration as end:
            return Proposal(end.value)


def _propose_with_progress(questions: OpenQuestions, config: ProposeConfig) -> Proposal:
    running = ""
    with ProgressDisplay() as progress:

        def report(step: Step) -> None:
            nonlocal running
            if step.stage != running:
                running = step.stage
                progress.stage(step.stage, total=step.total)
            if step.done:
                progress.advance(note=step.note)

        return run_proposal(questions, config, report)
