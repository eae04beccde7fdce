"""Writes docs/effects_reference.md from the registry: `python docs/generate_effects.py`; a test compares the two."""

from collections.abc import Iterator
from inspect import cleandoc, getdoc
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from estexp_jax.package_data import model_path
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.effects.registry import every
from estexp_jax.physics.effects.written import written
from estexp_jax.physics.model.robot import Robot

PAGE = Path(__file__).with_name("effects_reference.md")
PICTURES = Path(__file__).with_name("signatures")
_HEAD = """# Effects

What can be planted, found and recovered from. Each `estexp record ...` plants the effect in a model that the package
brings, for something to try `estexp explain` on; the picture shows what it does to the reading on which it acts most,
over the same commands. Values are in SI units and radians. One of your own: [Writing an effect](effects.md).
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
        "In MJCF": _elements(e) if e.in_mjcf else "no: `ee.load_explained` simulates it",
        "Contains": f"`{e.nested_in}`" if e.nested_in else "",
        "Other forms": ", ".join(f"`{name}`" for name in variants),
        "Source": e.source,
    }
    lines = [f"- {name}: {fact}" for name, fact in facts.items() if fact]
    return "\n".join([f"### {e.name}\n", f"{first}\n", *lines, *_example(e)]) + "\n"


def _example(e: Effect) -> list[str]:
    """A planted example, what it says, and its picture where there is one."""
    found = planted(e)
    if found is None:
        return []
    name, _, site, values = found
    place = f"@{site}" if site else ""
    text = " ".join([f"{e.name}{place}", *(f"{k}={v:g}" for k, v in values.items())])
    lines = [
        f"- Example: {e.sentence(site, values)}",
        f'\n```sh\nestexp record models/{name}.xml --effect "{text}" --out logs\n```',
    ]
    if (PICTURES / f"{e.name}.svg").exists():
        lines.append(f"\n![A reading without and with {e.name.replace('_', ' ')}](signatures/{e.name}.svg)")
    return lines


def planted(e: Effect) -> tuple[str, Robot, str, dict[str, float]] | None:
    """The first shipped robot that has a place for an effect, its name before it, the place, and values."""
    for name in _ROBOTS:
        robot = Robot.from_xml(model_path(name))
        for site in reversed(e.sites(robot)):
            values = _values(e, robot, site)
            if site != "*" and values is not None:
                return name, robot, site, values
    return None


def _elements(e: Effect) -> str:
    """What the example adds to the robot's MJCF, else which attributes it changes."""
    found = planted(e)
    if found is None:
        return "yes"
    _, robot, site, values = found
    before, after = (_parts(robot, changes) for changes in ((), (Change(e.name, site or None, values),)))
    if lost := sorted({name.rpartition(" ")[0] for name, attribute in before - after if not attribute}):
        return "takes away " + ", ".join(f"`{name}`" for name in lost)
    own = sorted({name.rpartition(" ")[0] for name, attribute in after - before if not attribute})
    if own:
        return "adds " + ", ".join(f"`{name}`" for name in own)
    changed = sorted({f"{name.rpartition(' ')[0]}/{attribute.partition('=')[0]}" for name, attribute in after - before})
    return ", ".join(f"`{name}`" for name in changed) or "yes"


def _parts(robot: Robot, changes: tuple[Change, ...]) -> set[tuple[str, str]]:
    """Each element of the MJCF by its kind and name, alone and with each attribute that it has."""
    spec = written(robot, changes)
    spec.compile()
    return set(_inside(ElementTree.fromstring(spec.to_xml()), ""))


def _inside(element: ElementTree.Element, above: str) -> Iterator[tuple[str, str]]:
    kind = "actuator" if above == "actuator" else element.tag
    name = f"{kind} {element.get('name', '')}"
    yield name, ""
    yield from ((name, f"{attribute}={value}") for attribute, value in element.items())
    for child in element:
        yield from _inside(child, element.tag)


def _values(e: Effect, robot: Robot, site: str) -> dict[str, float] | None:
    found = {}
    for index, (p, (low, high)) in enumerate(zip(e.parameters, e.bounds(robot, site), strict=True)):
        if not np.isfinite((low, high)).all():
            return None
        inside = low <= p.neutral < high
        value = p.neutral + 0.15 * (high - p.neutral) if inside else low + 0.3 * (high - low)
        found[p.name] = _other(e, robot, site, index) if p.refers else min(max(float(f"{value:.2g}"), low), high)
    return found


def _other(e: Effect, robot: Robot, site: str, index: int) -> float:
    """The first element that a parameter may refer to at a place, by what the effect guesses without recordings."""
    try:
        return float(e.initial_guesses(robot, site, None)[0][index])
    except AttributeError:  # it looks at recordings
        return 1.0


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
