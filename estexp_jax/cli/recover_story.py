"""The story of a recovery, told on the terminal as it happens."""

from __future__ import annotations

from typing import final

from estexp_jax.recovery.cycle import Job
from estexp_jax.recovery.evidence import estimation
from estexp_jax.recovery.situations import TABLE
from estexp_jax.recovery.state import RunState
from estexp_jax.runs import Progress


@final
class Story:
    """Tells a run, state by state.

    Args:
        progress: where to.
        job: what runs.
    """

    def __init__(self, progress: Progress, job: Job) -> None:
        self._progress, self._job = progress, job

    def begin(self, model: str, state: RunState) -> None:
        """What is going to happen, or to go on."""
        settings = self._job.settings
        what = TABLE[settings.situation] if settings.situation is not None else "damage of your choice"
        self._progress.say(f"{model}, seed {settings.seed}: {what}")
        engine, reason = self._job.simulator.walker.choice
        self._progress.say(f"  engine: {engine}, {reason}")
        for change in self._job.planted:
            self._progress.say(f"  planted: {change.sentence()}")
        if state.history:
            self._progress.say(f"going on with pass {state.number}, {state.phase}")
        self._stage(state)

    def tell(self, before: RunState, after: RunState) -> None:
        """What one step of the run brought."""
        if len(after.history) > len(before.history):
            row = after.history[-1]
            unit = " m" if row.phase == "exploration" else ""
            self._progress.advance(note=f"best {row.best:.3g}{unit}")
        self._say_news(before, after)
        if (before.phase, before.number) != (after.phase, after.number):
            self._stage(after)

    def end(self, state: RunState) -> None:
        """The run in short."""
        axis = self._job.settings.axis
        before = state.before.distance(axis) if state.before is not None else float("nan")
        trials = [trial.distance(axis) for trial in state.trials]
        self._progress.say("")
        self._progress.say(f"before the damage {before:.2f} m, damaged {trials[0]:.2f} m")
        for number, each in enumerate(state.passes(axis), start=1):
            found = "; ".join(change.sentence() for change in each.diagnosis) or "nothing differs"
            self._progress.say(f"trial {number} {each.hardware:.2f} m (foretold {each.simulated:.2f} m): {found}")
        self._progress.say(f"{len(trials)} trials on the damaged robot")

    def _say_news(self, before: RunState, after: RunState) -> None:
        axis, say = self._job.settings.axis, self._progress.say
        if len(after.controllers) > len(before.controllers):
            say(f"exploration {after.number}: the best controller comes {after.simulated[-1]:.2f} m in the simulator")
        if len(after.diagnoses) > len(before.diagnoses):
            share = after.probabilities[-1]
            sure = "" if share is None else f", probability {share:.2f}"
            found = "; ".join(change.sentence() for change in after.diagnoses[-1]) or "nothing differs"
            say(f"diagnosis {len(after.diagnoses)}: {found} (error {after.residuals[-1]:.2g}{sure})")
            for diagnosis, probability in after.rivals[-1]:
                said = "; ".join(change.sentence() for change in diagnosis) or "nothing differs"
                say(f"  not excluded, probability {probability:.2f}: {said}")
            if after.alarms[-1]:
                say("  nothing in the catalogue reproduces the recordings: do not trust this diagnosis")
        if len(after.trials) > len(before.trials):
            distance = after.trials[-1].distance(axis)
            if before.before is None and after.before is not None:
                say(f"the robot walks {after.before.distance(axis):.2f} m, is damaged, and walks {distance:.2f} m")
            else:
                say(f"trial {len(after.trials) - 1}: {distance:.2f} m, foretold {after.simulated[-1]:.2f} m")

    def _stage(self, state: RunState) -> None:
        settings, number = self._job.settings, state.number
        match state.phase:
            case "exploration":
                self._progress.stage(f"exploration {number} of {settings.passes}", settings.generations)
            case "estimation":
                rounds = estimation(self._job.simulator, settings, number).rounds()
                self._progress.stage(f"estimation {number} of {settings.passes}", rounds)
            case "damage" | "trial":
                self._progress.stage("trial")
            case _:
                self._progress.stage("report")
