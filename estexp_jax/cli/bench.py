"""`estexp bench`: this machine's simulation speed, side by side with the serial baseline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro


@dataclass(frozen=True)
class Options:
    """Measure how fast this machine simulates: serial C, C on all cores, MJX and lanes, in turns, on the same robots.

    No engine is timed before its physics has been compared with the C engine's. Writes bench.json, bench.png and
    bench.svg. A quiet machine gives truer numbers; some minutes, with --sweep some more.

    Example:
        estexp bench --out out/bench --sweep
    """

    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Where the results go."""
    model: Annotated[Path | None, tyro.conf.arg(metavar="MODEL.xml")] = None
    """Another robot than the quadruped: an MJCF that can walk, with motors and with touch or jointpos sensors."""
    feet: bool = False
    """The quadruped with its four feet as only contacts."""
    sweep: bool = False
    """Go through populations from 1 to 6400 as well."""
    population: int = 200
    """Robots."""
    steps: int = 1000
    """Control steps."""
    substeps: tuple[int, ...] = ()
    """Physics steps a control step; one race for each. Default: as shipped (the quadruped: 4), and 1."""
    repeats: int = 5
    """How often each engine is timed; medians count."""
    seed: int = 0
    """Of controllers and of what differs from robot to robot."""
    quick: bool = False
    """Few robots, few steps: shows that everything works, measures little."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted bench; its numbers belong together, so it is done again."""


def run(options: Options) -> int:
    """Measure, print, and write.

    Raises:
        InputError: the model or a number cannot be used, or DIR.
    """
    from estexp_jax.api.bench import BenchConfig, bench, quick
    from estexp_jax.report.bench.figures import bench_figure
    from estexp_jax.runs import ProgressDisplay, open_run, write_json
    from estexp_jax.runs.files import replacing

    names = ("feet", "population", "steps", "substeps", "repeats", "sweep", "seed")
    model = None if options.model is None else str(options.model)
    config = BenchConfig(model=model, **{name: getattr(options, name) for name in names})
    config = quick(config) if options.quick else config
    config.races()
    marker = {"command": "bench", "config": vars(config)}
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    with ProgressDisplay() as progress:
        result = bench(config, progress)
    numbers = folder.file("bench.json")
    write_json(numbers, result)
    figure = bench_figure(result)
    for ending in ("png", "svg"):
        with replacing(folder.file(f"bench.{ending}")) as stream:
            figure.savefig(stream, format=ending, dpi=150)
    _print(result)
    print(f"Numbers: {numbers}\nFigure: {folder.path / 'bench.png'}")
    return 0


_COLUMNS: dict[str, tuple[str, str]] = {
    "robot_steps_per_s": ("steps/s", ",.0f"),
    "ratio_to_serial": ("x serial", ".2f"),
    "ratio_to_c_all_cores": ("x C", ".2f"),
    "compile_s": ("compile", ".1f"),
    "first_result_s": ("first", ".2f"),
    "peak_mb": ("MB", ",.0f"),
}
_LEGEND = (
    "steps/s: robot steps a second. x serial, x C: times the serial baseline, times C on all cores. compile, first: s "
    "from the first call to the first result, with nothing compiled and with programs from the cache. MB: peak memory. "
    "error: median error of velocities after a control step."
)


def _print(result: Mapping[str, Any]) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False)
    for race in (result, *result["also"]):
        steps = race["substeps"]
        title = f"{result['model']}, {result['population']} robots, {steps} physics step(s) a control step"
        table = Table(title=title, title_justify="left", box=box.SIMPLE)
        for name in ("engine", *(name for name, _ in _COLUMNS.values()), "error"):
            table.add_column(name, justify="left" if name == "engine" else "right", no_wrap=True)
        for entry in race["engines"]:
            if entry["refused"] is None:
                table.add_row(*_row(entry))
        console.print(table)
        for entry in race["engines"]:
            if entry["refused"] is not None:
                console.print(f"{entry['name']} was not timed: {entry['refused']}", markup=False, soft_wrap=True)
    print(_LEGEND)
    _print_rest(result)


def _row(entry: Mapping[str, Any]) -> Sequence[str]:
    cells = ["-" if entry.get(key) is None else format(entry[key], form) for key, (_, form) in _COLUMNS.items()]
    return entry["name"], *cells, f"{entry['agreement']['median']:.0e}"


def _print_rest(result: Mapping[str, Any]) -> None:
    for entry in result["engines"]:
        if entry.get("percent_of_peak") is not None:
            work, share = entry["flops_per_robot_step"], entry["percent_of_peak"]
            print(
                f"{entry['name']}: at least {work:,.0f} flops a robot step, {share:.0f} % of this machine's arithmetic"
            )
    if "estimation" in result:
        e = result["estimation"]
        size = f"{e['genomes']} genomes x {e['controllers']} controllers x {e['steps']} x {e['substeps']} steps"
        told = f"{1e3 * e['walks_s']:.0f} ms its walks, {1e3 * e['generation_s']:.0f} ms with preparing and settling"
        print(f"An estimation generation ({size}): {told}")
    shares = [p for p in result.get("sweep", []) if p["share_of_neighbours"] is not None and p["engine"] == "lanes"]
    if shares:
        worst = min(shares, key=lambda p: p["share_of_neighbours"])
        print(f"Lanes over the population: at worst {worst['share_of_neighbours']:.0%} of the rate", end=" ")
        print(f"between its neighbours, at {worst['robots']} robots")
    for note in result["notes"]:
        print(f"- {note}")
