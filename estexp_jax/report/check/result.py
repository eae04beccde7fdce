"""What `check` found, for Python and Jupyter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from html import escape
from pathlib import Path
from typing import Any, NamedTuple, final

from estexp_jax.physics.effects.registry import logging_faults
from estexp_jax.recordings.checks.copied_recordings import copied_recordings
from estexp_jax.recordings.checks.excitation import missing
from estexp_jax.recordings.checks.inspect import judge
from estexp_jax.recordings.inputs import Inputs
from estexp_jax.recordings.settings import apply_settings
from estexp_jax.report.check.figure import draw_check
from estexp_jax.report.check.text import check_sentences, check_tables
from estexp_jax.report.tables import TextTable
from estexp_jax.runs import RunFolder, open_run, versions, write_json


class CheckFiles(NamedTuple):
    """Where results were written."""

    json_file: Path
    figure: Path


@final
@dataclass(frozen=True, eq=False)
class CheckResult:
    """Recordings and what was found in them; prints itself as tables in a notebook.

    Attributes:
        inputs: the model and its recordings.
        recordings: what was found in each, as in `check.json`.
    """

    inputs: Inputs
    recordings: list[dict[str, Any]]

    @property
    def advice(self) -> list[str]:
        """What to record next."""
        return list(missing(self.recordings))

    def tables(self) -> list[TextTable]:
        """Recordings, joints and commands."""
        return check_tables(self.recordings)

    def sentences(self) -> list[str]:
        """What looks wrong, and what to record next."""
        return check_sentences(self.recordings)

    def summary(self) -> str:
        """The tables and the sentences as text."""
        return "\n\n".join([*(table.text() for table in self.tables()), "\n".join(self.sentences())])

    def to_json(self) -> Mapping[str, Any]:
        """The contents of `check.json`."""
        judged = {"model": self.inputs.model, "recordings": self.recordings, "advice": self.advice}
        return {**judged, "versions": versions()}

    def write(self, out: str | Path, *, force: bool = False) -> CheckFiles:
        """Write `check.json` and `check.png` into a folder.

        Raises:
            InputError: the folder holds results and `force` is not set.
        """
        return write_check(open_run(out, force=force), self)

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        found = "".join(f"<li>{escape(sentence)}</li>" for sentence in self.sentences())
        return "".join(table.html() for table in self.tables()) + f"<ul>{found}</ul>"


def check_inputs(inputs: Inputs) -> CheckResult:
    """Judge each recording, with what is known to differ in it."""
    judged, kinds = list[dict[str, Any]](), {e.name for e in logging_faults()}
    for recording in inputs.recordings:  # of one recorder: what physics does not hide in the first it hides in none
        beside = not judged or any(fault["kind"] in kinds for each in judged for fault in each["faults"])
        robot = apply_settings(inputs.robot, recording.settings, where=recording.name)
        judged.append(judge(robot, recording, beside_physics=beside))
    for index, fault in copied_recordings(inputs.recordings):
        judged[index]["faults"].append(asdict(fault))
        judged[index]["suspicions"].append(f"{fault.name}: {fault.sentence}")
    return CheckResult(inputs, judged)


def write_check(folder: RunFolder, result: CheckResult) -> CheckFiles:
    """Write `check.json` and `check.png`."""
    files = CheckFiles(folder.file("check.json"), folder.file("check.png"))
    write_json(files.json_file, result.to_json())
    draw_check(result.inputs.robot, result.inputs.recordings, files.figure)
    return files
