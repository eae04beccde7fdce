"""`bench.json` as tables and sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from estexp_jax.report.tables import TextTable

_COLUMNS: dict[str, tuple[str, str]] = {
    "robot_steps_per_s": ("steps/s", ",.0f"),
    "ratio_to_serial": ("x serial", ".2f"),
    "ratio_to_c_all_cores": ("x C", ".2f"),
    "compile_s": ("compile", ".1f"),
    "first_result_s": ("first", ".2f"),
    "peak_mb": ("MB", ",.0f"),
}
BENCH_LEGEND = (
    "steps/s: robot steps a second. x serial, x C: times the serial baseline, times C on all cores. compile, first: s "
    "from the first call to the first result, with nothing compiled and with programs from the cache. MB: peak memory. "
    "error: median error of velocities after a control step."
)
"""What the columns mean."""


def bench_tables(result: Mapping[str, Any]) -> Iterator[tuple[TextTable, list[str]]]:
    """A table for each number of physics steps, and a sentence on each engine that was not timed."""
    header = ("engine", *(name for name, _ in _COLUMNS.values()), "error")
    for race in (result, *result["also"]):
        steps = race["substeps"]
        title = f"{result['model']}, {result['population']} robots, {steps} physics step(s) a control step"
        timed = [_row(entry) for entry in race["engines"] if entry["refused"] is None]
        refused = [entry for entry in race["engines"] if entry["refused"] is not None]
        yield (
            TextTable(title, header, timed),
            [f"{entry['name']} was not timed: {entry['refused']}" for entry in refused],
        )


def explaining_table(result: Mapping[str, Any]) -> TextTable | None:
    """Times and memory of explaining shipped logs, None where they were not measured."""
    if not result.get("explain"):
        return None
    header = ("concealed", "found", "cold s", "warm s", "MB", "sysid s", "sysid MB", "x sysid")
    rows = []
    for entry in result["explain"]:
        sysid = entry["sysid"] or {"wall_s": None, "peak_mb": None}
        values = (entry["cold_s"], entry["wall_s"], entry["peak_mb"], *(sysid[k] for k in ("wall_s", "peak_mb")))
        cells = ["-" if value is None else f"{value:,.0f}" for value in values]
        ratio = "-" if entry["ratio_to_sysid"] is None else f"{entry['ratio_to_sysid']:.1f}"
        rows.append((entry["effect"], ", ".join(entry["found"]) or entry["verdict"], *cells, ratio))
    return TextTable("Explaining, whole commands in processes of their own, medians", header, rows)


def _row(entry: Mapping[str, Any]) -> tuple[str, ...]:
    cells = ["-" if entry.get(key) is None else format(entry[key], form) for key, (_, form) in _COLUMNS.items()]
    return entry["name"], *cells, f"{entry['agreement']['median']:.0e}"


def bench_sentences(result: Mapping[str, Any]) -> Iterator[str]:
    """What the tables do not show: work of a step, the estimation phase, the sweep, and notes."""
    for entry in result["engines"]:
        if entry.get("percent_of_peak") is not None:
            work, share = f"{entry['flops_per_robot_step']:,.0f}", f"{entry['percent_of_peak']:.0f}"
            yield f"{entry['name']}: at least {work} flops a robot step, {share} % of this machine's arithmetic"
    if "estimation" in result:
        e = result["estimation"]
        size = f"{e['genomes']} genomes x {e['controllers']} controllers x {e['steps']} x {e['substeps']} steps"
        times = f"{1e3 * e['walks_s']:.0f} ms its walks, {1e3 * e['generation_s']:.0f} ms with preparing and settling"
        yield f"An estimation generation ({size}): {times}"
    shares = [p for p in result.get("sweep", []) if p["share_of_neighbours"] is not None and p["engine"] == "lanes"]
    if shares:
        worst = min(shares, key=lambda p: p["share_of_neighbours"])
        rate = f"at worst {worst['share_of_neighbours']:.0%} of the rate between its neighbours"
        yield f"Lanes over the population: {rate}, at {worst['robots']} robots"
    if any(entry["sysid"] is None for entry in result.get("explain", ())):
        yield "mujoco.sysid is not installed: pip install 'mujoco[sysid]'"
    yield from (f"- {note}" for note in result["notes"])
