"""Cases from recordings of real machines: each device as it is, disjoint halves of its recordings, withheld truths."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.errors import InputError
from experiments.explain.machines.devices import DEVICES, Columns, Device, cut, read, settings
from experiments.explain.machines.score import answer_of
from experiments.explain.machines.withheld import WITHHELD, Withheld
from experiments.harness.study import ROOT

_WHERE_TO_GET = (
    "set ESTEXP_DATA to a folder that holds xl330 (github.com/Rhoban/bam), double_pendulum "
    "(github.com/dfki-ric-underactuated-lab/double_pendulum) and so101 (github.com/isaac-sim2real/sage), each with its "
    "CSV files and a nominal.xml, or put them at ../shared/data beside this repository"
)


@dataclass(frozen=True)
class MachineCase:
    """One case: recordings by role, and what is withheld.

    Attributes:
        name: of the case.
        device: whose recordings.
        train, test: files.
        withheld: what is kept from the program; None: nothing.
        base: case of the same recordings as they are.
        quick: only pieces of the recordings.
    """

    name: str
    device: Device
    train: Sequence[str]
    test: Sequence[str]
    withheld: Withheld | None = None
    base: str = field(default="")
    quick: bool = False


def data_folder() -> Path:
    """Where the recordings are: `ESTEXP_DATA`, else `../shared/data`.

    Raises:
        InputError: they are not there.
    """
    folder = Path(os.environ.get("ESTEXP_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        raise InputError("there are no recordings of real machines here", where=str(folder), right=_WHERE_TO_GET)
    return folder


def cases(data: Path, quick: bool) -> dict[str, MachineCase]:
    """All cases that the data allow, by name."""
    found: list[MachineCase] = []
    for device in DEVICES.values():
        for split, test in device.splits.items():
            if not (data / device.name).is_dir() or (quick and split != next(iter(device.splits))):
                continue
            there = device.files(data)
            train, test = [f for f in there if f not in test], [f for f in test if f in there]
            train, test = (train[: device.most], test[:2]) if quick else (train, test)
            base, halves = f"{device.name}-{split}", (0, 1) if len(train) > 1 else ()
            found.append(MachineCase(base, device, train, test, quick=quick))
            found += [MachineCase(f"{base}-half{h}", device, train[h::2], test, base=base, quick=quick) for h in halves]
            own = [w for w in WITHHELD if (w.device, w.split) == (device.name, split)]
            found += [MachineCase(w.name, device, train, test, w, base, quick) for w in own]
    return {case.name: case for case in found}


def planned(_: int, part: str) -> dict[str, MachineCase]:
    """The cases of a part of the set: `quick`, a device, or all."""
    found = cases(data_folder(), part == "quick")
    return {name: case for name, case in found.items() if part in ("all", "quick", case.device.name)}


def write_case(out: Path, name: str, case: MachineCase) -> Mapping[str, Any]:
    """Write `out/cases/<name>/`; gives the answer."""
    if not (out / "cases" / name / "recordings.toml").is_file():
        write(case, data_folder(), out / "cases" / name)
    return answer_of(case.withheld, case.device.name)


def write(case: MachineCase, data: Path, folder: Path) -> None:
    """Write logs, model and, at last, the manifest."""
    device, source = case.device, data / case.device.name
    folder.mkdir(parents=True, exist_ok=True)
    xml = (source / "nominal.xml").read_text(encoding="utf-8")
    if case.withheld and case.withheld.model:
        old, new = case.withheld.model
        if old not in xml:
            raise ValueError(f"{device.name}'s nominal.xml has no {old}")
        xml = xml.replace(old, new)
    (folder / "nominal.xml").write_text(xml, encoding="utf-8")
    entries = []
    for role, files in (("train", case.train), ("test", case.test)):
        for file in files:
            log = cut(device, read(source / file), device.piece if case.quick else None)
            given = settings(device, file, log)
            if case.withheld:
                given = {name: value * case.withheld.factor for name, value in given.items()}
                if case.withheld.change:
                    log = case.withheld.change(log, log[device.time[0]] * device.time[1])
            write_log(folder / f"{role}_{file}", log)
            entries.append(_entry(f"{role}_{file}", role, given))
    (folder / "recordings.toml").write_text(_head(device) + "\n".join(entries), encoding="utf-8")


def write_log(path: Path, log: Columns) -> None:
    """A log as CSV."""
    np.savetxt(path, np.column_stack(list(log.values())), fmt="%.9g", delimiter=",", header=",".join(log), comments="")


def _head(device: Device) -> str:
    column, scale = device.time
    lines = ['model = "nominal.xml"', "", "[columns]", f'time = {{ column = "{column}", scale = {scale!r} }}']
    return "\n".join([*lines, *(f'"{ours}" = "{theirs}"' for ours, theirs in device.columns.items()), "", ""])


def _entry(file: str, role: str, given: Mapping[str, float]) -> str:
    lines = ["[[recording]]", f'file = "{file}"', f'role = "{role}"']
    if given:
        lines += ["[recording.set]", *(f'"{name}" = {value:.6g}' for name, value in given.items())]
    return "\n".join([*lines, ""])
