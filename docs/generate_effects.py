"""Writes docs/effects_reference.md from the registry: `python docs/generate_effects.py`; a test compares the two."""

from inspect import cleandoc, getdoc
from pathlib import Path

import numpy as np

import estexp_jax as ee
from estexp_jax.package_data import model_path
from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.effects.registry import every

PAGE = Path(__file__).with_name("effects_reference.md")
_HEAD = """# Effects

What can be planted, found and recovered from. Each `estexp record ...` plants the effect in a model that the package
brings, for something to try `estexp explain` on. Values are in SI units and radians. One of your own:
[Writing an effect](effects.md).
"""
_ROBOTS = ("leg", "quadruped")


def reference() -> str:
    """The page as text."""
    shown = [e for e in every() if e.named and e.claimable and not e.variant_of]
    variants = {e.name: [v.name for v in every() if v.variant_of == e.name and v.named] for e in shown}
    kinds = dict.fromkeys(e.kind for e in shown)
    parts = [_HEAD]
    for kind in kinds:
        parts.append(f"## At {'the ' if kind in ('environment', 'recording') else ''}{kind}\n")
        parts += [_entry(e, variants[e.name]) for e in shown if e.kind == kind]
    return "\n".join(parts).rstrip() + "\n"


def _entry(e: Effect, variants: list[str]) -> str:
    first = cleandoc(getdoc(type(e)) or "").partition("\n\n")[0].replace("\n", " ")
    numbers = [f"`{p.name}`" + (f" [{p.unit}]" if p.unit else "") for p in e.parameters]
    facts = {
        "Equation": f"`{e.equation}`",
        "Parameters": ", ".join(numbers) or "none",
        "In MJCF": "yes" if e.in_mjcf else "no: `ee.load_explained` simulates it",
        "Contains": f"`{e.nested_in}`" if e.nested_in else "",
        "Other forms": ", ".join(f"`{name}`" for name in variants),
        "Source": e.source,
    }
    lines = [f"- {name}: {fact}" for name, fact in facts.items() if fact]
    return "\n".join([f"### {e.name}\n", f"{first}\n", *lines, *_example(e)]) + "\n"


def _example(e: Effect) -> list[str]:
    """A planted example on the first shipped robot that has a place for it, and what it says."""
    for name in _ROBOTS:
        robot = ee.Robot.from_xml(model_path(name))
        for site in reversed(e.sites(robot)):
            values = _values(e, e.bounds(robot, site))
            place = f"@{site}" if site else ""
            if site != "*" and values is not None:
                text = " ".join([f"{e.name}{place}", *(f"{k}={v:g}" for k, v in values.items())])
                said = e.sentence(site, values)
                return [
                    f"- Example: {said}",
                    f'\n```sh\nestexp record models/{name}.xml --effect "{text}" --out logs\n```',
                ]
    return []


def _values(e: Effect, bounds: tuple[tuple[float, float], ...]) -> dict[str, float] | None:
    found = {}
    for p, (low, high) in zip(e.parameters, bounds, strict=True):
        if not np.isfinite((low, high)).all():
            return None
        inside = low <= p.neutral < high
        value = p.neutral + 0.15 * (high - p.neutral) if inside else low + 0.3 * (high - low)
        found[p.name] = 1.0 if p.refers else min(max(float(f"{value:.2g}"), low), high)
    return found


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
