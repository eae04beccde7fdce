"""A recovery as it looks: before the damage, damaged, recovered, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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


class FilmedWalk(NamedTuple):
    """One of the walks that are shown."""

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
        strip: JPEG; a row for each walk, in time from left to right.
        video: MP4 of the walks side by side; None: what encodes it is not installed, or too few pictures were made.
    """

    strip: bytes
    video: bytes | None

    def _repr_html_(self) -> str:
        still = f'<img alt="the walks" src="{source(self.strip, "image/jpeg")}">'
        if self.video is None:
            return still
        return f'<video controls loop muted src="{source(self.video, "video/mp4")}"></video>{still}'


def film_of(job: Job, state: RunState) -> Film | None:
    """Film a run; None where nothing can be filmed, as of robots in the real world.

    Raises:
        NoGlError: nothing here can draw.
    """
    walks = filmed_walks(job, state)
    if not walks:
        return None
    steps, period = len(walks[0].trial.time), job.settings.control_step
    moving = can_film() and not _dear(job)
    n = int(np.clip(round(steps * period * _FPS), _COLUMNS, _MOST_FRAMES)) if moving else _COLUMNS
    rows = np.unique(np.linspace(0, steps - 1, n).astype(int))
    robot = job.simulator.robot
    motions = _motions(job, walks, rows.tolist())
    shots = [_shot(robot, walk, qpos, job.settings.axis) for walk, qpos in zip(walks, motions, strict=True)]
    pictures = render_shots(drawn(robot), shots, width=_SIZE[0], height=_SIZE[1], shadows=True)
    framed = [_captioned(walk, shown, rows, job) for walk, shown in zip(walks, pictures, strict=True)]
    chosen = np.linspace(0, len(rows) - 1, _COLUMNS).astype(int)
    still = strip([[row[k] for k in chosen] for row in framed])
    if not moving:
        return Film(still, None)
    beside = [np.concatenate(frames, axis=1) for frames in zip(*framed, strict=True)]
    return Film(still, film(beside, len(rows) / (steps * period)))


def filmed_walks(job: Job, state: RunState) -> list[FilmedWalk]:
    """Before, damaged and recovered, as far as there are such walks and their targets show how they went."""
    if state.before is None or not state.trials:
        return []
    told: list[tuple[str, Target | RemoteTarget | None, int, Trial, tuple[Change, ...]]] = [
        ("before the damage", job.healthy, 0, state.before, ())
    ]
    told.append(("damaged", job.target, 0, state.trials[0], job.planted))
    if state.trials[1:]:
        last = len(state.trials) - 1
        told.append((f"recovered, trial {last}", job.target, last, state.trials[last], job.planted))
    return [FilmedWalk(title, target, state.controllers[k], trial, changes)
            for title, target, k, trial, changes in told if isinstance(target, FilmedTarget)]  # fmt: skip


def _dear(job: Job) -> bool:
    """Whether each picture takes long to simulate."""
    return isinstance(job.target, SameTarget) and job.simulator.closed_loop.choice.engine == "mjx"


def _motions(job: Job, walks: Sequence[FilmedWalk], rows: list[int]) -> list[np.ndarray]:
    """Configurations (rows, nq) of each walk."""
    planted = [walk.target.planted for walk in walks if isinstance(walk.target, SameTarget)]
    if len(planted) == len(walks):  # all in one batch
        return list(job.simulator.motions(planted, np.stack([walk.weights for walk in walks]), rows))
    length = len(walks[0].trial.time)
    return [walk.target.motion(job.simulator.controller(walk.weights, length), rows) for walk in walks]


def _shot(robot: Robot, walk: FilmedWalk, qpos: np.ndarray, axis: str) -> Shot:
    """The camera goes with the robot, but not up and down with it."""
    centre, radius = ground_covered(robot, robot.home()[None])
    places = np.array([ground_covered(robot, posture[None])[0] for posture in qpos])
    places[:, 2] = centre[2]
    return Shot(qpos[:, None], colours(robot, walk.changes)[None], places, *walking_view(axis, radius))


def _captioned(walk: FilmedWalk, pictures: Sequence[np.ndarray], rows: np.ndarray, job: Job) -> list[np.ndarray]:
    position, axis = walk.trial.position, job.settings.axis
    told = [
        f"{walk.title}: {distances_along(position[: row + 1], axis):+.2f} m, {walk.trial.time[row]:.1f} s"
        for row in rows
    ]
    return [captioned(picture, text) for picture, text in zip(pictures, told, strict=True)]
