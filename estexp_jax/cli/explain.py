"""`estexp explain`: find the physics that a simulator lacks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from estexp_jax.api.explain import explain_to_folder
from estexp_jax.api.options.explain import ExplainOptions


def explain_command(options: ExplainOptions) -> int:
    """Explain, write, and print what was found.

    Raises:
        InputError: an input or option is wrong, or DIR cannot be used.
    """
    written = explain_to_folder(options)
    if written.no_pictures:
        print(f"No picture of the robots: {written.no_pictures}")
    print(written.result.summary())
    native = written.result.diagnosis.native
    for change, why in native.left_out:
        print(f"model_explained.xml is without {change.place}: {why}; explained.py has it.")
    print(_model_line(written.result.diagnosis.findings["fit"]))
    if native.fine:
        print("model_explained_fine.xml predicts better: it takes a finer step.")
    if native.stand_in is not None:
        print("model_stand_in.xml predicts better: other values stand in for what it is without.")
    print(f"Report: {written.report}")
    return 0


def _model_line(fit: Mapping[str, Any]) -> str:
    """How far the file is off on the test recordings, beside the findings and the nominal model."""
    own, found, nominal = (_percent(fit[name].get("test")) for name in ("mjcf", "explained", "nominal"))
    return f"model_explained.xml in MuJoCo alone: test error {own} (findings {found}, nominal model {nominal})."


def _percent(error: float | None) -> str:
    return "none" if error is None or not math.isfinite(error) else f"{100.0 * error:.3g} %"
