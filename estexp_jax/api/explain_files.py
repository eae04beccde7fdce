"""The files that `explain` leaves."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.discovery.diagnosis import Diagnosis, Prediction
from estexp_jax.discovery.export import explained_spec, explained_xml
from estexp_jax.inference.windows import FINER
from estexp_jax.recordings.write import write_csv
from estexp_jax.runs import RunFolder, write_json, write_text

EFFECTS_SCHEMA = "estexp.effects/1"
"""Format of `effects.json`."""
RIVALS_SCHEMA = "estexp.rivals/1"
"""Format of `rivals.json`."""


def write_results(folder: RunFolder, diagnosis: Diagnosis, findings: Mapping[str, Any]) -> Path:
    """Write findings, report, both models, effects, rivals and predictions; gives the report's path."""
    from estexp_jax.report.explain_page import page

    write_json(folder.file("findings.json"), findings)
    left_out = diagnosis.left_out
    explained = explained_xml(diagnosis.case.robot, diagnosis.mjcf_changes, left_out, FINER)
    write_text(folder.file("model_explained.xml"), explained)
    nominal = explained_spec(diagnosis.case.robot, ()).to_xml()
    write_text(folder.file("nominal.xml"), nominal)
    changes = [change.to_json() for change in diagnosis.changes]
    effects = {"schema": EFFECTS_SCHEMA, "nominal": "nominal.xml", "finer": FINER, "changes": changes}
    write_json(folder.file("effects.json"), effects)
    if diagnosis.contest is not None:
        head = {"schema": RIVALS_SCHEMA, "nominal": "nominal.xml", "finer": FINER}
        write_json(folder.file("rivals.json"), {**head, **diagnosis.contest.to_json()})
    for prediction in diagnosis.predictions:
        name = f"predictions/{Path(prediction.recording).stem}.csv"
        write_csv(folder.file(name), _columns(prediction))
    report = folder.file("report.html")
    write_text(report, page(diagnosis, findings))
    return report


def _columns(prediction: Prediction) -> dict[str, np.ndarray]:
    columns = {"time": prediction.time, "window": prediction.window}
    for i, channel in enumerate(prediction.channels):
        sampled = np.isfinite(prediction.recorded[:, i])
        columns[f"{channel}.recorded"] = prediction.recorded[:, i]
        columns[f"{channel}.nominal"] = np.where(sampled, prediction.nominal[:, i], np.nan)
        columns[f"{channel}.explained"] = np.where(sampled, prediction.explained[:, i], np.nan)
    return columns
