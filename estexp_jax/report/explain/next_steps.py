"""What lies beside a report of `explain`, and what one may do with it."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

_FILES = {
    "findings.json": "all numbers of this page, for programs",
    "model_explained.xml": "the model, with what MJCF can hold of what was found",
    "model_explained_fine.xml": "the same at a finer time step, which predicts better",
    "model_stand_in.xml": "other values that stand in for what MJCF cannot hold",
    "explained.py": "runs what was found over plain MuJoCo, in a loop of yours",
    "effects.json": "what was found, as the simulator takes it",
    "nominal.xml": "the model as it was",
    "rivals.json": "the explanations that remain possible",
    "predictions/": "each recording beside both simulators, as CSV",
}
_SETTLED = {
    "consistent": "Nothing is open on the motions that were recorded; of others, these recordings say nothing.",
    "unexplained": "No motion is known that would tell more.",
}


def files_beside(folder: Path | None) -> list[tuple[str, str]]:
    """Names of the files that a folder holds, and what is in them; none without a folder."""
    return [] if folder is None else [(name, what) for name, what in _FILES.items() if (folder / name).exists()]


def settled(findings: Mapping[str, Any]) -> str:
    """What to say where no further recording is proposed."""
    return _SETTLED.get(findings["verdict"], "Nothing: no further recording is needed to tell apart what was tried.")


def next_commands(folder: Path | None, findings: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What each command is for, and the command; none without a folder."""
    if folder is None:
        return []
    place = repr(str(folder))
    load = f"import estexp_jax as ee\nsimulator = ee.load_explained({place})"
    commands = [("The corrected simulator, in Python", load)]
    if findings["verdict"] == "missing_physics":
        commands.append(("Ranges of what is not known, to train a controller", f"ranges = ee.randomisation({place})"))
    if (folder / "rivals.json").exists() and any(a["probability"] >= 0.05 for a in findings["alternatives"]):
        out = folder.with_name(f"{folder.name}_next")
        words = ["estexp", "propose", str(folder), "--out", str(out)]
        commands.insert(0, ("The motion that tells the explanations apart", shlex.join(words)))
    return commands
