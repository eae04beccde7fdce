"""A recovery on the terminal, line by line as it happens."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from estexp_jax.physics.effects.changes import Change, sentence_of
from estexp_jax.recovery.cycle import Job
from estexp_jax.recovery.estimation.choice import estimation_of
from estexp_jax.recovery.situations import TABLE
from estexp_jax.recovery.state import RunState
from estexp_jax.recovery.target import RemoteTarget
from estexp_jax.report.pages import metres
from estexp_jax.runs import ProgressDisplay


@final
class RecoverProgress:
    """Prints a run, state by state.

    Args:
        progress: where it is shown.
        job: what runs.
    """

    def __init__(self, progress: ProgressDisplay, job: Job) -> None:
        self._progress, self._job = progress, job

    def start(self, model: str, state: RunState) -> None:
        """Print what is going to happen, or goes on."""
        settings = self._job.settings
        what = TABLE[settings.situation] if settings.situation is not None else "damage of your choice"
        if isinstance(self._job.target, RemoteTarget):
            what = "a robot of yours"
        self._progress.say(f"{model}, seed {settings.seed}: {what}")
        engine, reason, _ = self._job.simulator.closed_loop.choice
        self._progress.say(f"  engine: {engine}, {reason}")
        for change in self._job.planted:
            self._progress.say(f"  planted: {sentence_of(self._job.simulator.robot, change)}")
        if state.history:
            self._progress.say(f"going on with pass {state.number}, {state.phase}")
        self._stage(state)

    def update(self, before: RunState, after: RunState) -> None:
        """Print what one step of the run has brought."""
        if len(after.history) > len(before.history):
            row = after.history[-1]
            unit = " m" if row.phase == "exploration" else ""
            self._progress.advance(note=f"best {row.best:.3g}{unit}")
        self._say_news(before, after)
        if (before.phase, before.number) != (after.phase, after.number):
            self._stage(after)

    def finish(self, state: RunState) -> None:
        """Print a summary of the run."""
        axis = self._job.settings.axis
        trials = [metres(trial.distance(axis)) for trial in state.trials]
        before = metres(float("nan") if state.before is None else state.before.distance(axis))
        self._progress.say("")
        self._progress.say(f"{self._undamaged} {before}, damaged {trials[0]}")
        for number, each in enumerate(state.passes(axis), start=1):
            found = self._said(each.diagnosis)
            self._progress.say(f"trial {number} {metres(each.hardware)} (predicted {each.simulated:.2f} m): {found}")
        if state.diagnoses:
            self._say_doubts(state)
        self._progress.say(f"{len(trials)} trials on the damaged robot")

    @property
    def _undamaged(self) -> str:
        return "undamaged in the simulator" if self._job.stands_in else "before the damage"

    def _say_news(self, before: RunState, after: RunState) -> None:
        axis, say = self._job.settings.axis, self._progress.say
        if len(after.controllers) > len(before.controllers):
            say(f"exploration {after.number}: the best controller comes {after.simulated[-1]:.2f} m in the simulator")
        if len(after.diagnoses) > len(before.diagnoses):
            share = after.probabilities[-1]
            sure = "" if share is None else f", probability {share:.2f}"
            found = self._said(after.diagnoses[-1])
            say(f"diagnosis {len(after.diagnoses)}: {found} (error {after.residuals[-1]:.2g}{sure})")
            self._say_doubts(after)
        if len(after.trials) > len(before.trials):
            distance = metres(after.trials[-1].distance(axis))
            if before.before is not None or after.before is None:
                say(f"trial {len(after.trials) - 1}: {distance}, predicted {after.simulated[-1]:.2f} m")
            elif self._job.stands_in:
                say(
                    f"the damaged robot walks {distance}, the undamaged simulator {metres(after.before.distance(axis))}"
                )
            else:
                say(f"the robot walks {metres(after.before.distance(axis))}, is damaged, and walks {distance}")

    def _say_doubts(self, state: RunState) -> None:
        """Print what the last diagnosis does not exclude."""
        for diagnosis, probability in state.alternatives[-1]:
            self._progress.say(f"  not excluded, probability {probability:.2f}: {self._said(diagnosis)}")
        if state.alarms[-1]:
            self._progress.say("  nothing in the catalogue reproduces the recordings: do not trust this diagnosis")

    def _said(self, diagnosis: Sequence[Change]) -> str:
        robot = self._job.simulator.robot
        return "; ".join(sentence_of(robot, change) for change in diagnosis) or "nothing differs"

    def _stage(self, state: RunState) -> None:
        settings, number = self._job.settings, state.number
        match state.phase:
            case "exploration":
                self._progress.stage(f"exploration {number} of {settings.passes}", settings.generations)
            case "estimation":
                n_iterations = estimation_of(self._job.simulator, settings, number).n_iterations()
                self._progress.stage(f"estimation {number} of {settings.passes}", n_iterations)
            case "damage" | "trial":
                self._progress.stage("trial")
            case _:
                self._progress.stage("report")
