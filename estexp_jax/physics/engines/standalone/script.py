"""`explained.py`: what was found as one file beside plain MuJoCo and NumPy, or MJX, which needs nothing else."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import BodyForce, CommandLaw, Effect, Term
from estexp_jax.physics.effects.changes import Change, sentence_of
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.sites import driven_actuators
from estexp_jax.physics.engines.c.batches import lane_fields
from estexp_jax.physics.engines.c.numpy_operations import UnknownOperation
from estexp_jax.physics.engines.standalone import (
    law_text,
    runtime,
    runtime_laws,
    runtime_memory,
    runtime_mjx,
    runtime_sites,
    runtime_step,
)
from estexp_jax.physics.engines.standalone.assignments import assignments
from estexp_jax.physics.engines.standalone.places import (
    Marked,
    by_effect,
    changes_in_order,
    delayed_commands,
    displayed_variables,
    faulty_readings,
    places_of,
)
from estexp_jax.physics.engines.standalone.runtime import LawPlace
from estexp_jax.physics.model.robot import Robot

_PARTS = (runtime, runtime_memory, runtime_sites, runtime_laws, runtime_step, runtime_mjx)
_OWN_IMPORT = re.compile(r"from estexp_jax\.[\w.]+ import (\([^)]*\)|[^\n]*)\n", re.MULTILINE)
_TOP_IMPORT = re.compile(r"^(?:import|from) .*\n", re.MULTILINE)


def explained_script(robot: Robot, changes: Marked, finer: int, file: mujoco.MjModel | None) -> str:
    """The file's text.

    Args:
        robot: the nominal robot.
        changes: what was found, and what was refitted beside it.
        finer: part of the robot's step that its simulator takes.
        file: the compiled model_explained.xml; None: there is none.

    What does something that has no text, as a law of a user's own may, is left out, and named.
    """
    ordered, functions, laws = changes_in_order(changes), list[str](), list[str]()
    lacking = [c for c, _ in ordered if not _has_text(robot, c)]
    ordered = [(c, native) for c, native in ordered if c not in lacking]
    where_of = dict[tuple[str, int], tuple[int, int]]()
    for e, own in by_effect(ordered):
        if isinstance(e, Term | CommandLaw | BodyForce):
            places, elements = places_of(robot, e, own)
            functions.append(_function(robot, e, [c for c, _ in own]))
            where_of |= {(e.name, element): (len(laws), i) for i, element in enumerate(elements)}
            laws.append(_law(e, places))
    effects = [effect(c.effect) for c, _ in ordered]
    tables = {
        "laws": laws,
        "edits": _calls(assignments(robot, ordered)),
        "delayed": _calls(delayed_commands(robot, ordered)),
        "readings": _calls(faulty_readings(robot, ordered)),
        "displayed": _calls(displayed_variables(robot, effects, where_of)),
    }
    found = [f"    {name}=(\n{_indented(rows)}    ),\n" for name, rows in tables.items() if rows]
    values: dict[str, Any] = {"substeps": finer, "joints": robot.names("joint"), "motors": _motors(robot)}
    if file is not None and (differs := _difference(robot.model, file)) is not None:
        values["file_differs"] = differs
    found += [f"    {name}={value!r},\n" for name, value in values.items()]
    table = f"FOUND = Found(\n{''.join(found)})\n"
    head, imports = _heading(robot, ordered, lacking), "\n".join(_import_lines())
    return "\n".join([head, f"{imports}\n", *functions, _runtime(), table, _DOORS])


def _has_text(robot: Robot, change: Change) -> bool:
    e = effect(change.effect)
    try:
        if isinstance(e, Term | CommandLaw | BodyForce):
            _function(robot, e, [change])
        faulty_readings(robot, [(change, False)])
    except UnknownOperation:
        return False
    return True


def _motors(robot: Robot) -> tuple[tuple[str, str], ...]:
    """All motors that laws know of, each with its joint."""
    pairs = ((a, robot.joint_of_actuator(a)) for a in driven_actuators(robot))
    return tuple((robot.names("actuator")[a], robot.names("joint")[j]) for a, j in pairs if j is not None)


def _indented(rows: Sequence[str]) -> str:
    return "".join(f"        {line}\n" for row in rows for line in f"{row},".split("\n"))


def _function(robot: Robot, e: Any, changes: Sequence[Change]) -> str:
    """The text of an effect's law, with what it says."""
    name = _name(e)
    if isinstance(e, Term):
        text = law_text.term_text(e, name)
    else:
        text = law_text.command_text(e, name) if isinstance(e, CommandLaw) else law_text.body_text(e, name)
    head, rest = text.split("\n", 1)
    sentences = "; ".join(sentence_of(robot, c) for c in changes)
    text = f'{head}\n    """{sentences[:1].upper() + sentences[1:]}.\n\n    {e.equation}\n    """\n{rest}'
    if not isinstance(e, BodyForce) and e.n_states:
        text += "\n\n" + law_text.rest_text(e, name)
    return "\n" + text


