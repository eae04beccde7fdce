"""Pictures of a recovery: before the damage, damaged and recovered, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, final

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.control.trial import Trial, distances_along
from estexp_jax.recovery.cycle import Job
from estexp_jax.recovery.state import RunState
from estexp_jax.recovery.target import FilmedTarget, RemoteTarget, SameTarget, Target
from estexp_jax.report.drawing.film import can_film, captioned, film, source, strip
from estexp_jax.report.drawing.gl import Shot, render_shots
from estexp_jax.report.drawing.robot_pictures import colours, drawn, ground_covered, walking_view

_SIZE = (320, 214)
"""Width and height of a picture, pixels; with its caption an even number."""
_FPS, _MOST_FRAMES, _COLUMNS = 15.0, 75, 5


class FilmedRun(NamedTuple):
    """A controller's run that can be drawn."""

    title: str
    target: FilmedTarget
    weights: np.ndarray
    trial: Trial
    changes: tuple[Change, ...]


@final
@dataclass(frozen=True)
class Film:
    """A recovery in pictures; shows itself in a notebook.

    Attributes:
        strip: JPEG with a row for each run; time goes from left to right.
        video: MP4 of the runs side by side; None: the encoder is not installed, or simulation of all frames is slow.
    """

    strip: bytes = field(repr=False)
    video: bytes | None = field(repr=False)

    def _repr_html_(self) -> str:
        still = f'<img alt="the walks" src="{source(self.strip, "image/jpeg")}">'
        if self.video is None:
            return still
        return f'<video controls loop muted src="{source(self.video, "video/mp4")}"></video>{still}'


def film_of(job: Job, state: RunState) -> Film | None:
    """Draw a recovery; None if nothing can be drawn, as for robots in the real world.

    Raises:
        NoGlError: no renderer works here.
    """
    runs = filmed_runs(job, state)
    if not runs:
        return None
    steps, period = len(runs[0].trial.time), job.settings.control_step
    with_video = can_film() and not _is_slow(job)
    n = int(np.clip(round(steps * period * _FPS), _COLUMNS, _MOST_FRAMES)) if with_video else _COLUMNS
    rows = np.unique(np.linspace(0, steps - 1, n).astype(int))
    robot = job.simulator.robot
    motions = _motions(job, runs, rows.tolist())
    shots = [_shot(robot, run, qpos, job.settings.axis) for run, qpos in zip(runs, motions, strict=True)]
    pictures = render_shots(drawn(robot), shots, width=_SIZE[0], height=_SIZE[1], shadows=True)
    captioned_rows = [_captioned(run, frames, rows, job) for run, frames in zip(runs, pictures, strict=True)]
    chosen = np.linspace(0, len(rows) - 1, _COLUMNS).astype(int)
    strip_jpeg = strip([[row[k] for k in chosen] for row in captioned_rows])
    if not with_video:
        return Film(strip_jpeg, None)
    side_by_side = [np.concatenate(frames, axis=1) for frames in zip(*captioned_rows, strict=True)]
    return Film(strip_jpeg, film(side_by_side, len(rows) / (steps * period)))


def filmed_runs(job: Job, state: RunState) -> list[FilmedRun]:
    """The runs before the damage, damaged and recovered, if they exist and their targets return motions."""
    if state.before is None or not state.trials:
        return []
    runs: list[tuple[str, Target | RemoteTarget | None, int, Trial, tuple[Change, ...]]] = [
        ("before the damage", job.healthy, 0, state.before, ())
    ]
    runs.append(("damaged", job.target, 0, state.trials[0], job.planted))
    if state.trials[1:]:
        last = len(state.trials) - 1
        runs.append((f"recovered, trial {last}", job.target, last, state.trials[last], job.planted))
    return [FilmedRun(title, target, state.controllers[k], trial, changes)
            for title, target, k, trial, changes in runs if isinstance(target, FilmedTarget)]  # fmt: skip


def _is_slow(job: Job) -> bool:
    """Whether each frame takes long to simulate."""
    return isinstance(job.target, SameTarget) and job.simulator.closed_loop.choice.engine == "mjx"


def _motions(job: Job, runs: Sequence[FilmedRun], rows: list[int]) -> list[np.ndarray]:
    """Configurations (rows, nq) of each run."""
    planted = [run.target.planted for run in runs if isinstance(run.target, SameTarget)]
    if len(planted) == len(runs):  # all in one batch
        return list(job.simulator.motions(planted, np.stack([run.weights for run in runs]), rows))
    length = len(runs[0].trial.time)
    return [run.target.motion(job.simulator.controller(run.weights, length), rows) for run in runs]


def _shot(robot: Robot, run: FilmedRun, qpos: np.ndarray, axis: str) -> Shot:
    """The view of a run; the camera follows the robot horizontally."""
    centre, radius = ground_covered(robot, robot.home()[None])
    places = np.array([ground_covered(robot, posture[None])[0] for posture in qpos])
    places[:, 2] = centre[2]
    return Shot(qpos[:, None], colours(robot, run.changes)[None], places, *walking_view(axis, radius))


def _captioned(run: FilmedRun, pictures: Sequence[np.ndarray], rows: np.ndarray, job: Job) -> list[np.ndarray]:
    position, axis = run.trial.position, job.settings.axis
    captions = [
        f"{run.title}: {distances_along(position[: row + 1], axis):+.2f} m, {run.trial.time[row]:.1f} s" for row in rows
    ]
    return [captioned(picture, text) for picture, text in zip(pictures, captions, strict=True)]
