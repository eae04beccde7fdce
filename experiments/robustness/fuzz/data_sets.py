"""Bad LeRobot data sets: folders whose description, index or tables are damaged, missing, or links elsewhere."""

from __future__ import annotations

import json
import os
import random
from pathlib import Path

import numpy as np

from experiments.robustness.fuzz import draw
from experiments.robustness.fuzz.logs import ROWS, columns, model


def lerobot(source: random.Random, folder: Path) -> list[str]:
    """A LeRobot data set."""
    kept = _data_set(folder / "set")
    info = json.loads((folder / "set/meta/info.json").read_text())
    match source.randrange(4):
        case 0:
            (folder / "set/meta/info.json").write_text(json.dumps(draw.changed(source, info)))
        case 1:
            odd = ("{file_index}", "{x}", "{file_index:99d}", "*", "{", "\0", "{file_index.__class__}")
            info["data_path"] = source.choice(draw.PATHS) + source.choice(odd) + ".parquet"
            (folder / "set/meta/info.json").write_text(json.dumps(info))
        case 2:
            path = source.choice(kept)
            path.write_bytes(draw.mutated(source, path.read_bytes()))
        case _:
            path = source.choice(kept)
            path.unlink()
            if draw.chance(source, 0.7):
                os.symlink(source.choice(("/dev/zero", path.name, "/etc/passwd", "..")), path)
            info[source.choice(list(info))] = draw.value(source)
            if path.name != "info.json":
                (folder / "set/meta/info.json").write_text(json.dumps(info))
    episode = source.choice(("1", "1", "0", "-1", "99", "1e9", "true", '"1"'))
    text = f'model = "{model(folder)}"\n[columns]\ntime = "timestamp"\n'
    text += '"ctrl.servo" = { column = "action", index = 1 }\n'
    text += f'"sensor.angle" = "observation.state.elbow.pos"\n[[recording]]\nfile = "set"\nepisode = {episode}\n'
    (folder / "recordings.toml").write_text(text)
    return ["check", str(folder / "recordings.toml")]


def _data_set(folder: Path) -> list[Path]:
    """A good data set of two episodes in one file; gives its files."""
    import pyarrow
    from pyarrow import parquet as files

    for kind in ("meta/episodes/chunk-000", "data/chunk-000"):
        (folder / kind).mkdir(parents=True)
    log, two = columns(), np.repeat([0, 1], ROWS)
    lists = [[[0.0, value] for value in np.tile(log[name], 2)] for name in ("goal", "position")]
    table = {"action": lists[0], "observation.state": lists[1], "timestamp": np.tile(log["time"], 2)}
    table |= {"episode_index": two, "frame_index": np.tile(np.arange(ROWS), 2)}
    files.write_table(pyarrow.table(table), folder / "data/chunk-000/file-000.parquet")
    index = {"episode_index": [0, 1], "data/chunk_index": [0, 0], "data/file_index": [0, 0]}
    files.write_table(pyarrow.table(index), folder / "meta/episodes/chunk-000/file-000.parquet")
    feature = {"dtype": "float64", "shape": [2], "names": ["shoulder.pos", "elbow.pos"]}
    info = {"codebase_version": "v3.0", "total_episodes": 2, "fps": 100, "chunks_size": 1000}
    info |= {"data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"}
    info |= {"features": {"action": feature, "observation.state": feature}}
    (folder / "meta/info.json").write_text(json.dumps(info))
    return sorted(path for path in folder.rglob("*") if path.is_file())
