"""Bad manifests and bad run folders: what another program, a crash or somebody else may have left there."""

from __future__ import annotations

import json
import os
import random
import shutil
from functools import lru_cache
from pathlib import Path
from typing import Any

from experiments.robustness.fuzz import draw
from experiments.robustness.fuzz.logs import MODEL, good_csv

TOML = """model = "arm.xml"
[columns]
time = { column = "time", unit = "s" }
"ctrl.servo" = { column = "goal", scale = 1.0, offset = 0.0 }
"sensor.angle" = "position"
[[recording]]
file = "log.csv"
role = "train"
[recording.set]
"actuator.servo.kp" = 2.0
"body.body_1.mass" = 1.0
"""
WORDS = (
    "arm.xml", "log.csv", "time", "goal", "position", "servo", "kp", "mass", "1.0", "2.0", "0.0", '"train"', '"s"',
    "column", "unit", "scale", "offset", "[columns]", "[[recording]]", "file", "role", "sensor.angle", "ctrl.servo",
    "[]", "{}", "true", "1979-05-27", '""', "[nan, 1]", "0x" + "f" * 5000, "[" * 3000,
)  # fmt: skip
RESULTS = ("rivals.json", "effects.json", "findings.json", "nominal.xml", "model_explained.xml")
MARKER, CHECKPOINT = ".estexp-run.json", "checkpoint.npz"


def manifest(source: random.Random, folder: Path) -> list[str]:
    """A `recordings.toml`, its model and its log good."""
    (folder / "arm.xml").write_text(MODEL)
    (folder / "log.csv").write_bytes(good_csv())
    links(folder)
    content = draw.replaced(source, TOML, WORDS).encode("utf-8", "surrogatepass")
    if draw.chance(source, 0.3):
        content = draw.mutated(source, content)
    (folder / "recordings.toml").write_bytes(content)
    return ["check", str(folder / "recordings.toml")]


def links(folder: Path) -> None:
    """Links that lead nowhere, round, and out."""
    for name, target in (("loop", "loop"), ("out", "/dev/zero"), ("link", "/etc/passwd")):
        os.symlink(target, folder / name)


class RunFolders:
    """Damaged copies of what `explain` and `recover` left.

    Args:
        good: a folder with `recorded/` (a manifest and logs), `explained/` and `recovered/`.
    """

    def __init__(self, good: Path) -> None:
        self.good = good

    def __call__(self, source: random.Random, folder: Path) -> list[str]:
        """A damaged folder, and a command that takes it."""
        match source.randrange(4):
            case 0:
                shutil.copytree(self.good / "explained", folder / "run")
                self._damage(source, folder / "run", source.choice(("rivals.json", "nominal.xml", "rivals.json")))
                return ["propose", str(folder / "run"), "--out", str(folder / "new")]
            case 1:
                shutil.copytree(self.good / "explained", folder / "run")
                self._damage(source, folder / "run", source.choice(("effects.json", "nominal.xml", "effects.json")))
                return ["load_explained", str(folder / "run")]
            case 2:
                job, name = "explain", source.choice((MARKER, MARKER, CHECKPOINT))
            case _:
                job, name = "recover", source.choice((MARKER, CHECKPOINT, CHECKPOINT))
        shutil.copytree(self.good / ("explained" if job == "explain" else "recovered"), folder / "run")
        self._damage(source, folder / "run", name)
        how = "--resume" if name == CHECKPOINT else source.choice(("--resume", "--resume", "--force"))
        return [*self.command(job), "--out", str(folder / "run"), how]

    def command(self, job: str) -> list[str]:
        """The command that the good folder was made with."""
        return json.loads((self.good / f"{job}.json").read_text())

    def _damage(self, source: random.Random, run: Path, name: str) -> None:
        path = run / name
        content = path.read_bytes()
        match source.randrange(6):
            case 0:
                path.write_bytes(draw.mutated(source, content))
            case 1:
                path.unlink()
                os.symlink(source.choice((name, "/dev/zero", "/etc/passwd", "nowhere", "..")), path)
            case 2 if name == MARKER:
                document = json.loads(content)
                document["written"] = [source.choice((*draw.PATHS, "../canary", "report.html")) for _ in range(3)]
                path.write_text(json.dumps(document))
            case _ if name.endswith(".json"):
                path.write_text(json.dumps(draw.changed(source, json.loads(content))))
            case _ if name.endswith(".npz"):
                (run / f"{name}.previous").unlink(missing_ok=True)
                path.write_bytes(_tree(source, content))
            case _:
                path.write_bytes(draw.mutated(source, content))


def _tree(source: random.Random, content: bytes) -> bytes:
    """A checkpoint that is whole, and says something else."""
    import io

    import numpy as np

    arrays = dict(_arrays(content))
    tree = json.loads(arrays["tree"].tobytes())
    if draw.chance(source, 0.7):
        arrays["tree"] = np.frombuffer(json.dumps(draw.changed(source, tree)).encode(), np.uint8)
    else:
        name = source.choice([n for n in arrays if n != "tree"])
        odd = np.zeros((0,)), np.zeros((2, 3)), np.array("x"), np.full(5, np.nan), np.float64(2.0)
        arrays[name] = np.asarray(source.choice(odd))
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **arrays)
    return stream.getvalue()


@lru_cache(maxsize=2)
def _arrays(content: bytes) -> tuple[tuple[str, Any], ...]:
    import io

    import numpy as np

    with np.load(io.BytesIO(content)) as archive:
        return tuple((name, archive[name]) for name in archive.files)
