"""`estexp explain`: find the physics that a simulator lacks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from estexp_jax.errors import InputError

if TYPE_CHECKING:
    from estexp_jax.api.explain import ExplainResult
    from estexp_jax.api.inputs import Inputs
    from estexp_jax.discovery.diagnosis import ExplainConfig
    from estexp_jax.runs import RunFolder


@dataclass(frozen=True)
class Options:
    """Find the physics that a simulator lacks: locate, name, model, prove on recordings that were not fitted.

    Example:
        estexp explain recordings.toml --out out/explain
        estexp explain nominal.xml a.csv b.csv --test c.csv --map ctrl.servo=goal_position --out out/explain
    """

    files: Annotated[tyro.conf.Positional[tuple[str, ...]], tyro.conf.arg(metavar="FILE [FILE ...]")]
    """A recordings.toml; or the nominal MJCF model and logs of its robot."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Where findings.json, report.html, model_explained.xml, effects.json and predictions/ go."""
    test: Annotated[
        tyro.conf.UseAppendAction[tuple[tuple[str, ...], ...]], tyro.conf.arg(metavar="FILE [FILE ...]")
    ] = ()
    """Logs that are kept for the proof; without any, the last one given."""
    map: Annotated[tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="OURS=THEIRS")] = ()
    """A column of the logs that has another name than ours."""
    window: str = "2"
    """Length of the windows that are compared and written, s; or `full`, whole recordings."""
    most: int = 5
    """Largest number of effects in an explanation; more than three only where these explain most of the mismatch."""
    effects: tuple[str, ...] = ()
    """Names of the effects to consider; without any, all."""
    engine: Annotated[str, tyro.conf.arg(metavar="auto|lanes|mjx")] = "auto"
    """What simulates: lanes, the fast one, where it can simulate the robot; else mjx."""
    seed: int = 0
    """Of the resampling behind probabilities and intervals."""
    pictures: bool = True
    """Show the robots, as recorded and as predicted, in one scene in the report, where a GL is."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted explanation."""


def run(options: Options) -> int:
    """Explain, tell, and write.

    Raises:
        InputError: an input or option is wrong, or DIR cannot be used.
    """
    from estexp_jax.api.explain import explain_config_of
    from estexp_jax.api.explain_files import write_results
    from estexp_jax.api.inputs import read_inputs
    from estexp_jax.runs import open_run

    config = explain_config_of(
        _window(options.window), options.most, options.effects or None, options.seed, options.engine
    )
    tests = [path for group in options.test for path in group]
    inputs = read_inputs(options.files, test=tests, maps=options.map)
    files = {"files": options.files, "test": tests, "map": options.map, "window": options.window}
    chosen = {"most": config.most, "effects": config.effects, "seed": config.seed, "engine": config.engine}
    marker = {"command": "explain", "config": {**files, **chosen}}
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    explanation = _explained(inputs, config, folder)
    report, missing = write_results(folder, explanation.diagnosis, explanation.findings, pictures=options.pictures)
    if missing:
        print(f"No picture of the robots: {missing}")
    print(explanation.summary())
    for change in explanation.diagnosis.left_out:
        print(f"MJCF has no place for {change.place}: model_explained.xml is fitted without it; load_explained has it.")
    print(f"Report: {report}")
    return 0


def _window(text: str) -> float:
    if text == "full":
        return float("inf")
    try:
        return float(text)
    except ValueError:
        raise InputError(f"'{text}' is no length", where="--window", right="a number of seconds, or 'full'") from None


def _explained(inputs: Inputs, config: ExplainConfig, folder: RunFolder) -> ExplainResult:
    """Explain with progress, keeping after each step what an interruption would lose."""
    from estexp_jax.api.explain import run_explanation
    from estexp_jax.physics.engines.mjx.capabilities import reduced_to_mjx
    from estexp_jax.runs import ProgressDisplay, load_checkpoint, save_checkpoint

    kept = folder.file("checkpoint.npz")
    memory: dict[str, Any] = (load_checkpoint(kept) or {}) if folder.resumed else {}
    if not isinstance(memory, dict):
        raise InputError("the checkpoint is damaged", where=str(kept), right="begin anew with --force")
    running = ""
    with ProgressDisplay() as progress:
        progress.say(f"Explaining {len(inputs.recordings)} recordings of {inputs.model.name}")
        for part in reduced_to_mjx(inputs.robot).left_out:
            progress.say(f"Simulated without {part}")
        progress.stage("replaying the nominal simulator")

        def report(step: Any) -> None:
            nonlocal running
            save_checkpoint(kept, memory)
            if step.stage != running:
                running = step.stage
                progress.stage(step.stage, total=step.total)
            else:
                progress.advance(note=step.note)

        explanation = run_explanation(inputs, config, memory, report)
    return explanation
