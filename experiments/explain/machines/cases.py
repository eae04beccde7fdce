"""Cases from real logs: each device as it is, disjoint halves of its recordings, logs with something withheld.

Withheld truth is known because it was put there. Only the command and sensor sides, and what the program is told, can
be changed faithfully in a log: a command that is logged early is a robot that obeys late; a load that the program is
told too light is a mass it must find. Where only positions are read, masses and motors scaled alike move alike: a value
told wrong must be further off than others, bent by 30 %, could make up for.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from experiments.explain.machines.devices import DEVICES, Columns, Device, cut, read, settings

Spoil = Callable[[Columns, np.ndarray], Columns]
"""A log changed, given its time in s."""
Truth = tuple[str, str, str, float]
"""Effect, element, parameter and its value."""


@dataclass(frozen=True)
class Withheld:
    """Something known that is kept from the program.

    Attributes:
        name: of the case.
        device, split: whose logs.
        truth: effect, element, parameter and its value; None: nothing is missing that was not missing before.
        spoil: what is done to each log.
        model: what is replaced in the MJCF.
        factor: of the settings told.
        same: another truth that says the same of these logs.
    """

    name: str
    device: str
    split: str
    truth: Truth | None
    spoil: Spoil | None = None
    model: tuple[str, str] | None = None
    factor: float = 1.0
    same: Truth | None = None


@dataclass(frozen=True)
class Plan:
    """One case: recordings by role, and what is withheld."""

    name: str
    device: Device
    train: Sequence[str]
    test: Sequence[str]
    withheld: Withheld | None = None
    base: str = field(default="")


def late(column: str, seconds: float) -> Spoil:
    """A column that shows what was so many seconds before (negative: after)."""

    def spoil(log: Columns, time: np.ndarray) -> Columns:
        return log | {column: np.interp(time - seconds, time, log[column])}

    return spoil


def scaled(column: str, factor: float, offset: float = 0.0) -> Spoil:
    """A column times a factor plus an offset."""
    return lambda log, time: log | {column: factor * log[column] + offset}


def quantised(column: str, step: float) -> Spoil:
    """A column rounded to steps."""
    return lambda log, time: log | {column: np.round(log[column] / step) * step}


_XL330, _PENDULUM, _SO101 = ("xl330", "kp800"), ("double_pendulum", "swing_up"), ("so101", "held_out")
WITHHELD = (
    Withheld(
        "xl330-late-command",
        *_XL330,
        ("command_delay", "servo", "delay", 0.06),
        late("goal_position", -0.06),
        same=("sensor_delay", "angle", "delay", 0.06),  # the servo's own loop is not logged
    ),
    Withheld("xl330-biased-sensor", *_XL330, ("sensor_bias", "angle", "bias", 0.15), scaled("position", 1.0, 0.15)),
    Withheld("xl330-wrong-scale", *_XL330, ("sensor_gain", "angle", "gain", 1.25), scaled("position", 1.25)),
    Withheld(
        "xl330-light-load",
        *_XL330,
        ("body_mass", "arm", "dm", 0.34),
        model=('mass="0.49"', 'mass="0.15"'),
        same=("motor_weakness", "servo", "loss", 1.0 - 0.15 / 0.49),
    ),
    Withheld("xl330-stiff-servo", *_XL330, ("motor_weakness", "servo", "loss", 0.75), factor=4.0),
    Withheld("xl330-coarse-encoder", *_XL330, None, quantised("position", 0.0123)),
    Withheld(
        "pendulum-light-link",
        *_PENDULUM,
        ("body_mass", "link2", "dm", 0.31279),
        model=(
            'mass="0.62557" diaginertia="0.009970 0.009970 0.0005"',
            'mass="0.31278" diaginertia="0.004985 0.004985 0.00025"',
        ),
    ),
    Withheld(
        "pendulum-weak-motor",
        *_PENDULUM,
        ("motor_weakness", "elbow", "loss", 0.7),
        scaled("tau_meas2", 1.0 / 0.3),
    ),
    Withheld(
        "pendulum-biased-sensor",
        *_PENDULUM,
        ("sensor_bias", "q2", "bias", 0.1),
        scaled("pos_meas2", 1.0, 0.1),
        same=("joint_offset", "elbow", "offset", 0.1),  # torques drive the last joint: no motion tells them apart
    ),
    Withheld("pendulum-late-command", *_PENDULUM, ("command_delay", "elbow", "delay", 0.04), late("tau_meas2", -0.04)),
    Withheld("so101-late-command", *_SO101, ("command_delay", "Elbow", "delay", 0.06), late("command_Elbow", -0.06)),
    Withheld(
        "so101-biased-sensor",
        *_SO101,
        ("sensor_bias", "Wrist_Roll_pos", "bias", 0.15),
        scaled("position_Wrist_Roll", 1.0, 0.15),
    ),
    Withheld("so101-wrong-scale", *_SO101, ("sensor_gain", "Pitch_pos", "gain", 1.2), scaled("position_Pitch", 1.2)),
)
"""All withheld truths; scored against the same logs without them."""


def plans(data: Path, quick: bool) -> list[Plan]:
    """All cases that the data allow."""
    found = []
    for device in DEVICES.values():
        for split, test in device.splits.items():
            if not (data / device.name).is_dir() or (quick and split != next(iter(device.splits))):
                continue
            there = device.files(data)
            train, test = [f for f in there if f not in test], [f for f in test if f in there]
            train, test = (train[: device.most], test[:2]) if quick else (train, test)
            base = f"{device.name}-{split}"
            found.append(Plan(base, device, train, test))
            found += [Plan(f"{base}-half{h}", device, train[h::2], test, base=base) for h in (0, 1) if len(train) > 1]
            for w in WITHHELD:
                if (w.device, w.split) == (device.name, split):
                    found.append(Plan(w.name, device, train, test, w, base))
    return found


def write(plan: Plan, data: Path, folder: Path, quick: bool) -> None:
    """Write a case: logs, model and manifest."""
    device, source = plan.device, data / plan.device.name
    folder.mkdir(parents=True, exist_ok=True)
    xml = (source / "nominal.xml").read_text(encoding="utf-8")
    if plan.withheld and plan.withheld.model:
        old, new = plan.withheld.model
        if old not in xml:
            raise ValueError(f"{device.name}'s nominal.xml has no {old}")
        xml = xml.replace(old, new)
    (folder / "nominal.xml").write_text(xml, encoding="utf-8")
    entries = []
    for role, files in (("train", plan.train), ("test", plan.test)):
        for file in files:
            log = cut(device, read(source / file), device.piece if quick else None)
            told = settings(device, file, log)
            if plan.withheld:
                told = {name: value * plan.withheld.factor for name, value in told.items()}
                if plan.withheld.spoil:
                    log = plan.withheld.spoil(log, log[device.time[0]] * device.time[1])
            _write_csv(folder / f"{role}_{file}", log)
            entries.append(_entry(f"{role}_{file}", role, told))
    (folder / "recordings.toml").write_text(_head(device) + "\n".join(entries), encoding="utf-8")


def _write_csv(path: Path, log: Columns) -> None:
    np.savetxt(path, np.column_stack(list(log.values())), fmt="%.9g", delimiter=",", header=",".join(log), comments="")


def _head(device: Device) -> str:
    column, scale = device.time
    lines = ['model = "nominal.xml"', "", "[columns]", f'time = {{ column = "{column}", scale = {scale!r} }}']
    return "\n".join([*lines, *(f'"{ours}" = "{theirs}"' for ours, theirs in device.columns.items()), "", ""])


def _entry(file: str, role: str, told: dict[str, float]) -> str:
    lines = ["[[recording]]", f'file = "{file}"', f'role = "{role}"']
    if told:
        lines += ["[recording.set]", *(f'"{name}" = {value:.6g}' for name, value in told.items())]
    return "\n".join([*lines, ""])


def score(withheld: Withheld, findings: dict[str, Any], base: dict[str, Any] | None) -> dict[str, Any]:
    """Whether a withheld truth was found.

    Args:
        withheld: what it is.
        findings: of the spoilt logs.
        base: findings of the logs as they are; what they claim of the same parameter already is taken off.

    Returns:
        found (its effect, or one that says the same, is claimed at its place, or at all motors where there is but one),
        as (which one), named_first, value and error relative to the truth.
    """
    if withheld.truth is None:
        same = base is not None and claims(findings) == claims(base)
        return {"found": same or findings["verdict"] == (base or {}).get("verdict"), "named_first": None, "error": None}
    first = findings["what"][0] if findings["what"] else {}
    told: dict[str, Any] = {"found": False, "as": None, "named_first": False, "value": None, "error": None}
    lone = sum(column.startswith("ctrl.") for column in DEVICES[withheld.device].columns) == 1
    for truth in (withheld.truth, withheld.same):
        if truth is None:
            continue
        effect, element, parameter, true = truth
        names = (element, "*") if lone else (element,)
        own, before = (_value(f, effect, names, parameter) for f in (findings, base))
        if own is None:
            continue
        neutral = 1.0 if effect == "sensor_gain" else 0.0
        expected = _combined(effect, neutral if before is None else before, true)
        return {
            "found": True,
            "as": f"{effect}@{element}",
            "named_first": (first.get("effect"), first.get("name")) == (effect, element),
            "value": own,
            "error": abs(own - expected) / abs(true - neutral),
        }
    return told


def _combined(effect: str, before: float, added: float) -> float:
    """The value to be found where one was already there: gains and losses multiply, the rest adds."""
    if effect == "motor_weakness":
        return 1.0 - (1.0 - before) * (1.0 - added)
    return before * added if effect == "sensor_gain" else before + added


def _value(findings: dict[str, Any] | None, effect: str, names: Sequence[str], parameter: str) -> float | None:
    for claim in (findings or {"what": []})["what"]:
        if claim["effect"] == effect and claim["name"] in names:
            return claim["parameters"][parameter]["value"]
    return None


def claims(findings: dict[str, Any]) -> set[str]:
    """What was claimed, as effect@name."""
    return {f"{c['effect']}@{c['name']}" for c in findings["what"]}


def agreement(a: dict[str, Any], b: dict[str, Any]) -> float | None:
    """Share of all effects named on two halves that both name; None where neither names any."""
    one, other = claims(a), claims(b)
    return len(one & other) / len(one | other) if one | other else None


def safe(name: str) -> str:
    """A name that is a folder's."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", name)
