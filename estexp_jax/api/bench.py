"""`bench`, from Python and as the command: this machine's simulation speed, every engine on the same robots."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from estexp_jax.api.options.bench import BenchOptions
from estexp_jax.benchmark.measure import BenchConfig, measure, quick_bench
from estexp_jax.report.bench.figures import bench_figure
from estexp_jax.report.bench.result import BenchResult
from estexp_jax.runs import ProgressDisplay, open_run, write_json
from estexp_jax.runs.files import replacing


class WrittenBench(NamedTuple):
    """What `bench_to_folder` measured, and where it is."""

    result: BenchResult
    json_file: Path
    figure: Path


def bench_to_folder(options: BenchOptions) -> WrittenBench:
    """Measure with progress, and write `bench.json`, `bench.png` and `bench.svg`.

    Raises:
        InputError: the model cannot be used, or the folder.
    """
    names = ("feet", "population", "steps", "substeps", "repeats", "sweep", "explain", "seed")
    model = None if options.model is None else str(options.model)
    config = BenchConfig(model=model, **{name: getattr(options, name) for name in names})
    config = quick_bench(config) if options.quick else config
    config.races()  # refuses what cannot be used before anything is written
    marker = {"command": "bench", "config": vars(config)}
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    with ProgressDisplay() as progress:
        result = measure(config, progress)
    json_file = folder.file("bench.json")
    write_json(json_file, result)
    figure = bench_figure(result)
    for ending in ("png", "svg"):
        with replacing(folder.file(f"bench.{ending}")) as stream:
            figure.savefig(stream, format=ending, dpi=150)
    return WrittenBench(BenchResult(result), json_file, folder.path / "bench.png")
