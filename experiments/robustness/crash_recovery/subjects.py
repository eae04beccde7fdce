"""What is killed: the commands at small settings, and how two of their results are compared."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pyarrow import parquet

HERE = Path(__file__).parent
ESTEXP = (sys.executable, "-m", "estexp_jax.cli.main")
COMMANDS = ("recover", "explain", "experiment")

_RECOVER = "--situation 3 --seed 1 --population 8 --generations 3 --steps 30 --settle-steps 10 --passes 2".split()
_EXPLAIN = "--most 1 --effects coulomb_friction viscous_friction command_delay --window 1".split()
_COSTS = ("cost", "wall_s", "taken_up")
"""Fields that say what a result cost: they differ from run to run."""


def prepare(inputs: Path) -> None:
    """Record what `explain` is to explain."""
    if not (inputs / "recordings.toml").is_file():
        model, effect = str(HERE / "pendulum.xml"), "coulomb_friction@elbow T=0.35"
        sizes = ("--duration", "4", "--rate", "100", "--seed", "31")
        command = (*ESTEXP, "record", model, "--effect", effect, "--out", str(inputs), "--force", *sizes)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def line(command: str, inputs: Path, out: Path) -> list[str]:
    """The command line; with `--resume` it goes on, and begins where there is nothing."""
    arguments = {
        "recover": ("recover", *_RECOVER),
        "explain": ("explain", str(inputs / "recordings.toml"), *_EXPLAIN),
        "experiment": ("experiment", str(HERE / "subject"), "--workers", "2"),
    }
    return [*ESTEXP, *arguments[command], "--out", str(out), "--resume"]


def unreadable(out: Path) -> list[str]:
    """Files under their own names that cannot be read to the end; a kill may leave none."""
    return [str(path.relative_to(out)) for path in _files(out) if not _whole(path)]


def drafts(out: Path) -> list[str]:
    """Files being written: drafts, not under their own names."""
    return sorted(str(path.relative_to(out)) for path in out.rglob(".*.part")) if out.is_dir() else []


def differences(one: Path, other: Path) -> list[str]:
    """Results that differ in anything but what they cost, or that only one has."""
    left, right = (
        {str(path.relative_to(out)): path for path in _files(out) if _is_result(path)} for out in (one, other)
    )
    alone = sorted(left.keys() ^ right.keys())
    return alone + [name for name in left.keys() & right.keys() if _content(left[name]) != _content(right[name])]


def _files(out: Path) -> list[Path]:
    return [p for p in sorted(out.rglob("*")) if p.is_file() and not p.name.endswith((".part", ".lock"))]


def _is_result(path: Path) -> bool:
    return not path.name.startswith((".", "checkpoint")) and path.suffix != ".html" and "under_way" not in path.parts


def _content(path: Path) -> Any:
    if path.suffix == ".json":
        found = json.loads(path.read_text(encoding="utf-8"))
        return {k: v for k, v in found.items() if k not in _COSTS} if isinstance(found, dict) else found
    if path.suffix == ".parquet":
        rows = parquet.read_table(path)
        return rows.drop_columns([name for name in _COSTS if name in rows.column_names]).to_pylist()
    if path.suffix == ".csv":
        rows = csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"), newline=""))
        return [{k: v for k, v in row.items() if k not in _COSTS} for row in rows]
    return path.read_bytes()


def _whole(path: Path) -> bool:
    try:
        _READERS.get(path.suffix, Path.read_bytes)(path)
    except Exception:  # whatever a reader may say of half a file
        return False
    return True


def _read_csv(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    if not text.endswith("\n") or len({len(row) for row in csv.reader(io.StringIO(text, newline=""))}) != 1:
        raise ValueError("a row is cut")


def _read_npz(path: Path) -> None:
    with np.load(path, allow_pickle=False) as archive:
        for name in archive.files:
            archive[name]


def _read_html(path: Path) -> None:
    if not path.read_text(encoding="utf-8").rstrip().endswith("</html>"):
        raise ValueError("the end is cut")


def _read_parquet(path: Path) -> None:
    parquet.read_table(path)


_READERS: dict[str, Callable[[Path], Any]] = {
    ".json": lambda path: json.loads(path.read_text(encoding="utf-8")),
    ".toml": lambda path: tomllib.loads(path.read_text(encoding="utf-8")),
    ".xml": ET.parse,
    ".csv": _read_csv,
    ".npz": _read_npz,
    ".previous": _read_npz,
    ".html": _read_html,
    ".parquet": _read_parquet,
}
