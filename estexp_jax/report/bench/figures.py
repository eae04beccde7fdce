"""Figure of a benchmark: each engine's speed relative to the serial baseline, and over the population."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

_COLOURS = {
    "serial": "#777777",
    "serial_open": "#aaaaaa",
    "rollout": "#1f78b4",
    "batch": "#6baed6",
    "mjx": "#e6a12a",
    "lanes": "#1b9e77",
}
_OTHER = "#555555"
_NAMES = {
    "serial": "C, one at a time",
    "serial_open": "C, one at a time,\nno controller",
    "rollout": "C, all cores,\nopen loop",
    "batch": "C, all cores,\nclosed loop",
    "mjx": "MJX",
    "lanes": "lanes",
}


def bench_figure(result: Mapping[str, Any]) -> Any:
    """Bars of ratios to the serial baseline, a panel for each number of physics steps, and the sweep, if any.

    Args:
        result: the contents of `bench.json`.

    Returns:
        A matplotlib figure, drawn without a display.
    """
    from matplotlib.figure import Figure

    races, swept = [result, *result.get("also", [])], result.get("sweep") or []
    figure = Figure(figsize=(0.8 + 3.9 * len(races) + (4.8 if swept else 0.0), 3.6), layout="constrained")
    widths = [1.0] * len(races) + ([1.15] if swept else [])
    panels = figure.subplots(1, len(widths), squeeze=False, width_ratios=widths)[0]
    before: list[str] = []
    for axes, race in zip(panels, races, strict=False):
        names = _draw_ratios(axes, race)
        axes.tick_params(labelleft=names != before)
        before = names
    if swept:
        _draw_sweep(panels[-1], swept, result)
    title, versions = f"{result['model']}, {result['population']} robots", result.get("versions", {})
    machine = f"{versions.get('cpu', 'unknown processor')}, {result.get('cores', '?')} cores"
    figure.suptitle(f"{title}; {machine}", fontsize=10)
    return figure


def _draw_ratios(axes: Any, race: Mapping[str, Any]) -> list[str]:
    """Draw the bars; returns the names of their engines."""
    entries = [e for e in race["engines"] if e["ratio_to_serial"] is not None]
    ratios = [e["ratio_to_serial"] for e in entries]
    colours = [_COLOURS.get(e["name"], _OTHER) for e in entries]
    places = range(len(entries), 0, -1)
    axes.barh(places, ratios, color=colours, height=0.7)
    for place, entry, ratio in zip(places, entries, ratios, strict=True):
        times = f"{ratio:.1f}" if ratio < 10 else f"{ratio:.0f}"
        axes.text(ratio, place, f" {times}x, {_short(entry['robot_steps_per_s'])}/s", va="center", fontsize=8)
    axes.set_yticks(places, [_NAMES.get(e["name"], e["name"]) for e in entries], fontsize=8)
    axes.set_xlim(0.0, 1.45 * max(ratios, default=1.0))
    axes.axvline(1.0, color="0.6", linewidth=0.8, linestyle=":")
    axes.set_xlabel("times serial C with its controller")
    steps = race["substeps"]
    axes.set_title(f"{steps} physics step{'s' if steps > 1 else ''} a control step", fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    return [e["name"] for e in entries]


def _draw_sweep(axes: Any, swept: Sequence[Mapping[str, Any]], result: Mapping[str, Any]) -> None:
    for name in dict.fromkeys(point["engine"] for point in swept):
        line = [p for p in swept if p["engine"] == name]
        x, y = [p["robots"] for p in line], [p["robot_steps_per_s"] for p in line]
        label = str(_NAMES.get(name, name)).replace("\n", " ")
        axes.plot(x, y, "o-", color=_COLOURS.get(name, _OTHER), markersize=3.5, linewidth=1.4, label=label)
    serial = next((e["robot_steps_per_s"] for e in result["engines"] if e["name"] == "serial"), None)
    if serial is not None:
        axes.axhline(serial, color=_COLOURS["serial"], linestyle=":", label=_NAMES["serial"])
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
    axes.yaxis.set_major_formatter(lambda y, _: _short(y))
    axes.set_xlabel("robots")
    axes.set_ylabel("robot steps/s")
    steps = result["substeps"]
    axes.set_title(f"over the population, {steps} physics step{'s' if steps > 1 else ''} a control step", fontsize=9)
    axes.grid(visible=True, which="major", color="0.9")
    axes.set_axisbelow(True)
    axes.legend(fontsize=8, frameon=False)
    axes.spines[["top", "right"]].set_visible(False)


def _short(rate: float) -> str:
    """1.2 M, 345 k."""
    return f"{rate / 1e6:.3g} M" if rate >= 1e6 else f"{rate / 1e3:.0f} k" if rate >= 1e3 else f"{rate:.0f}"
