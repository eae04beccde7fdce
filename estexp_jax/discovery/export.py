"""The explained model as MJCF: what MJCF can say is in it, what it cannot is named."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import mujoco

from estexp_jax.physics.effects.changes import Change, sentence_of
from estexp_jax.physics.effects.new_elements import ROTOR, passive_motor_text
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.written import mjcf_refusal, written
from estexp_jax.physics.model.files import is_file
from estexp_jax.physics.model.portable import ASSETS, portable
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.source_model import ModelFiles, changed_source

NOMINAL_FILE, EXPLAINED_FILE = "nominal.xml", "model_explained.xml"
FINE, STAND_IN = "model_explained_fine.xml", "model_stand_in.xml"
"""The model at a finer step, and the one with values that stand in for what MJCF has no place for."""
RESULTS = (NOMINAL_FILE, EXPLAINED_FILE, FINE, STAND_IN)
"""Models of a result; files that a model includes stand beside them."""
_DECLARATION = re.compile(r"\s*<\?xml[^>]*\?>\s*\n?")


def expressible(robot: Robot, change: Change) -> bool:
    """Whether MJCF has a place for a change of a robot."""
    return not mjcf_refusal(robot, change)


def is_plain_value(robot: Robot, change: Change) -> bool:
    """Whether MJCF holds a change as a value of an element that is there, so that states stay what they are."""
    return expressible(robot, change) and not effect(change.effect).extends_mjcf


def explained_spec(robot: Robot, changes: Sequence[Change], finer: float = 1) -> mujoco.MjSpec:
    """A compiled description of the robot with the changes in it that MJCF can express, at a part of the robot's step.

    Files the model refers to (meshes, textures) are given by absolute paths.
    """
    spec = written(robot if finer == 1 else robot.finer(finer), changes)
    folder = Path(robot.source).resolve().parent
    if list(spec.meshes) or list(spec.hfields) or list(spec.skins):
        spec.compiler.meshdir = str(folder / spec.compiler.meshdir)
    if any(texture.file for texture in spec.textures):
        spec.compiler.texturedir = str(folder / spec.compiler.texturedir)
    spec.compile()
    return spec


def explained_model(
    robot: Robot,
    changes: Sequence[Change],
    left_out: Sequence[tuple[Change, str]],
    finer: int,
    folder: Path | None = None,
) -> ModelFiles:
    """The files of `explained_spec`, headed by what is in it and what it lacks, and why.

    As the user wrote them, where that can be: only what changed differs. Else MuJoCo's own text of the model.

    Args:
        robot: the nominal robot.
        changes: what is in it.
        left_out: what it lacks, and why.
        finer: part of the robot's step that it takes.
        folder: where it goes, not over the user's own files; None: in one piece, as MuJoCo writes it.
    """
    spec = explained_spec(robot, changes, finer)
    lines = _heading(robot, spec, changes, left_out, finer)
    source = Path(robot.source)
    elsewhere = _is_file(robot) and (folder is not None and folder.resolve() != source.resolve().parent)
    own = (
        changed_source(source, robot.spec.copy(), spec, taken=RESULTS, spelled=passive_motor_text)
        if elsewhere
        else None
    )
    if own is None:
        text, files = portable(spec)
        own = ModelFiles(text, {}, {f"{ASSETS}/{name}": path for name, path in files.items()})
    comment = "\n     ".join(lines).replace("--", "- -")
    declared = _DECLARATION.match(own.text)
    at = declared.end() if declared else 0
    return replace(own, text=f"{own.text[:at]}<!-- {comment} -->\n{own.text[at:]}")


def _is_file(robot: Robot) -> bool:
    return robot.source.endswith(".xml") and is_file(Path(robot.source))


def _heading(
    robot: Robot, spec: mujoco.MjSpec, changes: Sequence[Change], left_out: Sequence[tuple[Change, str]], finer: int
) -> list[str]:
    told = " with the physics that its recordings show it lacked" if changes or left_out else ""
    lines, step = [f"The nominal model{told}."], robot.model.opt.timestep
    lines += [f"Its step is {step / finer:g} s instead of {step:g} s."] if finer > 1 else []
    lines += [f"In it: {sentence_of(robot, c)}." for c in changes]
    lines += [f"NOT in it: {sentence_of(robot, c)} ({c.place}); {why}." for c, why in left_out]
    if any(any(joint.damping[1:]) or any(joint.stiffness[1:]) for joint in spec.joints):
        lines += ["Damping or stiffness of several numbers, one for each power, needs MuJoCo 4."]
    if any(effect(c.effect).extends_mjcf for c in changes):
        lines += ["Its elements are MuJoCo 4's. After a reset, delayed commands are 0 until the first ones arrive."]
    if any(a.name not in robot.names("joint") and ROTOR in a.name for a in spec.joints):
        lines += [f"A joint named ..{ROTOR} is a motor's: at a reset, put it where its joint is."]
    return lines
