"""The files that `explain` leaves."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.discovery.diagnosis import Diagnosis, Prediction
from estexp_jax.discovery.export import (
    EXPLAINED_FILE,
    FINE,
    NOMINAL_FILE,
    STAND_IN,
    explained_model,
    explained_spec,
)
from estexp_jax.discovery.native_model import as_found
from estexp_jax.physics.engines.standalone.script import explained_script
from estexp_jax.physics.model.portable import portable
from estexp_jax.recordings.write import write_csv
from estexp_jax.report.drawing.gl import NoGlError
from estexp_jax.report.explain.ghosts import ghosts_of
from estexp_jax.report.explain.marked import claimed_places, marked_of
from estexp_jax.report.explain.page import explain_page
from estexp_jax.runs import RunFolder, write_json, write_text
from estexp_jax.runs.model_files import write_model, write_model_files

EFFECTS_SCHEMA = "estexp.effects/1"
"""Format of `effects.json`."""
SCRIPT = "explained.py"
"""What was found, over plain MuJoCo."""
COMPETING_SCHEMA = "estexp.rivals/1"
"""Format of `rivals.json`."""


def write_explanation(
    folder: RunFolder, diagnosis: Diagnosis, findings: Mapping[str, Any], *, pictures: bool
) -> tuple[Path, str]:
    """Write findings, report, both models, effects, competing explanations and predictions.

    Args:
        folder: where to.
        diagnosis: what was found.
        findings: complete, as in `findings.json`.
        pictures: whether the report shows the robot, and the robots in one scene.

    Returns:
        The report's path, and why it has no such picture though one was wanted, or nothing.
    """
    ghosts, marked, missing = None, None, ""
    try:
        if pictures:
            marked = marked_of(diagnosis.case.robot, claimed_places(findings))
            ghosts = ghosts_of(diagnosis)
    except NoGlError as error:
        missing = str(error)
    write_json(folder.file("findings.json"), findings)
    robot, native = diagnosis.case.robot, diagnosis.native
    kept = [(EXPLAINED_FILE, native.changes, native.finer)]
    kept += [(FINE, native.changes, diagnosis.finer)] if native.fine else []
    kept += [(STAND_IN, native.stand_in, native.finer)] if native.stand_in is not None else []
    for name, held, finer in kept:
        # Files that a model includes are written once, for the first: the others are of one piece.
        own = folder.path if name == EXPLAINED_FILE else None
        write_model_files(folder, name, explained_model(robot, held, native.left_out, finer, own))
    file = explained_spec(robot, native.changes, native.finer).compile()
    marked_changes = [(c, as_found(robot, c) in native.changes) for c in diagnosis.changes]
    write_text(folder.file(SCRIPT), explained_script(robot, marked_changes, diagnosis.finer, file))
    write_model(folder, NOMINAL_FILE, portable(explained_spec(robot, ())))
    changes = [change.to_json() for change in diagnosis.changes]
    effects = {"schema": EFFECTS_SCHEMA, "nominal": "nominal.xml", "finer": diagnosis.finer, "changes": changes}
    write_json(folder.file("effects.json"), effects)
    if diagnosis.competing_models is not None:
        head = {"schema": COMPETING_SCHEMA, "nominal": "nominal.xml", "finer": diagnosis.rivals_finer}
        write_json(folder.file("rivals.json"), {**head, **diagnosis.competing_models.to_json()})
    for prediction in diagnosis.predictions:
        name = f"predictions/{Path(prediction.recording).stem}.csv"
        write_csv(folder.file(name), _columns(prediction))
    report = folder.file("report.html")
    write_text(report, explain_page(diagnosis, findings, ghosts=ghosts, marked=marked, folder=folder.path))
    return report, missing


def _columns(prediction: Prediction) -> dict[str, np.ndarray]:
    columns = {"time": prediction.time, "window": prediction.window}
    for i, channel in enumerate(prediction.channels):
        sampled = np.isfinite(prediction.recorded[:, i])
        columns[f"{channel}.recorded"] = prediction.recorded[:, i]
        columns[f"{channel}.nominal"] = np.where(sampled, prediction.nominal[:, i], np.nan)
        columns[f"{channel}.explained"] = np.where(sampled, prediction.explained[:, i], np.nan)
    return columns
