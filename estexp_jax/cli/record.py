"""`estexp record`: recordings of a simulated robot with a chosen effect."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True)
class Options:
    """Simulate a robot with a chosen effect, and write what it would have logged.

    Writes nominal.xml, train_0.csv, train_1.csv, test_0.csv, recordings.toml, and truth.json (explain never reads it).

    Example:
        estexp record arm.xml --effect "coulomb_friction@knee T=0.5" --out out/recorded
    """

    model: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="MODEL.xml")]
    """The nominal MJCF."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Where the recordings go."""
    effect: Annotated[tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar='"EFFECT@NAME P=VALUE"')] = ()
    """An effect that the robot has and its model lacks; none: the robot is as modelled."""
    duration: float = 8.0
    """Of each recording, s."""
    rate: float = 200.0
    """Rows a second."""
    bits: int = 14
    """Resolution of the encoders."""
    noise: float = 2e-4
    """Deviation of the noise on positions, rad or m."""
    seed: int = 0
    """Of motions and noise."""
    force: bool = False
    """Replace the recordings in DIR."""
    resume: bool = False
    """Go on with an interrupted recording; short as it is, it is done again."""


def run(options: Options) -> int:
    """Simulate and write.

    Raises:
        InputError: the model or an effect is wrong, or DIR cannot be used.
    """
    from estexp_jax.api.record import RecordConfig, record
    from estexp_jax.physics.effects.changes import parse_change
    from estexp_jax.physics.engines.mjx.capabilities import reduced_to_mjx
    from estexp_jax.physics.model.robot import Robot
    from estexp_jax.runs import ProgressDisplay, open_run

    config = RecordConfig(options.duration, options.rate, options.bits, options.noise, options.seed)
    robot = Robot.from_xml(options.model)
    changes = [parse_change(text, robot) for text in options.effect]
    marker = {"command": "record", "config": {"model": str(options.model), "effect": options.effect, **vars(config)}}
    for part in reduced_to_mjx(robot).left_out:
        print(f"Simulated without {part}")
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    with ProgressDisplay() as progress:
        manifest = record(robot, changes, config, folder, progress.stage)
    for change in changes:
        print(f"The robot differs from its model: {change.sentence()}.")
    print(f"Recordings: {manifest}")
    return 0
