"""Cases as they are written: recordings and nominal model in a folder, and the answer apart."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from experiments.explain.machines.cases import write_log
from experiments.explain.several.arms import HELD, RATE, Arm, drawn_arm, drawn_motion
from experiments.explain.several.drive import change, controller, driven
from experiments.explain.several.effects import ArmEffect, accepted, drawn_effects, element
from experiments.explain.several.flaws import MOUNT, Flaw, drawn_flaw
from experiments.explain.several.plans import ArmPlan
from experiments.explain.several.real import ERROR, RealArm, Run

LOGS = (("train_0.csv", "train"), ("train_1.csv", "train"), ("test_0.csv", "test"))
_COUNTS = 2.0**14
"""Of an encoder in a turn."""
_WHITE = 2e-4
"""Its noise, rad."""
NOISE = float(np.hypot(_WHITE, 2.0 * np.pi / _COUNTS / np.sqrt(12.0)))
_CLEAR = 3.0
"""Noises that an effect must change the readings by to be visible."""


def write_case(out: Path, name: str, plan: ArmPlan) -> Mapping[str, Any]:
    """Write `out/cases/<name>/` and give the answer, which is written last; where either is gone, both are made."""
    kept, folder = out / "drawn" / f"{name}.json", out / "cases" / name
    if not (kept.is_file() and (folder / "recordings.toml").is_file()):
        answer = make(plan, folder)
        kept.parent.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(".part")
        part.write_text(json.dumps(answer), encoding="utf-8")
        part.replace(kept)
    return json.loads(kept.read_text(encoding="utf-8"))


def make(plan: ArmPlan, folder: Path) -> dict[str, Any]:
    """Draw a case, let its arm move, write what a user would have; gives the answer."""
    rng = np.random.default_rng(plan.seed)
    joint = int(rng.integers(plan.joints))
    arm = drawn_arm(plan.joints, plan.servo, joint if plan.flaw == "friction_along_path" else None, rng)
    flaw = drawn_flaw(plan.flaw, joint, arm, rng)
    effects = drawn_effects(arm, rng) if plan.group == "several" else []
    signs = rng.choice([-1.0, 1.0], (5, plan.joints))
    control = controller(arm, computed=bool(rng.integers(2)))
    real = RealArm(arm, effects, flaw, signs)
    runs = [driven(real, drawn_motion(plan.joints, plan.duration, rng), control) for _ in LOGS]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "nominal.xml").write_text(arm.xml, encoding="utf-8")
    for (file, _), run in zip(LOGS, runs, strict=True):
        write_log(folder / file, _log(run, rng))
    entries = [f'[[recording]]\nfile = "{file}"\nrole = "{role}"\n' for file, role in LOGS]
    (folder / "recordings.toml").write_text("\n".join(['model = "nominal.xml"\n', *entries]), encoding="utf-8")
    without = change(RealArm(arm, effects, Flaw(), signs), runs)
    shown = [change(RealArm(arm, [x for x in effects if x is not e], flaw, signs), runs) for e in effects]
    return answer(plan, arm, effects, flaw, signs, shown, without)


def _log(run: Run, rng: np.random.Generator) -> dict[str, np.ndarray]:
    held = round(HELD * RATE)
    count = 2.0 * np.pi / _COUNTS
    noisy = run.reading[held:] + _WHITE * rng.standard_normal(run.reading[held:].shape)
    read, joints = np.round(noisy / count) * count, range(run.command.shape[1])
    commands = {f"ctrl.m{j + 1}": run.command[held:, j] for j in joints}
    return {"time": np.arange(len(read)) / RATE, **commands, **{f"sensor.q{j + 1}": read[:, j] for j in joints}}


def answer(
    plan: ArmPlan,
    arm: Arm,
    effects: Sequence[ArmEffect],
    flaw: Flaw,
    signs: np.ndarray,
    shown: Sequence[float],
    without: float,
) -> dict[str, Any]:
    """What is true of a case, as the judge of all sets takes it, with how visible each effect and the flaw are."""
    threshold = max(_CLEAR * NOISE, without)
    told = [
        _effect(e, arm, signs) | {"change": s, "visible": s > threshold} for e, s in zip(effects, shown, strict=True)
    ]
    places = (("joint", "j"), ("body", "link"), ("actuator", "m"), ("sensor", "q"))
    axes = {f"{kind} {prefix}{j + 1}": f"j{j + 1}" for kind, prefix in places for j in range(arm.joints)}
    return {
        "group": plan.group,
        "robot": f"arm{plan.joints}" + ("_servo" if plan.servo else ""),
        "plan": asdict(plan),
        "effects": told,
        "equivalents": [_elsewhere(e, arm) for e in effects],
        "axes": axes,
        "flaw": asdict(flaw) | {"change": without, "on_base": plan.flaw == MOUNT},
        "known": {f"link{j + 1}": float(arm.model.body(f"link{j + 1}").mass[0]) for j in range(arm.joints)}
        | {f"j{j + 1}": float(arm.inertia[j]) for j in range(arm.joints)},
        "noise": NOISE,
        "onset_s": {},
        "length_s": {},
        "visibility": {"shown": max(shown, default=0.0) / NOISE},
    }


def _effect(effect: ArmEffect, arm: Arm, signs: np.ndarray) -> dict[str, Any]:
    kind, name = element(effect)
    values = {p: v + _also(effect.effect, p, effect, arm, signs) for p, v in effect.parameters.items()}
    return {
        "effect": effect.effect,
        "law": None,
        "kind": kind,
        "name": name,
        "axis": f"j{effect.joint + 1}",
        "accepted": accepted(effect, arm),
        "scored": list(values),
        "parameters": values,
    }


def _also(name: str, parameter: str, effect: ArmEffect, arm: Arm, signs: np.ndarray) -> float:
    """What the error of the model's own value adds to an effect's, as nobody can tell the two apart."""
    j = effect.joint
    if name == "body_mass":
        return ERROR * float(signs[0, j] * arm.model.body(f"link{j + 1}").mass[0])
    if name == "armature":
        return ERROR * float(signs[1, j] * arm.model.dof_armature[j])
    if name == "motor_weakness":
        return -ERROR * float(signs[2, j]) * (1.0 - effect.parameters[parameter])
    return 0.0


def _elsewhere(effect: ArmEffect, arm: Arm) -> list[str]:
    """On a planar arm without servos a bias at the first joint is a tilt of all."""
    return (
        ["gravity_tilt"]
        if effect.effect == "sensor_bias" and effect.joint == 0 and arm.joints == 2 and not arm.servo
        else []
    )