def _law(e: Any, places: Sequence[LawPlace]) -> str:
    kind = "command" if isinstance(e, CommandLaw) else "body" if isinstance(e, BodyForce) else "joint"
    rest = f"{_name(e)}_at_rest" if getattr(e, "n_states", 0) else "None"
    lines = "".join(f"        {call},\n" for call in _calls(places))
    return f'Law(\n    "{kind}",\n    {_name(e)},\n    {rest},\n    (\n{lines}    ),\n)'


def _name(e: Effect) -> str:
    return re.sub(r"\W", "_", e.name)


def _calls(rows: Sequence[Any]) -> list[str]:
    """Tuples as calls that name what differs from their defaults."""
    calls = []
    for x in rows:
        defaults = type(x)._field_defaults
        given = [f"{k}={v!r}" for k, v in x._asdict().items() if k not in defaults or v != defaults[k]]
        calls.append(f"{type(x).__name__}({', '.join(given)})")
    return calls


def _difference(nominal: mujoco.MjModel, file: mujoco.MjModel) -> tuple[str, tuple[int, ...], float] | None:
    """A number that only the file's model has; None where both are alike."""
    for name in lane_fields():
        if name.startswith(("opt.", "name", "bvh")):
            continue
        own, theirs = (np.asarray(getattr(m, name)) for m in (nominal, file))
        if own.dtype.kind not in "fiu" or (own.shape == theirs.shape and np.array_equal(own, theirs)):
            continue
        n = min(len(own), len(theirs)) if own.ndim else 0
        changed = (
            np.argwhere(own[:n] != theirs[:n]) if own.shape[1:] == theirs.shape[1:] and own.ndim else np.zeros((0, 1))
        )
        if len(changed):
            at = tuple(int(i) for i in changed[0])
            return name, at, theirs[at].item()
        if own.ndim and len(theirs) > len(own):
            at = (len(own), *(0 for _ in theirs.shape[1:]))
            return name, at, theirs[at].item()
    return None


def _heading(robot: Robot, changes: Marked, lacking: Sequence[Change]) -> str:
    lines = [
        f'"""What recordings of {Path(robot.source).name} show that the model lacks, over plain MuJoCo and NumPy.',
        "",
        "Over nominal.xml, or your own model, it adds all of it, as the simulator that found it does. Over",
        "model_explained.xml it adds what that file cannot hold.",
        "",
        '    model = mujoco.MjModel.from_xml_path("nominal.xml")',
        "    data = mujoco.MjData(model)",
        "    explained.install(model, data)",
        "    while ...:",
        "        data.ctrl[:] = ...",
        "        explained.step(model, data)  # instead of mujoco.mj_step",
        "",
        "A mujoco.batch.Batch stands in the place of data, with its own model: install(batch.model, batch). For MJX",
        "see mjx_simulation. After mj_resetData, call install again: what was remembered is forgotten.",
        "",
        "In it:",
        *(f"- {sentence_of(robot, c)}{'' if native else ' (not in model_explained.xml)'}" for c, native in changes),
        *(f"- NOT in it: {sentence_of(robot, c)}" for c in lacking),
        '"""',
    ]
    return "\n".join(lines) + "\n"


def _source(part: Any) -> str:
    return Path(part.__file__).read_text(encoding="utf-8")


def _import_lines() -> list[str]:
    """The imports of all parts, once each: of the future, of the language, of others."""
    modules, names = dict[str, None](), dict[str, set[str]]()
    for part in _PARTS:
        for line in _TOP_IMPORT.findall(_OWN_IMPORT.sub("", _source(part))):
            if taken := re.match(r"from (\S+) import (.*)", line):
                names.setdefault(taken.group(1), set()).update(taken.group(2).split(", "))
            else:
                modules[line.rstrip()] = None
    own = [f"from {module} import {', '.join(sorted(some))}" for module, some in sorted(names.items())]
    outside = [line for line in modules if "mujoco" in line or "numpy" in line]
    return [own[0], "", *(x for x in modules if x not in outside), *own[1:], "", *sorted(outside)]


def _runtime() -> str:
    """The parts that are the same in every file, without what they import."""
    texts = []
    for part in _PARTS:
        text = _OWN_IMPORT.sub("", _source(part))
        text = _TOP_IMPORT.sub("", text)
        title, text = re.match(r'"""(.*?)"""\n', text, re.DOTALL), re.sub(r'^""".*?"""\n', "", text, flags=re.DOTALL)
        first = title.group(1).split("\n")[0] if title else ""
        texts.append(f"# {first}\n\n\n{text.strip()}\n")
    return "\n\n" + "\n\n".join(texts) + "\n"


_DOORS = '''
def install(model, data):
    """Begin: data is an MjData, or a mujoco.batch.Batch of this model. The model gets the values that were found."""
    return installed(FOUND, model, data)


def step(model, data, on=None):
    """One step with all that was found, instead of mj_step; gives the readings, as sensors show them.

    on: 1.0 or 0.0 for each motor, where some are switched off.
    """
    return stepped(model, data, on)


def mjx_simulation(model):
    """For MJX: (model to put on the device, memory, step) with step(mx, dx, memory) -> (dx, memory)."""
    return simulation_of_mjx(FOUND, model)
'''
