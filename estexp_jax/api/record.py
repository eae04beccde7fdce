"""`record`, from Python and as the command: recordings of a simulated robot with chosen effects."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from estexp_jax.api.options.keywords import front_door
from estexp_jax.api.options.record import RecordOptions
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.engines.choice import left_out_by
from estexp_jax.physics.model.given import ModelLike, robot_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.replay.synthetic_recordings import RecordConfig, RecordResult, write_recordings
from estexp_jax.runs import ProgressDisplay, open_run


@front_door(RecordOptions)
def record(
    model: ModelLike,
    out: str | Path,
    *,
    effect: Sequence[str] = (),
    root: str | Path | None = None,
    duration: float = 8.0,
    rate: float = 200.0,
    bits: int = 14,
    noise: float = 2e-4,
    seed: int = 0,
    force: bool = False,
    resume: bool = False,
) -> RecordResult:
    """Simulate a robot with chosen effects, and write what it would have logged.

    Args:
        model: the nominal robot: a path, MJCF text, an MjSpec, an MjModel or a Robot.
        out: the folder that the recordings go to.
        effect: effects that the robot has and its model lacks, each as "coulomb_friction@knee T=0.5".
        root: folder under which the model finds its files; None: the repository or package around it, else three up.
        duration: of each recording, s.
        rate: rows a second.
        bits: resolution of the encoders.
        noise: deviation of the noise on positions, rad or m.
        seed: of motions and noise.
        force: replace recordings in the folder.
        resume: do an interrupted recording again.

    Raises:
        InputError: a keyword, a value, the model or an effect is wrong, or the folder cannot be used.
    """
    chosen = (effect,) if isinstance(effect, str) else tuple(effect)
    config = {"duration": duration, "rate": rate, "bits": bits, "noise": noise, "seed": seed}
    folder = None if root is None else Path(root)
    robot = robot_of(model, root)
    options = RecordOptions(Path(robot.source), Path(out), chosen, folder, **config, force=force, resume=resume)
    return record_to_folder(options, lambda _: None, robot)


def record_to_folder(options: RecordOptions, say: Callable[[str], object], robot: Robot | None = None) -> RecordResult:
    """Record as the command does, with progress.

    Args:
        options: of the command.
        say: called with what the simulation leaves out.
        robot: the model where it is in memory; None: that of the options.

    Raises:
        InputError: the model or an effect is wrong, or the folder cannot be used.
    """
    config = RecordConfig(options.duration, options.rate, options.bits, options.noise, options.seed)
    config.rows  # noqa: B018 (refuses what is impossible before anything is read)
    robot = robot or Robot.from_xml(options.model, options.root)
    changes = tuple(parse_change(text, robot) for text in options.effect)
    marker = {"command": "record", "config": {"model": str(options.model), "effect": options.effect, **vars(config)}}
    for part in left_out_by("auto", robot):
        say(f"Simulated without {part}")
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    with ProgressDisplay() as progress:
        return write_recordings(robot, changes, config, folder, progress.stage)
