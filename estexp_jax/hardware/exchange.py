"""A robot of the user's, reached through files in a folder.

For trial i `controller_<i>.npz` and `commands_<i>.csv` are written there, and `trial_<i>.csv`, the recording of the
robot under that controller, is waited for. Where the robot can still be had as it was before its damage,
`healthy_0.csv` is the same under the first controller.

The controller's file says which run a trial belongs to. A recording beside another controller's file, or
beside none, is refused. No file of the user's is ever removed or written.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import final

import numpy as np

from estexp_jax.errors import InputError, listing, unwritable
from estexp_jax.hardware.controller_files import read_controller
from estexp_jax.hardware.log import ExpectedTrial, trial_of_recording
from estexp_jax.hardware.onboard import OnboardController
from estexp_jax.hardware.plausibility import plausibility_notes
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.bind import read_recording
from estexp_jax.recordings.write import write_csv
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Controller, Trial
from estexp_jax.recovery.estimation.error_model import SAMPLES
from estexp_jax.runs import ProgressDisplay
from estexp_jax.runs.files import replacing
from estexp_jax.runs.lock import FolderLock, lock_folder

POLL = 0.5
"""Time between two looks for a recording, s."""
PATIENCE = 3.0
"""Time without a change after which a recording that cannot be used is no longer one that is still being written, s."""
_OURS, _THEIRS = ("controller_*.npz", "commands_*.csv"), ("trial_*.csv", "healthy_*.csv")


@final
class HardwareTarget:
    """A `RemoteTarget` that writes controllers and waits for recordings, as the module says.

    Args:
        robot: the nominal robot.
        settings: of the run.
        folder: for the files.
        progress: where to say what is waited for.
        recording: how recordings are called: `trial`, or `healthy` for the robot before its damage.
        poll: time between two looks for a recording, s.
        patience: time without a change after which one that cannot be used is an error, s.
    """

    def __init__(
        self,
        robot: Robot,
        settings: Settings,
        folder: Path,
        progress: ProgressDisplay,
        recording: str = "trial",
        *,
        poll: float = POLL,
        patience: float = PATIENCE,
    ) -> None:
        self._robot, self._settings, self._folder, self._progress = robot, settings, folder, progress
        self._recording, self._poll, self._patience = recording, poll, patience

    def perform(self, number: int, controller: Controller, predicted: Trial) -> Trial:
        """Write the controller's files, and wait for the recording.

        Raises:
            InputError: the recording cannot be used, or is that of another controller; or the folder cannot be written.
        """
        asked, log = self._folder / f"controller_{number}.npz", self._folder / f"{self._recording}_{number}.csv"
        if log.exists() and not _is_of(asked, controller):
            what = f"is there, and {asked.name} of this run is not: it is another run's"
            raise InputError(what, where=str(log), right="move it away, then the same command with --resume goes on")
        self._ask(number, asked, controller, predicted)
        say = self._progress.say
        duration = controller.steps * controller.control_step
        who = "the robot before its damage" if self._recording == "healthy" else "the robot"
        say(f"wanted: {log}, a recording of {who}, {duration:g} s from rest at home under {asked.name}")
        self._progress.stage(f"waiting for {log}")
        settings = self._settings
        wanted = ExpectedTrial(
            controller,
            predicted,
            settings.axis,
            compared=min(max(SAMPLES, settings.samples), controller.steps),
            needs_distance=settings.metric == "distance",
        )
        trial, notes = self._wait_for(log, wanted)
        for note in notes:
            say(f"  {log.name}: {note}")
        return trial

    def _ask(self, number: int, asked: Path, controller: Controller, predicted: Trial) -> None:
        motors = self._robot.command_columns()
        columns = {f"ctrl.{name}": column for name, column in zip(motors, predicted.commands.T, strict=True)}
        # The controller comes last: where it is, the commands are too.
        write_csv(self._folder / f"commands_{number}.csv", {"time": predicted.time, **columns})
        with replacing(asked) as stream:
            np.savez(stream, **OnboardController.of(controller, motors).to_arrays(), allow_pickle=False)

    def _wait_for(self, log: Path, wanted: ExpectedTrial) -> tuple[Trial, tuple[str, ...]]:
        """The trial, as soon as its file stays the same from one look to the next.

        A logger that writes now and then leaves a file alone while it is not complete, so an error counts only after
        some patience.
        """
        before, since = None, time.monotonic()
        while True:
            now = _stamp(log)
            if now is None or now != before:
                before, since = now, time.monotonic()
            else:
                try:
                    recording = read_recording(self._robot, log)
                    trial, notes = trial_of_recording(self._robot, recording, wanted, str(log))
                    suspicions = plausibility_notes(
                        wanted.controller, trial, wanted.predicted, wanted.compared, str(log)
                    )
                    return trial, (*recording.notes, *notes, *suspicions)
                except InputError:
                    if time.monotonic() - since >= self._patience:
                        raise
            time.sleep(self._poll)


def lock_exchange_folder(folder: Path, *, fresh: bool, force: bool) -> FolderLock:
    """Make a folder for the files, or take one; no other process gets it as long as the result lives.

    Args:
        folder: new, empty, or that of an earlier run.
        fresh: whether a run begins: files of another one would be taken for its own.
        force: replace controllers and commands of an earlier run.

    Raises:
        InputError: it holds recordings of an earlier run, or its controllers and `force` is not given; or it cannot be
            used.
    """
    check_exchange_folder(folder, fresh=fresh, force=force)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = lock_folder(folder)
        for path in _found(folder, _OURS) if fresh else ():
            path.unlink()
    except OSError as error:
        raise unwritable(folder, error) from None
    return lock


def check_exchange_folder(folder: Path, *, fresh: bool, force: bool) -> None:
    """As `lock_exchange_folder`, without touching anything."""
    if folder.exists() and not folder.is_dir():
        raise InputError("is a file", where=str(folder), right="a folder for controllers and trials")
    if not fresh:
        return
    trials, ours = _found(folder, _THEIRS), _found(folder, _OURS)
    if trials:
        what = f"holds recordings of an earlier run: {listing(path.name for path in trials)}"
        right = "--resume goes on with that run; else give an empty folder or move them away (--force leaves them)"
        raise InputError(what, where=str(folder), right=right)
    if ours and not force:
        what = f"holds controllers of an earlier run: {listing(path.name for path in ours)}"
        right = "--resume goes on with that run, --force replaces them; or give another folder"
        raise InputError(what, where=str(folder), right=right)


def _found(folder: Path, patterns: tuple[str, ...]) -> list[Path]:
    return sorted(path for pattern in patterns for path in folder.glob(pattern))


def _stamp(path: Path) -> tuple[int, int] | None:
    """Size and time of the last change; None where there is no file, or an empty one."""
    try:
        found = path.stat()
    except OSError:
        return None
    return (found.st_size, found.st_mtime_ns) if found.st_size else None


def _is_of(path: Path, controller: Controller) -> bool:
    try:
        return np.array_equal(read_controller(path).weights, controller.weights)
    except InputError:
        return False
