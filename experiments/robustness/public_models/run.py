"""`estexp experiment public_models`: models that nobody here wrote, through `ee.simulate`, against plain MuJoCo.

estexp experiment public_models --quick
python experiments/robustness/public_models/run.py --resume --publish
"""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

PACKAGES = ("dm_control==1.0.50", "gymnasium==1.4.0", "robosuite==1.5.2")
_PATIENCE_S = 300.0
RESULTS = ("right", "chaotic", "refused", "unstable", "wrong", "crashed")


def main(arguments: Sequence[str] | None = None) -> int:
    """All models of the packages; those of an earlier run are not tried again with --resume."""
    from estexp_jax.runs.versions import version
    from experiments.harness.isolated import isolated
    from experiments.harness.rows import write_rows
    from experiments.harness.study import Study, words
    from experiments.robustness.public_models.trial import tried

    study = Study.of(__file__, __doc__)
    parser = study.parser(quick="three models a package")
    parser.add_argument("--engine", default="auto", help="of `ee.simulate`")
    parser.add_argument("--packages", type=Path, help="folder of wheels; default: they are downloaded")
    given = parser.parse_args(words(arguments))
    out = study.results(given.out)
    kept = out / f"{given.engine}.jsonl"
    if not given.resume:
        kept.unlink(missing_ok=True)
    done = [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []
    with TemporaryDirectory() as temporary:
        models = unpacked(Path(temporary), given.packages)
        known = {(row["package"], row["model"]) for row in done}
        todo = [m for m in _few(models, 3 if given.quick else None) if m[:2] not in known]
        calls = [(path, given.engine) for _, _, path in todo]
        for (package, name, _), found in zip(todo, isolated(tried, calls, _PATIENCE_S), strict=True):
            done.append({"package": package, "model": name, **found})
            with kept.open("a") as stream:
                stream.write(json.dumps(done[-1]) + "\n")
            print(f"{package} {name}: {found['result']} {found.get('message', '')}", flush=True)
    done.sort(key=lambda row: (row["package"], row["model"]))
    versions = {name: version(name) for name in ("estexp_jax", "mujoco")}
    write_rows(out / "rows.parquet", done, engine=given.engine, packages=list(PACKAGES), **versions)
    (out / "summary.json").write_text(json.dumps(summary(done) | {"versions": versions}, indent=1) + "\n")
    (out / "models.md").write_text(listing(done))
    study.publish(out, given.publish)
    return int(any(row["result"] in ("wrong", "crashed") for row in done))


def unpacked(folder: Path, wheels: Path | None) -> list[tuple[str, str, Path]]:
    """Package, path in it, and place of each MJCF, from wheels that are downloaded without their dependencies."""
    if wheels is None:
        wheels = folder / "wheels"
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", str(wheels), *PACKAGES]
        subprocess.run(command, check=True)
    found = []
    for wheel in sorted(wheels.glob("*.whl")):
        package = "-".join(wheel.name.split("-")[:2])
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(folder / package)
        paths = sorted((folder / package).rglob("*.xml"))
        found += [(package, path.relative_to(folder / package).as_posix(), path) for path in paths]
    return found


def _few(models: list[tuple[str, str, Path]], most: int | None) -> list[tuple[str, str, Path]]:
    packages = dict.fromkeys(package for package, _, _ in models)
    return [m for package in packages for m in [m for m in models if m[0] == package][:most]]


def summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Counts of results by package and in all, the largest error of what is right, and the longest first result."""
    counted = {package: dict(Counter(r["result"] for r in rows if r["package"] == package)) for package in _names(rows)}
    tried = [row for row in rows if row["result"] in RESULTS]
    return {
        "packages": counted,
        "models": len(tried),
        "results": dict(Counter(row["result"] for row in tried)),
        "largest_error": max((row["worst"] for row in tried if row["result"] == "right"), default=None),
        "longest_first_s": max((row["first_s"] for row in tried if "first_s" in row), default=None),
    }


def _names(rows: Sequence[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(row["package"] for row in rows))


def listing(rows: Sequence[dict[str, Any]]) -> str:
    """All models as a table."""
    head = "| package | model | result | nv, nu, sensors | largest error, share of range | first result, s |"
    lines = ["# Models", "", head, "|---|---|---|---|---|---|"]
    for row in rows:
        sizes = ", ".join(str(row[k]) for k in ("nv", "nu", "sensors")) if "nv" in row else ""
        error = f"{row['worst']:.1e}" if row["result"] in ("right", "chaotic", "wrong") else ""
        said = f"{row['result']}: {row['message'].replace('|', '/')}" if "message" in row else row["result"]
        lines.append(f"| {row['package']} | {row['model']} | {said} | {sizes} | {error} | {row.get('first_s', '')} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
